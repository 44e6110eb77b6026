// The cut through the bodies: one state, which views of the scene and the controls set.
import * as three from "three";
import type { BodySet } from "./bodies";
import { niceBelow } from "./colours";
import { check, choose, make, row, section, slider, type Slider } from "./parts";
import type { Stage, Vector, ViewInfo } from "./protocol";
import { inWords, length } from "./units";

const axes = ["x", "y", "z", "view"] as const;
type Axis = (typeof axes)[number];

const scissorsDrawing = `<svg viewBox="0 0 16 16" width="14" height="14" aria-hidden="true" fill="none" stroke="currentColor" stroke-width="1.5">
  <circle cx="4" cy="12.5" r="2"/><circle cx="12" cy="12.5" r="2"/><path d="M5 10.8 11.5 1.5M11 10.8 4.5 1.5"/></svg>`;

export class CutControl {
  readonly element: HTMLElement;
  private on = false;
  private axis: Axis = "x";
  /** Position along each axis, from the stage's origin. */
  private places: Partial<Record<Axis, number>> = {};
  private flip = false;
  /** Names of the bodies that are cut; null: all. */
  private cutBodies: ReadonlySet<string> | null = null;
  /** The direction of the axis "view". */
  private kept = new three.Vector3(0, 0, 1);
  /** Whether that direction comes from a view of the scene and not from the current camera. */
  private ofView = false;
  private readonly controls: { on: HTMLInputElement; axis: HTMLSelectElement; flip: HTMLInputElement; place: Slider };
  private readonly named = make("small", { id: "cut-bodies", role: "status" });
  private readonly all = make("button", { id: "cut-all", title: "Cut all bodies", onclick: () => this.change(() => (this.cutBodies = null)) }, "Cut all");
  private readonly scissors: HTMLButtonElement[];
  /** Places that the slider takes are multiples of this. */
  private readonly step: number;

  /**
   * @param changed  other parts of the bodies are seen
   * @param inFrame  runs a change; what was all in the frame before is so again
   * @param towardsEye  from what is looked at to the eye
   */
  constructor(
    private readonly stage: Stage,
    private readonly bodies: BodySet,
    private readonly changed: () => void,
    private readonly towardsEye: () => three.Vector3,
    private readonly inFrame: (change: () => void) => void,
  ) {
    const half = 0.5 * stage.diagonal;
    this.step = niceBelow(stage.diagonal / 200);
    const on = check("Cut the bodies open", false, (value) => this.change(() => this.switch(value)), "cut");
    const axis = choose(axes, "x", (value) => this.change(() => this.setAxis(value as Axis)), "cut-axis");
    const place = slider({
      id: "cut-place", label: "Position of the cut", low: -half, high: half, value: 0,
      show: (v) => this.shownPlace(v),
      snap: (v) => this.snap(v),
      change: (v) => { this.places[this.axis] = v; this.apply(); },
    });
    const flip = check("The other side", false, (value) => this.change(() => (this.flip = value)), "cut-flip");
    const box = (label: HTMLElement) => label.querySelector("input")!;
    this.controls = { on: box(on), axis, flip: box(flip), place };
    this.scissors = stage.bodies.map(({ name }) => this.scissorsOf(name));
    const bodiesLine = make("div", { class: "row" }, this.named, this.all);
    this.element = section("Cut", true, on, row("Across", axis), row("Position", place.element), flip, bodiesLine);
  }

  /** A button for the line of a body: whether the cut opens it. */
  private scissorsOf(name: string): HTMLButtonElement {
    const button = make("button", { class: "scissors", "aria-label": `Cut ${name}`, onclick: () => this.change(() => this.toggle(name)) });
    button.innerHTML = scissorsDrawing;
    return button;
  }

  scissorsFor(body: number): HTMLButtonElement {
    return this.scissors[body]!;
  }

  private toggle(name: string): void {
    const names = this.stage.bodies.map((body) => body.name);
    const left = names.filter((other) => (this.cutBodies?.has(other) ?? true) !== (other === name));
    this.cutBodies = left.length === names.length ? null : new Set(left);
  }

  private change(act: () => void): void {
    this.inFrame(() => {
      act();
      this.show();
      this.apply();
    });
  }

  /** Cuts as a view of the scene does; without a cut the bodies are closed. */
  set(cut: ViewInfo["cut"]): void {
    this.on = cut !== undefined;
    this.cutBodies = cut?.bodies && cut.bodies.length > 0 ? new Set(cut.bodies) : null;
    this.ofView = false;
    this.places = {};
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
    this.places[this.axis] = (this.flip ? -along : along) || 0;
    if (this.ofView) this.kept.copy(normal);
  }

  private show(): void {
    const { on, axis, flip, place } = this.controls;
    on.checked = this.on;
    axis.value = this.axis;
    flip.checked = this.flip;
    place.set(this.place);
    const names = this.stage.bodies.map((body) => body.name);
    const cut = names.filter((name) => this.cutBodies?.has(name) ?? true);
    names.forEach((name, i) => {
      const isCut = cut.includes(name);
      this.scissors[i]!.setAttribute("aria-pressed", String(isCut));
      this.scissors[i]!.title = isCut ? `${name} is cut; click to keep it whole` : `${name} stays whole; click to cut it`;
      this.scissors[i]!.classList.toggle("off", !this.on);
    });
    const spared = names.length - cut.length;
    this.named.textContent = !this.on ? "" : spared === 0 ? "Cuts: all bodies." : cut.length === 0 ? "Cuts: none." :
      `Cuts: ${cut.join(", ")}. ${spared === 1 ? "1 other stays" : `${spared} others stay`} whole.`;
    this.all.hidden = !this.on || spared === 0;
  }

  /** Position along the present axis, from the stage's origin. */
  private get place(): number {
    return this.places[this.axis] ?? this.snap(0);
  }

  /** The coordinate of the stage's origin along the axis. */
  private start(): number {
    return this.direction().dot(new three.Vector3(...this.stage.origin));
  }

  /** The nearest place with a round coordinate. */
  private snap(place: number): number {
    const start = this.start();
    return this.step * Math.round((place + start) / this.step) - start;
  }

  private switch(on: boolean): void {
    this.on = on;
    if (on && this.axis === "view" && !this.ofView) this.kept = this.towardsEye();
  }

  private setAxis(axis: Axis): void {
    this.axis = axis;
    this.ofView = false;
    if (axis === "view") this.kept = this.towardsEye();
  }

  private direction(): three.Vector3 {
    return this.axis === "view" ? this.kept : new three.Vector3().setComponent(axes.indexOf(this.axis), 1);
  }

  /** The plane in the coordinates of the scene. */
  private shownPlace(place: number): string {
    const digit = 10 ** Math.floor(Math.log10(this.step) + 1e-9);
    const value = digit * Math.round((place + this.start()) / digit);
    return inWords(value === 0 ? 0 : value, this.stage.units, length);
  }

  private apply(): void {
    const sign = this.flip ? -1 : 1;
    const plane = new three.Plane(this.direction().clone().multiplyScalar(-sign), sign * this.place);
    this.bodies.cut(this.on ? plane : null, this.cutBodies);
    this.changed();
  }
}
