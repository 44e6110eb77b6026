// Camera, lights and drawing: a picture is drawn when something changed, and only then.
import * as three from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";

export class SceneView {
  readonly scene = new three.Scene();
  readonly camera = new three.PerspectiveCamera(40, 1, 0.01, 100);
  readonly controls: OrbitControls;
  readonly renderer: three.WebGLRenderer;
  private stale = true;
  private readonly lamp = new three.DirectionalLight(0xffffff, 2.2);
  /** Called after each drawn picture. */
  drawn: () => void = () => {};

  constructor(readonly canvas: HTMLCanvasElement) {
    this.renderer = new three.WebGLRenderer({ canvas, antialias: true });
    this.renderer.localClippingEnabled = true;
    this.scene.add(new three.HemisphereLight(0xffffff, 0x8d8d99, 1.4), this.camera);
    this.camera.add(this.lamp);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.addEventListener("change", () => this.redraw());
    new ResizeObserver(() => this.resize()).observe(canvas.parentElement!);
    requestAnimationFrame(() => this.loop());
  }

  redraw(): void {
    this.stale = true;
  }

  private loop(): void {
    requestAnimationFrame(() => this.loop());
    if (!this.stale) return;
    this.draw();
    this.drawn();
  }

  draw(): void {
    this.stale = false;
    this.renderer.render(this.scene, this.camera);
  }

  private resize(): void {
    const { clientWidth: width, clientHeight: height } = this.canvas.parentElement!;
    if (width === 0 || height === 0) return;
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.redraw();
  }

  setBackground(colour: string): void {
    this.scene.background = new three.Color(colour);
    this.redraw();
  }

  /** Sees a ball of that size about the origin, from a corner; up is against gravity. */
  fit(radius: number, gravity: three.Vector3): void {
    const up = gravity.lengthSq() > 0 ? gravity.clone().negate().normalize() : new three.Vector3(0, 0, 1);
    const side = Math.abs(up.z) > 0.7 ? new three.Vector3(0.75, -1, 0) : new three.Vector3(0.75, 0, 1);
    side.addScaledVector(up, -side.dot(up)).normalize();
    this.camera.up.copy(up);
    const narrow = Math.min(1, this.camera.aspect);
    const distance = radius / Math.sin((Math.PI / 360) * this.camera.fov) / narrow;
    this.controls.target.set(0, 0, 0);
    this.camera.position.copy(side).addScaledVector(up, 0.55).normalize().multiplyScalar(distance);
    this.camera.near = distance / 200;
    this.camera.far = distance * 20;
    this.camera.updateProjectionMatrix();
    this.lamp.position.set(-0.4 * distance, 0.6 * distance, 0.4 * distance);
    this.controls.update();
    this.redraw();
  }

  lookFrom(position: readonly [number, number, number], target: readonly [number, number, number]): void {
    this.camera.position.set(...position);
    this.controls.target.set(...target);
    this.controls.update();
    this.redraw();
  }

  /** Turns the view by angles about the vertical and the horizontal, radians. */
  turn(sideways: number, upwards: number): void {
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
    this.camera.position.sub(this.controls.target).multiplyScalar(factor).add(this.controls.target);
    this.controls.update();
    this.redraw();
  }

  /** The ray through a place of the canvas, in pixels of the page. */
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
