// The panel beside the view: what is shown, what is set, what it costs.
import * as three from "three";
import type { BodySet, Colouring } from "./bodies";
import { Chart } from "./chart";
import { css, phaseColours, short } from "./colours";
import { check, choose, make, row, section, slider } from "./parts";
import type { Frame, Stage, State } from "./protocol";
import { SettingsPanel } from "./settings_panel";

export interface PanelActions {
  send(name: string, values?: object): void;
  redraw(): void;
  look(): void;
  viewDirection(): three.Vector3;
  moveRails(motion: number, time: number): void;
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

  private bodyList(): HTMLElement {
    const set = (body: number, opacity: number) => {
      this.bodies.setOpacity(body, opacity);
      this.actions.redraw();
    };
    const controls = this.stage.bodies.map((body, i) => {
      const box = make("input", { type: "checkbox", "aria-label": `Show ${body.name}`, onchange: () => set(i, box.checked ? fade.valueAsNumber : 0) });
      const fade = make("input", { type: "range", min: 0.05, max: 1, step: 0.05, "aria-label": `Opacity of ${body.name}`, oninput: () => set(i, box.checked ? fade.valueAsNumber : 0) });
      box.checked = true;
      fade.value = "1";
      const swatch = make("span", { class: "swatch" });
      swatch.style.background = css(this.bodies.meshes[i]!.colour);
      const element = make("div", { class: "body" }, box, swatch, make("span", { class: "name", title: `${body.name}: ${body.points} points, ${body.tets} tets` }, body.name), fade);
      return { element, apply: (shown: boolean, opacity: number) => {
        box.checked = shown;
        fade.value = String(opacity);
        set(i, shown ? opacity : 0);
      } };
    });
    const all = slider({ id: "fade-all", label: "Opacity of all bodies", low: 0.05, high: 1, value: 1, show: (o) => `${Math.round(100 * o)} %`, change: (o) => controls.forEach((c) => c.apply(true, o)) });
    return section(`Bodies (${this.stage.bodies.length})`, this.stage.bodies.length <= 8, row("All", all.element), make("div", { class: "list" }, ...controls.map((c) => c.element)));
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
    this.counts.replaceChildren(...lines.filter(([, v]) => v !== undefined).map(([name, value]) => make("tr", {}, make("td", {}, name), make("td", {}, String(value)))));
  }

  state(state: State): void {
    this.settings?.update(state.settings);
  }

  clearTimes(): void {
    this.chart.clear();
  }
}
