// The panel beside the view: what is shown, what is set, what it costs.
import * as three from "three";
import type { BodySet, Colouring } from "./bodies";
import { Chart } from "./chart";
import { css, phaseColours, short } from "./colours";
import { check, choose, make, row, section, slider } from "./parts";
import type { Frame, Stage, State, Vector, ViewInfo } from "./protocol";
import { SettingsPanel } from "./settings_panel";

export interface PanelActions {
  send(name: string, values?: object): void;
  redraw(): void;
  look(): void;
  viewDirection(): three.Vector3;
  moveRails(motion: number, time: number): void;
  /** Looks from a place of the scene at another. */
  lookFrom(position: Vector, target: Vector): void;
}

/** What the layers of the view show. */
export interface Shown {
  arrows: boolean;
  borders: boolean;
  cells: boolean;
  colouring: Colouring;
}

export class Panel {
  readonly shown: Shown = { arrows: false, borders: false, cells: false, colouring: "body" };
  strength = 1;
  private readonly settings?: SettingsPanel;
  private readonly chart: Chart;
  private readonly table = make("table", { id: "times" });
  private readonly counts = make("table", { id: "counts" });
  private readonly pick = make("div", { class: "pick", id: "pick" });
  private readonly rails: ((frame: Frame) => void)[] = [];
  private fades: ((opacity: number) => void)[] = [];
  private lastTable = 0;

  constructor(
    place: HTMLElement,
    private readonly stage: Stage,
    private readonly bodies: BodySet,
    private readonly actions: PanelActions,
  ) {
    const canvas = make("canvas", { class: "chart", "aria-label": "Milliseconds of each phase, contacts and movers over the last frames", role: "img" });
    this.chart = new Chart(canvas);
    this.chart.budget = 1e3 * stage.time_step * (stage.units.time === "ms" ? 1e-3 : 1);
    place.replaceChildren(this.contacts(), this.time(canvas));
    if (stage.mode === "live") {
      this.settings = new SettingsPanel(stage, (settings) => actions.send("change", { ...settings }));
      place.append(this.settings.element);
      if (stage.motions.length > 0) place.append(this.motions());
    }
    place.append(this.point(), this.bodyList(), this.cut());
    this.showPick([]);
  }

  private contacts(): HTMLElement {
    const shown = this.shown;
    const colouring = choose(["body", "depth", "displacement"], "body", (value) => this.setColouring(value as Colouring), "colouring");
    const layer = (label: string, key: "arrows" | "borders" | "cells") =>
      check(label, false, (on) => {
        shown[key] = on;
        this.actions.look();
      }, `show-${key}`);
    return section("Contacts and colours", true,
      row("Colours show", colouring),
      layer("Direction and depth of each contact", "arrows"),
      layer("Border edges and crossings", "borders"),
      layer("Grid cells that hold a point", "cells"),
      this.counts);
  }

  setColouring(colouring: Colouring): void {
    this.shown.colouring = colouring;
    (document.getElementById("colouring") as HTMLSelectElement).value = colouring;
    this.bodies.setColouring(colouring);
    this.actions.look();
  }

  private time(canvas: HTMLElement): HTMLElement {
    const budget = make("input", { type: "number", min: 0, step: "any", id: "budget-line", "aria-label": "Budget of a step in ms", oninput: () => {
      this.chart.budget = Math.max(0, budget.valueAsNumber || 0);
    } });
    budget.value = String(Number(this.chart.budget.toPrecision(4)));
    return section("Time of a step", true, canvas, row("Budget line (ms)", budget), this.table);
  }

  private motions(): HTMLElement {
    const element = section("Bodies on rails", true);
    this.stage.motions.forEach((motion, m) => {
      const name = this.stage.bodies[motion.body]?.name ?? `motion ${m}`;
      const time = slider({
        id: `rails-${m}`,
        label: `Place of ${name} on its path`,
        low: motion.begin,
        high: motion.end,
        value: motion.begin,
        show: (t) => `${short(t)} ${this.stage.units.time}`,
        change: (t) => this.actions.moveRails(m, t),
      });
      const run = make("button", { onclick: () => this.actions.send("run_rails", { motion: m }) }, "Let it run");
      element.append(row(name, time.element), row("", run));
      this.rails.push((frame) => {
        const rail = frame.counts.rails?.[m];
        if (!rail) return;
        run.disabled = !rail.held;
        if (!rail.held) time.set(Math.min(Math.max(rail.time, motion.begin), motion.end));
      });
    });
    element.append(make("small", {}, "Drag such a body to move it freely."));
    return element;
  }

