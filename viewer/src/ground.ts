// The soft shadow that the bodies cast straight down on a ground just below them.
import * as three from "three";
import type { BodySet } from "./bodies";

const side = 48;

export class Ground {
  private readonly pixels = new Uint8Array(4 * side * side);
  private readonly texture = new three.DataTexture(this.pixels, side, side);
  readonly object: three.Mesh;

  constructor() {
    this.texture.magFilter = this.texture.minFilter = three.LinearFilter;
    const material = new three.MeshBasicMaterial({ map: this.texture, transparent: true, depthWrite: false, toneMapped: false });
    this.object = new three.Mesh(new three.PlaneGeometry(1, 1), material);
    this.object.renderOrder = -1;
    this.object.frustumCulled = false;
  }

  /** Computes the shadow of the visible parts of bodies. O(vertices). */
  update(bodies: BodySet, up: three.Vector3): void {
    const p = bodies.positions;
    const turn = new three.Quaternion().setFromUnitVectors(new three.Vector3(0, 0, 1), up);
    const across = [new three.Vector3(1, 0, 0).applyQuaternion(turn), new three.Vector3(0, 1, 0).applyQuaternion(turn)] as const;
    const box = new three.Box2();
    let lowest = Infinity;
    const flat: number[] = [];
    const place = new three.Vector3();
    for (const vertex of bodies.shownVertices()) {
      place.fromArray(p, 3 * vertex);
      const [x, y] = [place.dot(across[0]), place.dot(across[1])];
      flat.push(x, y);
      box.expandByPoint(new three.Vector2(x, y));
      lowest = Math.min(lowest, place.dot(up));
    }
    this.object.visible = flat.length > 0;
    if (flat.length === 0) return;
    const middle = box.getCenter(new three.Vector2());
    const extent = box.getSize(new three.Vector2());
    const size = 1.7 * Math.max(extent.x, extent.y);
    this.draw(flat, middle, size);
    this.object.scale.setScalar(size);
    this.object.quaternion.copy(turn);
    this.object.position.copy(up).multiplyScalar(lowest - 0.004 * size).addScaledVector(across[0], middle.x).addScaledVector(across[1], middle.y);
  }

  private draw(flat: number[], middle: three.Vector2, size: number): void {
    let shade = new Float32Array(side * side);
    for (let i = 0; i < flat.length; i += 2) {
      const x = Math.floor(((flat[i]! - middle.x) / size + 0.5) * side);
      const y = Math.floor(((flat[i + 1]! - middle.y) / size + 0.5) * side);
      if (x >= 0 && y >= 0 && x < side && y < side) shade[x + side * y] = 1;
    }
    for (let round = 0; round < 3; ++round) shade = blurred(blurred(shade, 1), side);
    for (let i = 0; i < shade.length; ++i) this.pixels[4 * i + 3] = Math.round(60 * Math.min(1, 1.5 * shade[i]!));
    this.texture.needsUpdate = true;
  }
}

/** Replaces each value by the mean of five neighbours in a row or a column. */
function blurred(values: Float32Array, stride: number): Float32Array {
  const out = new Float32Array(values.length);
  for (let i = 0; i < values.length; ++i) {
    const place = Math.floor(i / stride) % side;
    let sum = 0;
    for (let d = -2; d <= 2; ++d) if (place + d >= 0 && place + d < side) sum += values[i + d * stride]!;
    out[i] = sum / 5;
  }
  return out;
}
