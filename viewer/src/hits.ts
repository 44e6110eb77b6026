// The first hit of a ray: the surface that the cut leaves, or a face of the cut.
import * as three from "three";
import type { BodySet } from "./bodies";

/** The body that the ray hits, and its visible vertex nearest to the hit. */
export interface Hit {
  vertex: number;
  body: number;
  point: three.Vector3;
}

export function firstHit(bodies: BodySet, ray: three.Raycaster): Hit | null {
  const skin = hitSkin(bodies, ray);
  const face = hitFace(bodies, ray.ray);
  if (!skin || !face) return skin ?? face;
  const distance = (hit: Hit) => hit.point.distanceToSquared(ray.ray.origin);
  return distance(face) <= distance(skin) ? face : skin;
}

function hitSkin(bodies: BodySet, ray: three.Raycaster): Hit | null {
  const seen = bodies.meshes.filter((m) => m.front.visible).map((m) => m.front);
  for (const mesh of seen) mesh.geometry.computeBoundingSphere();
  const found = ray.intersectObjects(seen, false)[0];
  if (!found?.face) return null;
  const body = found.object.userData["body"] as number;
  const { begin, surface } = bodies.meshes[body]!;
  return nearest(bodies, body, found.point, [found.face.a, found.face.b, found.face.c].map((v) => begin + surface.vertex(v)));
}

/** The hit of a face of the cut: a position where the plane is inside a body. If two bodies overlap, the one drawn last. */
function hitFace(bodies: BodySet, ray: three.Ray): Hit | null {
  const { plane } = bodies;
  const point = plane ? ray.intersectPlane(plane, new three.Vector3()) : null;
  if (!point) return null;
  for (let body = bodies.meshes.length - 1; body >= 0; --body) {
    const mesh = bodies.meshes[body]!;
    if (!mesh.front.visible || !bodies.isCut(body) || !isInside(mesh.corners, bodies.positions, mesh.begin, point, ray.direction)) continue;
    const [begin, end] = mesh.info.vertices;
    const all = Array.from({ length: end - begin }, (_, i) => begin + i);
    const kept = all.filter((v) => bodies.shows(body, bodies.vertex(v)));
    return nearest(bodies, body, point, kept.length > 0 ? kept : all);
  }
  return null;
}

function nearest(bodies: BodySet, body: number, point: three.Vector3, vertices: readonly number[]): Hit {
  const distance = (v: number) => bodies.vertex(v).distanceToSquared(point);
  const vertex = vertices.reduce((best, v) => (distance(v) < distance(best) ? v : best));
  return { vertex, body, point };
}

/**
 * Whether a point is inside of a closed surface: a ray from it crosses an odd number of triangles. Seen along the ray,
 * a triangle has the point where a line to the right of it crosses an odd number of sides. A side says the same to
 * both its triangles, so a ray through an edge or a corner counts as one beside it.
 */
function isInside(corners: Uint32Array, positions: Float32Array, begin: number, point: three.Vector3, direction: three.Vector3): boolean {
  const right = new three.Vector3(...(Math.abs(direction.x) < 0.6 ? [1, 0, 0] as const : [0, 1, 0] as const)).cross(direction).normalize();
  const up = right.clone().cross(direction).normalize();
  const along = direction.clone().normalize();
  const count = corners.reduce((most, v) => Math.max(most, v), 0) + 1;
  const seen = new Float64Array(3 * count);
  const place = new three.Vector3();
  for (let v = 0; v < count; ++v) {
    place.fromArray(positions, 3 * (begin + v)).sub(point);
    seen.set([place.dot(right), place.dot(up), place.dot(along)], 3 * v);
  }
  const crosses = (v: number, w: number): boolean => {
    const [a, b] = v < w ? [3 * v, 3 * w] : [3 * w, 3 * v];
    const [x, y, x2, y2] = [seen[a]!, seen[a + 1]!, seen[b]!, seen[b + 1]!];
    return y > 0 !== y2 > 0 && x - (y * (x2 - x)) / (y2 - y) > 0;
  };
  let inside = false;
  for (let t = 0; t < corners.length; t += 3) {
    const [a, b, c] = [corners[t]!, corners[t + 1]!, corners[t + 2]!];
    if (crosses(a, b) !== crosses(b, c) !== crosses(c, a) && heightAt(seen, a, b, c) > 0) inside = !inside;
  }
  return inside;
}

/** The height above the origin of a triangle's plane. */
function heightAt(seen: Float64Array, a: number, b: number, c: number): number {
  const corner = (v: number) => new three.Vector3().fromArray(seen, 3 * v);
  const first = corner(a);
  const normal = corner(b).sub(first).cross(corner(c).sub(first));
  return normal.dot(first) / normal.z;
}
