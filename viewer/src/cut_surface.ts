// A surface, or the part of it on one side of a plane. Triangles that the plane crosses are cut to pieces
// here: clipping in the shader decides per pixel. For triangles seen from the side it uses a position outside of
// them, which leaves stray pixels and steps. Neighbours have common points at the plane, so that there are no
// gaps between them.
import * as three from "three";

export class CutSurface {
  readonly geometry = new three.BufferGeometry();
  private readonly count: number;
  /** The plane; the part on its negative side is removed. Null: no cut. */
  plane: three.Plane | null = null;
  /** For each point on the plane: the vertex that is kept, the one that is removed, and the fraction of the way from the first to the second. */
  private readonly kept: number[] = [];
  private readonly left: number[] = [];
  private readonly fraction: number[] = [];
  private readonly points = new Map<number, number>();
  private readonly above: Float32Array;
  private whole = false;

  /** @param corners  vertices of the triangles */
  constructor(private readonly corners: Uint32Array, positions: Float32Array) {
    this.count = positions.length / 3;
    this.above = new Float32Array(this.count);
    this.makeRoom(0);
    this.values("position").set(positions);
    this.geometry.setIndex(new three.BufferAttribute(new Uint32Array(2 * corners.length), 1).setUsage(three.DynamicDrawUsage));
    this.update();
  }

  /** 3 numbers for each vertex, then for each point at the plane; "position", "normal" or "color". */
  values(name: string): Float32Array {
    return this.geometry.getAttribute(name)!.array as Float32Array;
  }

  /** Call after positions or the plane have changed. O(triangles) with a cut. */
  update(): void {
    this.kept.length = this.left.length = this.fraction.length = 0;
    if (this.plane || !this.whole) this.cutTriangles(this.plane);
    this.makeRoom(this.kept.length);
    for (const name of ["position", "normal", "color"]) this.fill(name);
  }

  /** Call after values of vertices have changed: interpolates those of the points on the plane. */
  fill(name: string): void {
    const values = this.values(name);
    for (let i = 0; i < this.kept.length; ++i) {
      const [a, b, fraction] = [3 * this.kept[i]!, 3 * this.left[i]!, this.fraction[i]!];
      for (let c = 0; c < 3; ++c) values[3 * (this.count + i) + c] = values[a + c]! + fraction * (values[b + c]! - values[a + c]!);
    }
    this.geometry.getAttribute(name).needsUpdate = true;
  }

  /** The vertex of the body for a vertex of the geometry; for a point on the plane, the vertex that is kept. */
  vertex(index: number): number {
    return index < this.count ? index : this.kept[index - this.count]!;
  }

  private cutTriangles(plane: three.Plane | null): void {
    this.whole = plane === null;
    const index = this.geometry.getIndex()!;
    if (!plane) (index.array as Uint32Array).set(this.corners);
    this.geometry.setDrawRange(0, plane ? this.cutAt(plane, index.array as Uint32Array) : this.corners.length);
    index.needsUpdate = true;
  }

  /** Writes the remaining triangles, and returns the number of their corners. */
  private cutAt({ normal, constant }: three.Plane, index: Uint32Array): number {
    const { above, corners } = this;
    const p = this.values("position");
    for (let v = 0; v < this.count; ++v) above[v] = normal.x * p[3 * v]! + normal.y * p[3 * v + 1]! + normal.z * p[3 * v + 2]! + constant;
    this.points.clear();
    let used = 0;
    for (let t = 0; t < corners.length; t += 3) {
      if (above[corners[t]!]! < 0 && above[corners[t + 1]!]! < 0 && above[corners[t + 2]!]! < 0) continue;
      // The outline of the kept part: three or four corners.
      const outline: number[] = [];
      for (let k = 0; k < 3; ++k) {
        const [v, next] = [corners[t + k]!, corners[t + ((k + 1) % 3)]!];
        if (above[v]! >= 0) outline.push(v);
        if (above[v]! >= 0 !== above[next]! >= 0) outline.push(above[v]! >= 0 ? this.point(v, next) : this.point(next, v));
      }
      for (let k = 2; k < outline.length; ++k) {
        index[used++] = outline[0]!;
        index[used++] = outline[k - 1]!;
        index[used++] = outline[k]!;
      }
    }
    return used;
  }

  /** The point where an edge meets the plane. */
  private point(kept: number, left: number): number {
    const key = kept * this.count + left;
    const known = this.points.get(key);
    if (known !== undefined) return known;
    const point = this.count + this.kept.length;
    this.points.set(key, point);
    this.kept.push(kept);
    this.left.push(left);
    this.fraction.push(this.above[kept]! / (this.above[kept]! - this.above[left]!));
    return point;
  }

  private makeRoom(points: number): void {
    const needed = 3 * (this.count + points);
    const old = this.geometry.getAttribute("position") as three.BufferAttribute | undefined;
    if (old && old.array.length >= needed) return;
    this.geometry.dispose();  // the buffer on the graphics card has the old length
    for (const name of ["position", "normal", "color"]) {
      const values = new Float32Array(needed + (points > 0 ? 3 * Math.ceil(0.5 * points) : 0));
      if (old) values.set(this.values(name).subarray(0, 3 * this.count));
      this.geometry.setAttribute(name, new three.BufferAttribute(values, 3).setUsage(three.DynamicDrawUsage));
    }
  }
}
