// Ambient occlusion of vertices: the fraction of the space in front of a vertex that near bodies fill. The
// visible bodies are marked on a coarse grid; for each vertex a few directions around its normal are
// followed.
import type { BodySet } from "./bodies";

const cells = 40;
const reach = 7;  // cells
const directions = hemisphere();

/** Directions about +z, evenly over the hemisphere (Fibonacci's spiral). */
function hemisphere(): [number, number, number][] {
  const count = 10;
  return Array.from({ length: count }, (_, i) => {
    const z = (i + 0.5) / count;
    const r = Math.sqrt(1 - z * z);
    const turn = i * Math.PI * (3 - Math.sqrt(5));
    return [r * Math.cos(turn), r * Math.sin(turn), z];
  });
}

export class Occlusion {
  private readonly grid = new Uint8Array(cells ** 3);
  private lower = [0, 0, 0];
  private perLength = 1;

  /** Writes the light that reaches each vertex, in (0, 1], to `light`. O(vertices). */
  update(bodies: BodySet, light: Float32Array): void {
    this.fill(bodies);
    for (const mesh of bodies.meshes) {
      if (!mesh.front.visible) continue;
      const normals = mesh.normals();
      const [begin, end] = mesh.info.vertices;
      for (let v = begin; v < end; ++v) light[v] = this.lightAt(bodies.positions, v, normals, v - begin);
      smooth(mesh.corners, begin, light);
    }
  }

  private fill(bodies: BodySet): void {
    this.grid.fill(0);
    const p = bodies.positions;
    const upper = [-Infinity, -Infinity, -Infinity];
    this.lower = [Infinity, Infinity, Infinity];
    for (const vertex of bodies.shownVertices()) {
      for (let c = 0; c < 3; ++c) {
        this.lower[c] = Math.min(this.lower[c]!, p[3 * vertex + c]!);
        upper[c] = Math.max(upper[c]!, p[3 * vertex + c]!);
      }
    }
    const size = Math.max(...upper.map((u, c) => u - this.lower[c]!), 1e-30);
    this.perLength = (cells - 1) / size;
    for (const vertex of bodies.shownVertices()) {
      const cell = this.cell(p[3 * vertex]!, p[3 * vertex + 1]!, p[3 * vertex + 2]!);
      if (cell >= 0) this.grid[cell] = 1;
    }
  }

  private cell(x: number, y: number, z: number): number {
    const i = Math.floor((x - this.lower[0]!) * this.perLength);
    const j = Math.floor((y - this.lower[1]!) * this.perLength);
    const k = Math.floor((z - this.lower[2]!) * this.perLength);
    if (i < 0 || j < 0 || k < 0 || i >= cells || j >= cells || k >= cells) return -1;
    return i + cells * (j + cells * k);
  }

  private lightAt(p: Float32Array, vertex: number, normals: Float32Array, own: number): number {
    const [x, y, z] = [p[3 * vertex]!, p[3 * vertex + 1]!, p[3 * vertex + 2]!];
    let [nx, ny, nz] = [normals[3 * own]!, normals[3 * own + 1]!, normals[3 * own + 2]!];
    const size = Math.hypot(nx, ny, nz) || 1;
    nx /= size, ny /= size, nz /= size;
    // Two directions orthogonal to the normal (Duff et al. 2017).
    const sign = nz >= 0 ? 1 : -1;
    const a = -1 / (sign + nz);
    const b = nx * ny * a;
    const step = 1 / this.perLength;
    let taken = 0;
    let all = 0;
    for (const [u, v, w] of directions) {
      const dx = u * (1 + sign * nx * nx * a) + v * b + w * nx;
      const dy = u * sign * b + v * (sign + ny * ny * a) + w * ny;
      const dz = -u * sign * nx - v * ny + w * nz;
      all += w;
      for (let s = 1.8; s < reach; s += 0.9) {
        const cell = this.cell(x + s * step * dx, y + s * step * dy, z + s * step * dz);
        if (cell < 0 || this.grid[cell] === 0) continue;
        taken += w * (1 - s / (1.3 * reach));
        break;
      }
    }
    return 1 - 0.75 * (taken / all);
  }
}

/** Smooths twice: replaces each value by the mean of the vertex and its neighbours, because the grid is coarser than the mesh. */
function smooth(corners: Uint32Array, begin: number, light: Float32Array): void {
  const count = corners.reduce((most, v) => Math.max(most, v), 0) + 1;
  const sums = new Float32Array(count);
  const numbers = new Float32Array(count);
  for (let round = 0; round < 2; ++round) {
    sums.fill(0);
    numbers.fill(0);
    for (let t = 0; t < corners.length; t += 3) {
      const mean = (light[begin + corners[t]!]! + light[begin + corners[t + 1]!]! + light[begin + corners[t + 2]!]!) / 3;
      for (let k = 0; k < 3; ++k) {
        sums[corners[t + k]!] = sums[corners[t + k]!]! + mean;
        numbers[corners[t + k]!] = numbers[corners[t + k]!]! + 1;
      }
    }
    for (let v = 0; v < count; ++v) if (numbers[v]! > 0) light[begin + v] = sums[v]! / numbers[v]!;
  }
}
