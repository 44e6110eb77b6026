// Camera, lights and drawing: a picture is drawn when something changed, and only then.
import * as three from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { Resolution } from "./resolution";

/** Fraction of the frame that is filled. */
const fill = 0.86;

/** The place to look at and the distance of the camera, so that all points are within the slopes across and up. Axes: right, up, back. */
function framed(points: Float32Array, axes: [three.Vector3, three.Vector3, three.Vector3], across: number, up: number): { middle: three.Vector3; distance: number } {
  const point = new three.Vector3();
  const least = [Infinity, Infinity];
  const most = [-Infinity, -Infinity];
  let nearest = -Infinity;
  // Each side of the frame is a plane with this slope; it touches the furthest point along its normal.
  const slopes = [across, up];
  for (let i = 0; i < points.length; i += 3) {
    point.fromArray(points, i);
    const z = point.dot(axes[2]);
    nearest = Math.max(nearest, z);
    for (const c of [0, 1]) {
      const x = point.dot(axes[c]!) / slopes[c]!;
      most[c] = Math.max(most[c]!, x + z);
      least[c] = Math.min(least[c]!, x - z);
    }
  }
  const eye = Math.max((most[0]! - least[0]!) / 2, (most[1]! - least[1]!) / 2, nearest);
  const place = (c: number) => (slopes[c]! * (most[c]! + least[c]!)) / 2;
  let sum = 0;
  for (let i = 0; i < points.length; i += 3) sum += point.fromArray(points, i).dot(axes[2]);
  const depth = sum / (points.length / 3);
  const middle = new three.Vector3().addScaledVector(axes[0], place(0)).addScaledVector(axes[1], place(1)).addScaledVector(axes[2], depth);
  return { middle, distance: eye - depth };
}

export class SceneView {
  readonly scene = new three.Scene();
  readonly camera = new three.PerspectiveCamera(40, 1, 0.01, 100);
  readonly controls: OrbitControls;
  readonly renderer: three.WebGLRenderer;
  private stale = true;
  private readonly resolution = new Resolution(() => this.resize());
  /** A light beside the camera, so that the visible side is never dark. */
  private readonly lamp = new three.DirectionalLight(0xfff6ea, 1.6);
  /** A light above the scene: its shadows show which body is over which. */
  private readonly sun = new three.DirectionalLight(0xffffff, 1.0);
  private readonly sky = new three.HemisphereLight(0xf4f8ff, 0x9a8f86, 1.25);
  /** Called before and after each picture is drawn. */
  beforeDrawing: () => void = () => {};
  drawn: () => void = () => {};
  /** Called when the size of the view has changed. */
  resized: () => void = () => {};
  /** Whether the user has rotated or moved the view since it was last fitted. */
  isMoved = false;
  private inHand = false;

  constructor(readonly canvas: HTMLCanvasElement) {
    this.renderer = new three.WebGLRenderer({ canvas, antialias: true, stencil: true });
    this.renderer.localClippingEnabled = true;
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = three.VSMShadowMap;
    this.renderer.shadowMap.autoUpdate = false;
    this.sun.castShadow = true;
    this.sun.shadow.mapSize.set(320, 320);
    this.scene.add(this.sky, this.sun, this.sun.target, this.camera);
    this.camera.add(this.lamp);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.addEventListener("start", () => (this.inHand = true));
    this.controls.addEventListener("end", () => (this.inHand = false));
    this.controls.addEventListener("change", () => {
      this.isMoved ||= this.inHand;
      this.redraw();
    });
    new ResizeObserver(() => {
      this.resize();
      this.resized();
    }).observe(canvas.parentElement!);
    requestAnimationFrame(() => this.loop());
  }

  redraw(): void {
    this.stale = true;
  }

  private loop(): void {
    requestAnimationFrame(() => this.loop());
    this.resolution.ready();
    if (!this.stale) return;
    this.resolution.draws();
    this.draw();
    this.drawn();
  }

  draw(): void {
    this.stale = false;
    this.beforeDrawing();
    // three.js uploads a geometry once per number of a frame. It draws shadows with the number of the next frame, which would then
    // be drawn without its changes, and a body with new buffers not at all from then on.
    ++this.renderer.info.render.frame;
    this.renderer.render(this.scene, this.camera);
  }

  private resize(): void {
    const { clientWidth: width, clientHeight: height } = this.canvas.parentElement!;
    if (width === 0 || height === 0) return;
    this.renderer.setPixelRatio(this.resolution.fraction * Math.min(devicePixelRatio, 2));
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.redraw();
  }

  setBackground(colour: string): void {
    this.scene.background = new three.Color(colour);
    this.redraw();
  }

  /** The direction that is drawn upwards: against gravity. */
  setUp(gravity: three.Vector3): void {
    const up = gravity.lengthSq() > 0 ? gravity.clone().negate().normalize() : new three.Vector3(0, 0, 1);
    this.camera.up.copy(up);
    this.sky.position.copy(up);
  }

