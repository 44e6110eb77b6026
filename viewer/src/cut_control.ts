// The cut through the bodies: one state, which views of the scene and the controls set.
import * as three from "three";
import type { BodySet } from "./bodies";
import { check, choose, row, section, slider, type Slider } from "./parts";
import type { Stage, Vector, ViewInfo } from "./protocol";
import { inWords, length } from "./units";

const axes = ["x", "y", "z", "view"] as const;
type Axis = (typeof axes)[number];

export class CutControl {
  readonly element: HTMLElement;
  private on = false;
  private axis: Axis = "x";
  /** Position along the axis, from the stage's origin. */
  private place = 0;
  private flip = false;
  /** Names of the bodies that are cut; none: all. */
  private cutBodies: readonly string[] = [];
  /** The direction of the axis "view". */
  private kept = new three.Vector3(0, 0, 1);
  /** Whether that direction comes from a view of the scene and not from the current camera. */
  private ofView = false;
  private readonly controls: { on: HTMLInputElement; axis: HTMLSelectElement; flip: HTMLInputElement; place: Slider };

  /**
   * @param changed  other parts of the bodies are seen
   * @param towardsEye  from what is looked at to the eye
   */
  constructor(
    private readonly stage: Stage,
    private readonly bodies: BodySet,
    private readonly changed: () => void,
    private readonly towardsEye: () => three.Vector3,
  ) {
    const half = 0.5 * stage.diagonal;
    const on = check("Cut the bodies open", false, (value) => this.switch(value), "cut");
    const axis = choose(axes, "x", (value) => this.setAxis(value as Axis), "cut-axis");
    const place = slider({
      id: "cut-place", label: "Position of the cut", low: -half, high: half, value: 0,
      show: (v) => this.shownPlace(v),
      change: (v) => { this.place = v; this.apply(); },
    });
    const flip = check("The other side", false, (value) => { this.flip = value; this.apply(); }, "cut-flip");
    const box = (label: HTMLElement) => label.querySelector("input")!;
    this.controls = { on: box(on), axis, flip: box(flip), place };
    this.element = section("Cut", true, on, row("Across", axis), row("Position", place.element), flip);
  }

  /** Cuts as a view of the scene does; without a cut the bodies are closed. */
  set(cut: ViewInfo["cut"]): void {
    this.on = cut !== undefined;
    this.cutBodies = cut?.bodies ?? [];
    this.ofView = false;
    if (cut) this.setPlane(new three.Vector3(...cut.normal).normalize(), cut.point);
    this.show();
    this.apply();
  }

  /** The normal points to the side that is removed. */
  private setPlane(normal: three.Vector3, point: Vector): void {
    const { origin } = this.stage;
    const along = normal.dot(new three.Vector3(...point).sub(new three.Vector3(...origin)));
    const aligned = normal.toArray().findIndex((x) => Math.abs(x) > 1 - 1e-9);
    this.ofView = aligned < 0;
    this.axis = axes[this.ofView ? 3 : aligned]!;
    this.flip = !this.ofView && normal.getComponent(aligned) < 0;
    this.place = (this.flip ? -along : along) || 0;
    if (this.ofView) this.kept.copy(normal);
  }

  private show(): void {
    const { on, axis, flip, place } = this.controls;
    on.checked = this.on;
    axis.value = this.axis;
    flip.checked = this.flip;
    place.set(this.place);
  }

  private switch(on: boolean): void {
    this.on = on;
    if (on && this.axis === "view" && !this.ofView) this.kept = this.towardsEye();
    this.apply();
  }

  private setAxis(axis: Axis): void {
    this.axis = axis;
    this.ofView = false;
    if (axis === "view") this.kept = this.towardsEye();
    this.show();
    this.apply();
  }

  private direction(): three.Vector3 {
    return this.axis === "view" ? this.kept : new three.Vector3().setComponent(axes.indexOf(this.axis), 1);
  }

  /** The plane in the coordinates of the scene. */
  private shownPlace(place: number): string {
    const origin = this.direction().dot(new three.Vector3(...this.stage.origin));
    const value = place + origin;
    return inWords(Math.abs(value) < 1e-6 * this.stage.diagonal ? 0 : value, this.stage.units, length);
  }

  private apply(): void {
    const sign = this.flip ? -1 : 1;
    const plane = new three.Plane(this.direction().clone().multiplyScalar(-sign), sign * this.place);
    this.bodies.cut(this.on ? plane : null, this.cutBodies);
    this.changed();
  }
}
