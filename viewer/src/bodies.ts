// The bodies as three.js meshes: one mesh a body, positions changed in place.
import * as three from "three";
import { amountColour, bodyColour, niceAbove, type Colour } from "./colours";
import type { Arrays, Binary, BodyInfo, Stage } from "./protocol";

export type Colouring = "body" | "depth" | "displacement";

const untouched: Colour = [0.92, 0.92, 0.93];

class BodyMesh {
  readonly front: three.Mesh<three.BufferGeometry, three.MeshLambertMaterial>;
  readonly back: three.Mesh<three.BufferGeometry, three.MeshBasicMaterial>;
  readonly begin: number;
  readonly colour: Colour;
  private readonly corners: Uint32Array;
  private readonly smooth: boolean;

  constructor(readonly info: BodyInfo, index: number, rest: Float32Array, triangles: Int32Array) {
    const [begin, end] = info.vertices;
    this.begin = begin;
    this.colour = info.color ?? (info.rigid ? [0.72, 0.72, 0.74] : bodyColour(index));
    this.corners = Uint32Array.from(triangles.subarray(3 * info.triangles[0], 3 * info.triangles[1]), (v) => v - begin);
    const geometry = new three.BufferGeometry();
    const dynamic = (name: string, values: Float32Array) => {
      const attribute = new three.BufferAttribute(values, 3);
      attribute.setUsage(three.DynamicDrawUsage);
      geometry.setAttribute(name, attribute);
    };
    dynamic("position", rest.slice(3 * begin, 3 * end));
    dynamic("normal", new Float32Array(3 * (end - begin)));
    dynamic("color", new Float32Array(3 * (end - begin)));
    geometry.setIndex(new three.BufferAttribute(this.corners, 1));
    this.smooth = isRound(this.corners, this.positions(geometry));
    this.front = new three.Mesh(
      geometry,
      new three.MeshLambertMaterial({ vertexColors: true, flatShading: !this.smooth, side: three.FrontSide }),
    );
    // Seen only through a cut: the inside of the skin in one flat colour looks like the cut through the body.
    this.back = new three.Mesh(
      geometry,
      new three.MeshBasicMaterial({ color: new three.Color().setRGB(...this.colour, three.SRGBColorSpace).multiplyScalar(0.6), side: three.BackSide }),
    );
    this.front.frustumCulled = this.back.frustumCulled = false;
    this.front.userData["body"] = index;
    this.update(this.positions(geometry).slice());
  }

  private positions(geometry: three.BufferGeometry): Float32Array {
    return geometry.getAttribute("position").array as Float32Array;
  }

  update(values: Float32Array): void {
    const geometry = this.front.geometry;
    this.positions(geometry).set(values);
    geometry.getAttribute("position").needsUpdate = true;
    if (!this.smooth) return;
    sumNormals(this.corners, values, geometry.getAttribute("normal").array as Float32Array);
    geometry.getAttribute("normal").needsUpdate = true;
  }

  setOpacity(opacity: number, cut: boolean): void {
    this.front.visible = opacity > 0;
    this.back.visible = opacity > 0 && cut;
    for (const material of [this.front.material, this.back.material]) {
      material.transparent = opacity < 1;
      material.opacity = opacity;
      material.depthWrite = opacity >= 1;
      material.needsUpdate = true;
    }
  }
}

/** Normals of vertices, weighted by area; the shader brings them to unit length. */
function sumNormals(corners: Uint32Array, p: Float32Array, normals: Float32Array): void {
  normals.fill(0);
  for (let t = 0; t < corners.length; t += 3) {
    const a = 3 * corners[t]!;
    const b = 3 * corners[t + 1]!;
    const c = 3 * corners[t + 2]!;
    const ux = p[b]! - p[a]!, uy = p[b + 1]! - p[a + 1]!, uz = p[b + 2]! - p[a + 2]!;
    const vx = p[c]! - p[a]!, vy = p[c + 1]! - p[a + 1]!, vz = p[c + 2]! - p[a + 2]!;
    const nx = uy * vz - uz * vy, ny = uz * vx - ux * vz, nz = ux * vy - uy * vx;
    for (const i of [a, b, c]) {
      normals[i] = normals[i]! + nx;
      normals[i + 1] = normals[i + 1]! + ny;
      normals[i + 2] = normals[i + 2]! + nz;
    }
  }
}

/** Whether a body is meant to be smooth: none of it is quite flat, as boxes are, and its triangles turn little. */
function isRound(corners: Uint32Array, p: Float32Array): boolean {
  const flatAngle = 0.01;
  const flatShare = 0.05;
  const roundAngle = 0.6;
  const normals = new Float32Array(p.length);
  sumNormals(corners, p, normals);
  const at = (values: Float32Array, i: number) => new three.Vector3().fromArray(values, 3 * i);
  let sum = 0;
  let flat = 0;
  for (let t = 0; t < corners.length; t += 3) {
    const [a, b, c] = [corners[t]!, corners[t + 1]!, corners[t + 2]!];
    const face = at(p, b).sub(at(p, a)).cross(at(p, c).sub(at(p, a)));
    for (const corner of [a, b, c]) {
      const angle = face.angleTo(at(normals, corner));
      sum += angle;
      if (angle < flatAngle) ++flat;
    }
  }
  return flat < flatShare * corners.length && sum < roundAngle * corners.length;
}

export class BodySet {
  readonly group = new three.Group();
  readonly meshes: BodyMesh[];
  readonly rest: Float32Array;
  readonly positions: Float32Array;
  readonly depths: Float32Array;
  colouring: Colouring = "body";
  /** End of the scale of colours, in length units. */
  scale = 0;
  private plane: three.Plane | null = null;
  private isCut: (body: number) => boolean = () => false;
  private readonly opacities: number[];

