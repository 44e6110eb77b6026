// The mouse or finger as a hand: pulls tissue by a spring, drags bodies with a prescribed motion, picks a
// point to read its values.
import * as three from "three";
import type { BodySet } from "./bodies";
import { firstHit } from "./hits";
import type { Stage } from "./protocol";
import type { SceneView } from "./scene_view";

export interface Hand {
  stage(): Stage;
  bodies(): BodySet;
  send(name: string, values?: object): void;
  /** Called when a vertex, or nothing, was picked. */
  picked(vertex: number | null): void;
  /** Called when a body, or none, is under the mouse; in pixels from the corner of the view. */
  hover(body: number | null, x: number, y: number): void;
  /** Called when nothing is held any more. */
  released(): void;
  strength(): number;
  /** None where nothing moves the body in this stage. */
  offset(motion: number): [number, number, number] | undefined;
}

type Grip =
  | { kind: "pull"; plane: three.Plane; from: three.Vector3; start: three.Vector3; target: three.Vector3 }
  | { kind: "motion"; plane: three.Plane; motion: number; from: three.Vector3; offset: three.Vector3 };

const array = (v: three.Vector3) => v.toArray();

export class Touch {
  private grip: Grip | null = null;
  private down = { x: 0, y: 0 };
  private looked = 0;
  private looking = 0;  // timer

  constructor(
    private readonly view: SceneView,
    private readonly hand: Hand,
  ) {
    const place = view.canvas.parentElement!;
    // Handled before the orbit controls: touching tissue must not rotate the view.
    place.addEventListener("pointerdown", (event) => this.press(event), { capture: true });
    view.canvas.addEventListener("pointermove", (event) => {
      if (!event.isPrimary) return;
      // What keys hold, keys move.
      if (view.canvas.hasPointerCapture(event.pointerId)) this.move(event.clientX, event.clientY);
      this.lookUnder(event);
    });
    view.canvas.addEventListener("pointerleave", () => this.leave());
    view.canvas.addEventListener("pointerup", (event) => this.lift(event));
    view.canvas.addEventListener("pointercancel", () => this.letGo());
    view.canvas.addEventListener("lostpointercapture", () => this.letGo());
  }

  get holds(): boolean {
    return this.grip !== null;
  }

  private press(event: PointerEvent): void {
    if (!event.isPrimary) return;  // a second finger belongs to the view
    this.down = { x: event.clientX, y: event.clientY };
    if (event.target !== this.view.canvas || event.button !== 0 || event.shiftKey || event.ctrlKey) return;
    if (!this.take(event.clientX, event.clientY)) return;
    this.view.controls.enabled = false;
    this.view.canvas.setPointerCapture(event.pointerId);
  }

  /** Grabs what is at a position of the page; returns false if nothing there can move. */
  take(x: number, y: number): boolean {
    if (this.hand.stage().mode !== "live") return false;
    const bodies = this.hand.bodies();
    const hit = firstHit(bodies, this.view.ray(x, y));
    if (!hit) return false;
    const normal = this.view.camera.getWorldDirection(new three.Vector3());
    const plane = new three.Plane().setFromNormalAndCoplanarPoint(normal, hit.point);
    if (bodies.meshes[hit.body]!.info.rigid) {
      const motion = this.hand.stage().motions.findIndex((m) => m.body === hit.body);
      const moved = this.hand.offset(motion);
      if (!moved) return false;
      const offset = new three.Vector3(...moved);
      this.grip = { kind: "motion", plane, motion, from: hit.point.clone(), offset };
      return true;
    }
    // The vertex may be some pixels from the mouse: a mouse that does not move must not pull.
    const target = bodies.vertex(hit.vertex);
    this.grip = { kind: "pull", plane, from: hit.point.clone(), start: target.clone(), target };
    this.hand.picked(hit.vertex);
    this.hand.send("pull", { vertex: hit.vertex, target: array(target), strength: this.hand.strength() });
    return true;
  }

  move(x: number, y: number): void {
    if (!this.grip) return;
    const place = this.view.ray(x, y).ray.intersectPlane(this.grip.plane, new three.Vector3());
    if (!place) return;
    const offset = place.sub(this.grip.from);
    if (this.grip.kind === "pull") this.pullTo(offset.add(this.grip.start));
    else this.hand.send("drive_motion", { motion: this.grip.motion, offset: array(offset.add(this.grip.offset)) });
  }

  /** Limits how often this is done, because a search through all triangles costs as much as a frame. The last place counts. */
  private lookUnder(event: PointerEvent): void {
    clearTimeout(this.looking);
    if (event.pointerType === "touch") return;
    if (event.buttons !== 0) return this.hand.hover(null, 0, 0);
    const { clientX, clientY } = event;
    const wait = this.looked + 60 - performance.now();
    if (wait > 0) this.looking = window.setTimeout(() => this.lookAt(clientX, clientY), wait);
    else this.lookAt(clientX, clientY);
  }

  private lookAt(x: number, y: number): void {
    this.looked = performance.now();
    const bodies = this.hand.bodies();
    const hit = bodies && firstHit(bodies, this.view.ray(x, y));
    const box = this.view.canvas.getBoundingClientRect();
    this.hand.hover(hit ? hit.body : null, x - box.left, y - box.top);
  }

  private leave(): void {
    clearTimeout(this.looking);
    this.hand.hover(null, 0, 0);
  }

  private pullTo(target: three.Vector3): void {
    if (this.grip?.kind !== "pull") return;
    this.grip.target.copy(target);
    this.hand.send("move_pull", { target: array(target) });
  }

  /** Moves what is held by fractions of the scene's size, along the screen; for keys. */
  nudge(right: number, up: number): void {
    const grip = this.grip;
    if (!grip || grip.kind !== "pull") return;
    const size = 0.02 * this.hand.stage().diagonal;
    const axis = (column: number) => new three.Vector3().setFromMatrixColumn(this.view.camera.matrixWorld, column);
    this.pullTo(grip.target.clone().addScaledVector(axis(0), size * right).addScaledVector(axis(1), size * up));
  }

  private lift(event: PointerEvent): void {
    if (!event.isPrimary) return;
    const still = Math.hypot(event.clientX - this.down.x, event.clientY - this.down.y) < 4;
    const held = this.grip !== null;
    this.letGo();
    if (still && event.button === 0) {
      const hit = firstHit(this.hand.bodies(), this.view.ray(event.clientX, event.clientY));
      if (hit || !held) this.hand.picked(hit ? hit.vertex : null);
    }
  }

  letGo(): void {
    this.view.controls.enabled = true;
    if (this.grip?.kind === "pull") this.hand.send("let_go");
    this.grip = null;
    this.hand.released();
  }
}