  private point(): HTMLElement {
    const strength = slider({ id: "strength", label: "Strength of the pull", low: 0.05, high: 20, value: 1, logarithmic: true, show: (s) => `× ${short(s)}`, change: (s) => (this.strength = s) });
    const children: Node[] = this.stage.mode === "live" ? [row("Pull strength", strength.element)] : [];
    return section("Picked point", true, this.pick, ...children);
  }

  showPick(lines: [string, string][]): void {
    if (lines.length === 0) {
      const live = this.stage.mode === "live";
      this.pick.replaceChildren(make("span", { class: "faint" }, live ? "Click tissue to read what is there, drag it to pull." : "Click tissue to read what is there."));
      return;
    }
    this.pick.replaceChildren(make("table", {}, ...lines.map(([name, value]) => make("tr", {}, make("td", {}, name), make("td", {}, value)))));
  }

  private bodyLine(name: string, body: number): HTMLElement {
    const info = this.stage.bodies[body]!;
    const set = () => {
      this.bodies.setOpacity(body, box.checked ? fade.valueAsNumber : 0);
      this.actions.redraw();
    };
    const box = make("input", { type: "checkbox", "aria-label": `Show ${name}`, onchange: set });
    const fade = make("input", { type: "range", min: 0.05, max: 1, step: 0.05, "aria-label": `Opacity of ${name}`, oninput: set });
    this.fades[body] = (opacity) => {
      box.checked = opacity > 0;
      fade.value = String(opacity || 1);
      set();
    };
    const swatch = make("span", { class: "swatch" });
    swatch.style.background = css(this.bodies.meshes[body]!.colour);
    box.checked = true;
    fade.value = "1";
    return make("div", { class: "body" }, box, swatch, make("span", { class: "name", title: `${name}: ${info.points} points, ${info.tets} tets` }, name), fade);
  }

  private bodyList(): HTMLElement {
    const lines = this.stage.bodies.map((body, i) => this.bodyLine(body.name, i));
    const all = slider({ id: "fade-all", label: "Opacity of all bodies", low: 0.05, high: 1, value: 1, show: (o) => `${Math.round(100 * o)} %`, change: (o) => this.fades.forEach((fade) => fade(o)) });
    const element = section(`Bodies (${lines.length})`, lines.length <= 12);
    const { views } = this.stage;
    if (views.length > 0) {
      const names = ["everything", ...views.map((view) => view.name)];
      const choice: HTMLSelectElement = choose(names, names[0]!, () => this.applyView(views[choice.selectedIndex - 1]), "scene-view");
      element.append(row("View of the scene", choice));
    }
    element.append(row("All", all.element), make("div", { class: "list" }, ...lines));
    return element;
  }

  /** Shows what a view of the scene shows; without one, everything. */
  private applyView(view?: ViewInfo): void {
    const shown = view?.bodies ?? [];
    this.stage.bodies.forEach((body, i) => this.fades[i]!(shown.length === 0 || shown.includes(body.name) ? 1 : 0));
    const { cut, camera } = view ?? {};
    const here = (place: Vector) => new three.Vector3(...place).sub(new three.Vector3(...this.stage.origin));
    const plane = cut ? new three.Plane().setFromNormalAndCoplanarPoint(new three.Vector3(...cut.normal).normalize().negate(), here(cut.point)) : null;
    this.bodies.cut(plane, cut?.bodies);
    (document.getElementById("cut") as HTMLInputElement).checked = plane !== null;
    if (camera?.position) this.actions.lookFrom(here(camera.position).toArray(), here(camera.target ?? this.stage.origin).toArray());
    this.setColouring(view?.displacement ? "displacement" : "body");
    this.actions.redraw();
  }