  /** Updates the shadows of all bodies inside a ball. */
  castShadows({ center, radius }: three.Sphere): void {
    const up = this.camera.up;
    const side = this.corner().addScaledVector(up, -0.55);
    this.sun.target.position.copy(center);
    this.sun.position.copy(center).addScaledVector(up, 2 * radius).addScaledVector(side, -0.35 * radius);
    const { camera, mapSize } = this.sun.shadow;
    camera.left = camera.bottom = -radius;
    camera.right = camera.top = radius;
    camera.near = 0.5 * radius;
    camera.far = 3.5 * radius;
    camera.updateProjectionMatrix();
    this.sun.shadow.radius = 3;
    this.sun.shadow.blurSamples = 8;
    this.sun.shadow.normalBias = (2 * radius) / mapSize.x;
    this.sun.shadow.bias = -0.0005;
    this.sun.target.updateMatrixWorld();
    this.renderer.shadowMap.needsUpdate = true;
  }

  /** The direction from the place that the camera looks at to the camera. */
  back(): three.Vector3 {
    return this.camera.position.clone().sub(this.controls.target);
  }

  /** Looks from a corner, a little from above. */
  corner(): three.Vector3 {
    const up = this.camera.up;
    const side = Math.abs(up.z) > 0.7 ? new three.Vector3(0.75, -1, 0) : new three.Vector3(0.75, 0, 1);
    return side.addScaledVector(up, -side.dot(up)).normalize().addScaledVector(up, 0.55);
  }

  /** Fits points (3 numbers each) into the frame, as seen from a direction. */
  fit(points: Float32Array, from: three.Vector3): void {
    if (points.length === 0) return;
    this.isMoved = false;
    const back = from.clone().normalize();
    const right = this.camera.up.clone().cross(back).normalize();
    const up = back.clone().cross(right);
    const half = Math.tan((Math.PI / 360) * this.camera.fov);
    const { middle, distance } = framed(points, [right, up, back], (fill * half * this.camera.aspect), fill * half);
    this.controls.target.copy(middle);
    this.camera.position.copy(middle).addScaledVector(back, distance);
    this.camera.near = distance / 200;
    this.camera.far = distance * 20;
    this.camera.updateProjectionMatrix();
    this.lamp.position.set(-0.5 * distance, 0.7 * distance, 0.5 * distance);
    this.controls.update();
    this.redraw();
  }

  /** Whether all points (3 numbers each) are in the frame. */
  sees(points: Float32Array): boolean {
    this.camera.updateMatrixWorld();
    const place = new three.Vector3();
    for (let i = 0; i < points.length; i += 3) {
      place.fromArray(points, i).project(this.camera);
      if (!(Math.max(Math.abs(place.x), Math.abs(place.y), Math.abs(place.z)) <= 1)) return false;
    }
    return true;
  }

  /** The length in pixels of a length at the place that the camera looks at. */
  pixelsPer(): number {
    const distance = this.camera.position.distanceTo(this.controls.target);
    return this.canvas.clientHeight / (2 * distance * Math.tan((Math.PI / 360) * this.camera.fov));
  }

  /** Rotates the view by angles about the vertical and the horizontal, radians. */
  turn(sideways: number, upwards: number): void {
    this.isMoved = true;
    const turn = new three.Quaternion().setFromUnitVectors(this.camera.up, new three.Vector3(0, 1, 0));
    const offset = this.camera.position.clone().sub(this.controls.target).applyQuaternion(turn);
    const place = new three.Spherical().setFromVector3(offset);
    place.theta += sideways;
    place.phi = Math.min(Math.max(place.phi + upwards, 0.01), Math.PI - 0.01);
    offset.setFromSpherical(place).applyQuaternion(turn.invert());
    this.camera.position.copy(this.controls.target).add(offset);
    this.controls.update();
    this.redraw();
  }

  zoom(factor: number): void {
    this.isMoved = true;
    this.camera.position.sub(this.controls.target).multiplyScalar(factor).add(this.controls.target);
    this.controls.update();
    this.redraw();
  }

  /** The ray through a position of the canvas, in pixels of the page. */
  ray(x: number, y: number): three.Raycaster {
    const box = this.canvas.getBoundingClientRect();
    const place = new three.Vector2((2 * (x - box.left)) / box.width - 1, 1 - (2 * (y - box.top)) / box.height);
    this.camera.updateMatrixWorld();
    const caster = new three.Raycaster();
    caster.setFromCamera(place, this.camera);
    return caster;
  }

  /** Where a point of space is on the canvas, in pixels from its corner. */
  place(point: three.Vector3): { x: number; y: number } {
    const p = point.clone().project(this.camera);
    return { x: (0.5 + 0.5 * p.x) * this.canvas.clientWidth, y: (0.5 - 0.5 * p.y) * this.canvas.clientHeight };
  }

  /** The middle of the canvas, in pixels of the page. */
  middle(): { x: number; y: number } {
    const box = this.canvas.getBoundingClientRect();
    return { x: box.left + box.width / 2, y: box.top + box.height / 2 };
  }
}
