// Decides when the shadows of bodies on each other and on the ground are updated: at once when other bodies
// are shown, and at intervals while they move.
import type { BodySet } from "./bodies";
import { Ground } from "./ground";
import type { SceneView } from "./scene_view";

/** Delay with which shadows follow a motion, ms: they are soft, and cost as much as a frame. */
const patience = 400;

export class Shadows {
  stale = true;
  private readonly ground = new Ground();
  private bodies?: BodySet;
  private made = 0;

  constructor(private readonly view: SceneView) {
    view.scene.add(this.ground.object);
    view.beforeDrawing = () => this.update();
  }

  begin(bodies: BodySet): void {
    this.bodies = bodies;
    this.stale = true;
  }

  /** Call when the bodies have moved. */
  moved(): void {
    if (performance.now() - this.made > patience) this.stale = true;
  }

  private update(): void {
    if (!this.stale || !this.bodies) return;
    this.stale = false;
    this.bodies.shade();
    this.ground.update(this.bodies, this.view.camera.up);
    this.view.castShadows(this.bodies.shownSphere());
    this.made = performance.now();
  }
}