  private cut(): HTMLElement {
    const half = 0.5 * this.stage.diagonal;
    let on = false;
    let axis = "x";
    let share = 0;
    let flip = 1;
    let kept = new three.Vector3();
    const apply = () => {
      const directions: Record<string, three.Vector3> = { x: new three.Vector3(1, 0, 0), y: new three.Vector3(0, 1, 0), z: new three.Vector3(0, 0, 1), view: kept };
      const normal = directions[axis]!.clone().multiplyScalar(-flip);
      this.bodies.cut(on ? new three.Plane(normal, flip * share * half) : null);
      this.actions.redraw();
    };
    const place = slider({ id: "cut-place", label: "Place of the cut", low: -1, high: 1, value: 0, show: (v) => `${short(v * half)} ${this.stage.units.length}`, change: (v) => { share = v; apply(); } });
    return section("Cut away", true,
      check("Cut the bodies open", false, (value) => { on = value; kept = this.actions.viewDirection().negate(); apply(); }, "cut"),
      row("Across", choose(["x", "y", "z", "view"], "x", (value) => { axis = value; kept = this.actions.viewDirection().negate(); apply(); }, "cut-axis")),
      row("Place", place.element),
      check("The other side", false, (value) => { flip = value ? -1 : 1; apply(); }, "cut-flip"));
  }

  update(frame: Frame): void {
    this.chart.add(frame);
    for (const rail of this.rails) rail(frame);
    const now = performance.now();
    if (now - this.lastTable < 200) return;  // numbers that nobody could read cost frames
    this.lastTable = now;
    this.showTimes(frame);
    this.showCounts(frame);
  }

  private showTimes(frame: Frame): void {
    const ms = (x: number | undefined) => (x ?? 0).toFixed(x && x >= 100 ? 0 : 3);
    const rows = Object.keys(frame.ms).map((name, i) => {
      const swatch = make("span", { class: "swatch" });
      swatch.style.background = phaseColours[i] ?? "transparent";
      return make("tr", {}, make("td", {}, swatch, name), make("td", {}, ms(frame.ms[name])), make("td", {}, ms(frame.totals.ms[name])));
    });
    this.table.replaceChildren(
      make("tr", {}, make("th", {}, "ms"), make("th", {}, "now"), make("th", {}, `mean of ${frame.totals.steps}`)), ...rows,
      make("tr", {}, make("td", {}, "longest step"), make("td", {}, ms(frame.longest)), make("td", {}, ms(frame.totals.longest))));
  }

  private showCounts(frame: Frame): void {
    const counts = frame.counts;
    const unit = this.stage.units.length;
    const lines: [string, string | number | undefined][] = [
      ["contacts", counts.contacts], ["border edges", counts.border_edges], ["crossings", counts.crossings],
      ["movers", counts.movers], ["candidates", counts.candidates],
      ["deepest", counts.deepest === undefined ? undefined : `${short(counts.deepest)} ${unit}`],
      ["cell size", `${short(counts.cell_size)} ${unit}`],
      ["cells in use", frame.occupied_cells],
      ["cells dropped", counts.dropped_cells > 0 ? counts.dropped_cells : undefined],
    ];
    const bad = counts.steps_not_converged ?? 0;
    const inverted = counts.inverted_tets ?? { now: 0, most: 0 };
    const warnings: [string, string][] = [];
    if (bad > 0) warnings.push(["NOT CONVERGED", `${bad} ${bad === 1 ? "step" : "steps"}: do not trust positions`]);
    if (inverted.most > 0) warnings.push(["inverted tets", `${inverted.now} now, ${inverted.most} at most`]);
    const warned = warnings.map(([name, value]) => make("tr", { class: "warning" }, make("td", {}, name), make("td", {}, value)));
    this.counts.replaceChildren(...warned, ...lines.filter(([, v]) => v !== undefined).map(([name, value]) => make("tr", {}, make("td", {}, name), make("td", {}, String(value)))));
  }

  state(state: State): void {
    this.settings?.update(state.settings);
  }

  clearTimes(): void {
    this.chart.clear();
  }
}
