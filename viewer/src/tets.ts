// The inside of the bodies: all points, and the sections of tets with a plane.
import type * as three from "three";
import type { Arrays, BodyInfo, Stage } from "./protocol";

/** Triangles of a section: positions, and an amount at each corner. */
export interface Section {
  positions: Float32Array;
  amounts: Float32Array;
}

/** Corners of tets and of sections are numbered vertices first, then inner points. */
export class Tets {
  private readonly corners: Int32Array;
  private readonly innerRest: Float32Array;
  private inner: Float32Array;
  /** For each body its tets and its inner points. */
  private readonly tets: [number, number][] = [];
  readonly innerPoints: [number, number][] = [];
  readonly vertices: number;

  constructor(stage: { header: Stage; arrays: Arrays }) {
    this.corners = stage.arrays["tets"] as Int32Array;
    this.innerRest = stage.arrays["inner_rest"] as Float32Array;
    this.inner = this.innerRest;
    this.vertices = (stage.arrays["rest"] as Float32Array).length / 3;
    let [tet, point] = [0, this.vertices];
    for (const body of stage.header.bodies) {
      const inside = body.points - size(body);
      this.tets.push([tet, (tet += body.tets)]);
      this.innerPoints.push([point, (point += inside)]);
    }
  }

  /** Copies the positions of inner points if a frame has them; returns whether it has. */
  update(arrays: Arrays): boolean {
    const inner = arrays["inner"] as Float32Array | undefined;
    if (inner) this.inner = inner;
    return inner !== undefined;
  }

  displacement(innerPoint: number): number {
    const i = 3 * (innerPoint - this.vertices);
    const [p, q] = [this.inner, this.innerRest];
    return Math.hypot(p[i]! - q[i]!, p[i + 1]! - q[i + 1]!, p[i + 2]! - q[i + 2]!);
  }

  /** The sections of a body's tets with a plane: triangles and quadrilaterals, as triangles. O(tets). */
  section(body: number, { normal, constant }: three.Plane, positions: Float32Array, amount: (corner: number) => number): Section {
    const places: number[] = [];
    const amounts: number[] = [];
    const value = (corner: number, c: number) =>
      corner < this.vertices ? positions[3 * corner + c]! : this.inner[3 * (corner - this.vertices) + c]!;
    const height = (corner: number) => normal.x * value(corner, 0) + normal.y * value(corner, 1) + normal.z * value(corner, 2) + constant;
    const heights = [0, 0, 0, 0];
    const above: number[] = [];
    const below: number[] = [];
    const meet = (i: number, j: number, tet: number) => {
      const [a, b] = [this.corners[4 * tet + i]!, this.corners[4 * tet + j]!];
      const fraction = heights[i]! / (heights[i]! - heights[j]!);
      for (let c = 0; c < 3; ++c) places.push(value(a, c) + fraction * (value(b, c) - value(a, c)));
      const [low, high] = [amount(a), amount(b)];
      amounts.push(low + fraction * (high - low));
    };
    const [begin, end] = this.tets[body]!;
    for (let tet = begin; tet < end; ++tet) {
      above.length = below.length = 0;
      for (let i = 0; i < 4; ++i) {
        heights[i] = height(this.corners[4 * tet + i]!);
        (heights[i]! >= 0 ? above : below).push(i);
      }
      if (above.length === 0 || below.length === 0) continue;
      if (above.length === 2) {
        const [[a, b], [c, d]] = [above as [number, number], below as [number, number]];
        for (const [i, j] of [[a, c], [a, d], [b, d], [a, c], [b, d], [b, c]] as const) meet(i, j, tet);
      } else {
        for (const i of above) for (const j of below) meet(i, j, tet);
      }
    }
    return { positions: Float32Array.from(places), amounts: Float32Array.from(amounts) };
  }
}

function size(body: BodyInfo): number {
  return body.vertices[1] - body.vertices[0];
}
