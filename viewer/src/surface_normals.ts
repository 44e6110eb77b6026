// Normals of the vertices of a surface, and whether it is meant to be smooth.
import * as three from "three";

/** Normals of vertices, weighted by area; the shader brings them to unit length. */
export function sumNormals(corners: Uint32Array, p: Float32Array, normals: Float32Array): void {
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

/** Whether a body is meant to be smooth: no part of it is flat as in a box, and neighbouring triangles have similar normals. */
export function isRound(corners: Uint32Array, p: Float32Array): boolean {
  const flatAngle = 0.01;
  const flatFraction = 0.05;
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
  return flat < flatFraction * corners.length && sum < roundAngle * corners.length;
}

/** The edges of triangles, each once, as pairs of vertices. */
export function edgesOf(corners: Uint32Array): Uint32Array {
  const seen = new Map<number, [number, number]>();
  for (let t = 0; t < corners.length; t += 3) {
    for (let k = 0; k < 3; ++k) {
      const [a, b] = [corners[t + k]!, corners[t + ((k + 1) % 3)]!].sort((x, y) => x - y) as [number, number];
      seen.set(a * 0x4000000 + b, [a, b]);
    }
  }
  return Uint32Array.from([...seen.values()].flat());
}