  constructor(stage: Binary<Stage>) {
    this.rest = stage.arrays["rest"] as Float32Array;
    this.positions = this.rest.slice();
    this.depths = new Float32Array(this.rest.length / 3);
    const triangles = stage.arrays["triangles"] as Int32Array;
    this.meshes = stage.header.bodies.map((info, i) => new BodyMesh(info, i, this.rest, triangles));
    this.opacities = this.meshes.map(() => 1);
    for (const mesh of this.meshes) this.group.add(mesh.front, mesh.back);
    this.cut(null);
    this.colour();
  }

  update(arrays: Arrays): void {
    this.positions.set(arrays["positions"] as Float32Array);
    for (const mesh of this.meshes) {
      const [begin, end] = mesh.info.vertices;
      mesh.update(this.positions.subarray(3 * begin, 3 * end));
    }
    this.takeDepths(arrays);
    if (this.colouring !== "body") this.colour();
  }

  private takeDepths(arrays: Arrays): void {
    const contacts = arrays["contacts"];
    const places = arrays["contact_places"];
    if (!contacts || !places) return;
    this.depths.fill(0);
    for (let c = 0; c < places.length / 2; ++c) {
      const vertex = places[2 * c]!;
      if (vertex >= 0) this.depths[vertex] = Math.max(this.depths[vertex]!, contacts[7 * c + 6]!);
    }
  }

  displacement(vertex: number): number {
    const i = 3 * vertex;
    const p = this.positions;
    const q = this.rest;
    return Math.hypot(p[i]! - q[i]!, p[i + 1]! - q[i + 1]!, p[i + 2]! - q[i + 2]!);
  }

  /** Amount that is shown at a vertex; 0 with bodies in their own colours. */
  private amount(vertex: number): number {
    if (this.colouring === "depth") return this.depths[vertex]!;
    return this.colouring === "displacement" ? this.displacement(vertex) : 0;
  }

  /** The scale only grows, so that a movie keeps its colours; this starts it anew. */
  setColouring(colouring: Colouring): void {
    this.colouring = colouring;
    this.scale = 0;
    this.colour();
  }

  colour(): void {
    const linear = new three.Color();
    if (this.colouring !== "body") {
      let most = 0;
      for (let v = 0; v < this.depths.length; ++v) most = Math.max(most, this.amount(v));
      this.scale = Math.max(this.scale, niceAbove(most));
    }
    for (const mesh of this.meshes) {
      const attribute = mesh.front.geometry.getAttribute("color");
      const colours = attribute.array as Float32Array;
      for (let i = 0, vertex = mesh.begin; i < colours.length; i += 3, ++vertex) {
        const amount = this.amount(vertex);
        if (this.colouring === "body") {
          colours.set(mesh.colour, i);
        } else if (this.colouring === "depth" && amount === 0) {
          colours.set(untouched, i);
        } else {
          amountColour(amount / (this.scale || 1), colours, i);
        }
        linear.setRGB(colours[i]!, colours[i + 1]!, colours[i + 2]!, three.SRGBColorSpace);
        colours[i] = linear.r;
        colours[i + 1] = linear.g;
        colours[i + 2] = linear.b;
      }
      attribute.needsUpdate = true;
    }
  }

  setOpacity(body: number, opacity: number): void {
    this.opacities[body] = opacity;
    this.meshes[body]?.setOpacity(opacity, this.isCut(body));
  }

  opacity(body: number): number {
    return this.opacities[body] ?? 1;
  }

  /** Leaves out what lies on the negative side of a plane, of the bodies of these names or, of none, of all. */
  cut(plane: three.Plane | null, names: readonly string[] = []): void {
    this.plane = plane;
    this.isCut = (body) => plane !== null && (names.length === 0 || names.includes(this.meshes[body]!.info.name));
    this.meshes.forEach((mesh, i) => {
      mesh.front.material.clippingPlanes = mesh.back.material.clippingPlanes = this.isCut(i) ? [plane!] : [];
      mesh.setOpacity(this.opacities[i]!, this.isCut(i));
    });
  }

  vertex(index: number): three.Vector3 {
    return new three.Vector3().fromArray(this.positions, 3 * index);
  }

  /** The vertex under a ray that is nearest to where it meets the skin that is not cut away. */
  hit(ray: three.Raycaster): { vertex: number; body: number; point: three.Vector3 } | null {
    const seen = this.meshes.filter((m) => m.front.visible).map((m) => m.front);
    for (const mesh of seen) mesh.geometry.computeBoundingSphere();
    const cutAway = (hit: three.Intersection) =>
      this.isCut(hit.object.userData["body"] as number) && this.plane!.distanceToPoint(hit.point) < 0;
    const found = ray.intersectObjects(seen, false).find((hit) => !cutAway(hit));
    if (!found?.face) return null;
    const body = found.object.userData["body"] as number;
    const begin = this.meshes[body]!.begin;
    const distance = (v: number) => this.vertex(v).distanceToSquared(found.point);
    const corners = [found.face.a, found.face.b, found.face.c].map((v) => v + begin);
    corners.sort((a, b) => distance(a) - distance(b));
    return { vertex: corners[0]!, body, point: found.point };
  }

  dispose(): void {
    for (const mesh of this.meshes) {
      mesh.front.geometry.dispose();
      mesh.front.material.dispose();
      mesh.back.material.dispose();
    }
  }
}
