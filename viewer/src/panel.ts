// The panel beside the view: first views and cuts, then touch and settings, last the costs.
import * as three from "three";
import type { BodySet, Colouring } from "./bodies";
import { css, short } from "./colours";
import { CutControl } from "./cut_control";
import { DeveloperPanel } from "./developer_panel";
import { ForceChart } from "./force_chart";
import { check, choose, make, row, section, slider } from "./parts";
import type { Frame, Stage, State, Vector, ViewInfo } from "./protocol";
import { ScaleControl } from "./scale_control";
import { SettingsPanel } from "./settings_panel";
import { inWords, length } from "./units";

export interface PanelActions {
  send(name: string, values?: object): void;
  redraw(): void;
  /** Called when other bodies or parts of them become visible. */
  reshade(): void;
  look(): void;
  viewDirection(): three.Vector3;
  moveMotion(motion: number, time: number): void;
  /** Runs a change; if all that is shown was in the frame before, it is so after it. */
  inFrame(change: () => void): void;
  /** Fits the view to the frame, seen along the line between two places of the scene; without these, from a corner. */
  lookFrom(position?: Vector, target?: Vector): void;
}

/** The data that the layers of the view show. */
export interface Shown {
  arrows: boolean;
  borders: boolean;
  cells: boolean;
  forces: boolean;
  colouring: Colouring;
}

/** The colours of a view of the scene: the scale (none: automatic) and the bodies. */
function mapOf(view?: ViewInfo): { colouring: Colouring; scale?: { least: number; most: number }; bodies?: readonly string[] } {
  const { displacement, field } = view ?? {};
  if (displacement) return { colouring: "displacement", scale: { least: 0, most: displacement.most }, bodies: displacement.bodies };
  if (!field) return { colouring: "body" };
  return { colouring: field.name, bodies: field.bodies, scale: field.most === "auto" ? undefined : { least: field.least, most: field.most } };
}

export class Panel {
  readonly shown: Shown = { arrows: false, borders: false, cells: false, forces: false, colouring: "body" };
  strength = 1;
  private readonly settings?: SettingsPanel;
  private readonly developer: DeveloperPanel;
  private forces?: ForceChart;
  private readonly cut: CutControl;
  private readonly scale: ScaleControl;
  private readonly warnings = make("table", { id: "warnings" });
  private readonly pick = make("div", { class: "pick", id: "pick" });
  private readonly sliders: ((frame: Frame) => void)[] = [];
  private fades: ((opacity: number) => void)[] = [];

  constructor(
    place: HTMLElement,
    private readonly stage: Stage,
    private readonly bodies: BodySet,
    private readonly actions: PanelActions,
  ) {
    const live = stage.mode === "live";
    this.cut = new CutControl(stage, bodies, () => actions.reshade(), () => actions.viewDirection().negate(),
      (change) => actions.inFrame(change));
    this.scale = new ScaleControl(stage, bodies, () => actions.look());
    place.replaceChildren(this.warnings, this.bodyList(), this.cut.element, this.colours(), this.point());
    if (live && stage.motions.length > 0) place.append(this.motions());
    if (live || stage.forces) place.append(this.forceSection(live));
    if (live) {
      this.settings = new SettingsPanel(stage, (settings) => actions.send("change", { ...settings }));
      place.append(this.settings.element);
    }
    const layers = [this.layer("Border edges and crossings", "borders"), this.layer("Grid cells that hold a point", "cells")];
    this.developer = new DeveloperPanel(stage, this.settings ? [...layers, this.settings.developer] : layers);
    place.append(this.developer.element);
    this.showPick([]);
  }

  private forceSection(live: boolean): HTMLElement {
    const label = live ? "Forces over the last frames" : "Forces over the run";
    const canvas = make("canvas", { class: "chart", id: "force-chart", "aria-label": label, role: "img" });
    this.forces = new ForceChart(canvas, this.stage, this.bodies);
    const note = live ? "Of contacts on each body, and of the hand." : "Of contacts on each body, over the run.";
    const element = section("Forces", false, canvas, make("small", {}, note));
    element.id = "forces";
    element.addEventListener("toggle", () => {
      this.shown.forces = element.open;
      this.actions.look();
    });
    return element;
  }

  /** Shows the first view of the scene that colours no amounts; if there is none, all bodies. */
  showFirstView(): void {
    const { views } = this.stage;
    const first = views.findIndex((view) => !view.displacement && !view.field && (view.when ?? "end") === "end");
    const choice = document.getElementById("scene-view") as HTMLSelectElement | null;
    if (choice) choice.selectedIndex = first + 1;
    this.applyView(views[first]);
  }

  private layer(label: string, key: "arrows" | "borders" | "cells"): HTMLElement {
    return check(label, false, (on) => {
      this.shown[key] = on;
      this.actions.look();
    }, `show-${key}`);
  }

  private colours(): HTMLElement {
    const fields = this.stage.fields ?? [];
    const several = (group: string) => fields.filter((field) => field.group === group).length > 1;
    const choices = fields.map(({ name, title, group }) => ({ value: name, label: title, group: several(group) ? group : undefined }));
    const colouring = choose(["body", "depth", "displacement", ...choices], "body", (value) => this.setColouring(value), "colouring");
    const edges = check("Edges of the mesh", false, (on) => {
      this.bodies.showEdges(on);
      this.actions.redraw();
    }, "show-edges");
    const covered = make("small", { id: "arrows-hint", hidden: true }, "Arrows inside bodies are seen where these are cut or faded.");
    const arrows = this.layer("Contacts: direction and depth", "arrows");
    arrows.addEventListener("change", () => (covered.hidden = !this.shown.arrows));
    return section("Colours", true, row("Colours show", colouring), this.scale.element, arrows, covered, edges);
  }

  /** Uses the scale and the bodies of that view of the scene, or of the first view with the same colours. */
  setColouring(colouring: Colouring, view?: ViewInfo): void {
    this.shown.colouring = colouring;
    (document.getElementById("colouring") as HTMLSelectElement).value = colouring;
    const { scale, bodies } = mapOf(view ?? this.stage.views.find((one) => mapOf(one).colouring === colouring));
    this.bodies.setColouring(colouring, scale, bodies);
    this.scale.show();
    this.actions.look();
  }

  private motions(): HTMLElement {
    const element = section("Motion", true);
    this.stage.motions.forEach((motion, m) => {
      const name = this.stage.bodies[motion.body]?.name ?? `motion ${m}`;
      const time = slider({
        id: `motion-${m}`,
        label: `Place of ${name} on its path`,
        low: 0,
        high: 1,
        value: 0,
        show: (t) => `${short(t)} ${this.stage.units.time}`,
        change: (t) => this.actions.moveMotion(m, t),
      });
      const run = make("button", { onclick: () => this.actions.send("resume_motion", { motion: m }) }, "Follow its path");
      const path = row(name, time.element);
      const alone = row(name);  // a path of one pose: nothing to choose
      const lines = make("div", {}, path, alone, row("", run));
      element.append(lines);
      this.sliders.push((frame) => {
        const driven = frame.counts.driven?.[m];
        if (!driven) return;
        const { begin, end, moves, held } = driven;
        lines.hidden = !moves;
        path.hidden = end <= begin;
        alone.hidden = !path.hidden;
        run.disabled = !held;
        time.range(begin, Math.max(end, begin + 1e-9));
        const waits = `from ${short(begin)} ${this.stage.units.time}`;
        if (!held) time.set(Math.min(Math.max(driven.time, begin), end), driven.time < begin ? waits : undefined);
      });
    });
    element.append(make("small", {}, "These bodies move along a path; “from” says when. Drag one to move it freely."));
    return element;
  }

  private point(): HTMLElement {
    const strength = slider({ id: "strength", label: "Strength of the pull", low: 0.05, high: 20, value: 1, logarithmic: true, show: (s) => `× ${short(s)}`, change: (s) => (this.strength = s) });
    const children: Node[] = this.stage.mode === "live"
      ? [row("Strength", strength.element), make("small", {}, "The force of a pull is limited to what the tissue can bear.")] : [];
    return section("Touch", true, this.pick, ...children);
  }

  showPick(lines: [string, string][]): void {
    if (lines.length === 0) {
      const live = this.stage.mode === "live";
      this.pick.replaceChildren(make("span", { class: "faint" }, live ? "Click tissue to read its values; drag it to pull." : "Click tissue to read its values."));
      return;
    }
    this.pick.replaceChildren(make("table", {}, ...lines.map(([name, value]) => make("tr", {}, make("td", {}, name), make("td", {}, value)))));
  }

  private bodyLine(name: string, body: number): HTMLElement {
    const info = this.stage.bodies[body]!;
    const set = () => {
      this.bodies.setOpacity(body, box.checked ? fade.valueAsNumber : 0);
      this.actions.reshade();
    };
    const box = make("input", { type: "checkbox", "aria-label": `Show ${name}`, onchange: set });
    const fade = make("input", { type: "range", min: 0.05, max: 1, step: 0.05, "aria-label": `Opacity of ${name}`, oninput: set });
    this.fades[body] = (opacity) => {
      box.checked = opacity > 0;
      fade.value = String(opacity || 1);
      set();
    };
    const label = make("span", { class: "name", title: `${name}: ${info.points} points, ${info.tets} tets` }, name);
    this.sliders.push(({ counts: { plan } }) => {
      const absent = plan ? plan.absent.includes(body) : (info.absent ?? false);
      label.classList.toggle("faint", absent);
      const text = absent ? `${name} (absent)` : name;
      if (label.textContent !== text) label.textContent = text;
    });
    const swatch = make("span", { class: "swatch" });
    swatch.style.background = css(this.bodies.meshes[body]!.colour);
    box.checked = true;
    fade.value = "1";
    return make("div", { class: "body" }, box, swatch, label, this.cut.scissorsFor(body), fade);
  }

  private bodyList(): HTMLElement {
    const lines = this.stage.bodies.map((body, i) => this.bodyLine(body.name, i));
    const all = slider({ id: "fade-all", label: "Opacity of all bodies", low: 0.05, high: 1, value: 1, show: (o) => `${Math.round(100 * o)} %`, change: (o) => this.fades.forEach((fade) => fade(o)) });
    const element = section(`Bodies (${lines.length})`, true);
    const { views } = this.stage;
    if (views.length > 0) {
      const names = ["everything", ...views.map((view) => view.name)];
      const choice: HTMLSelectElement = choose(names, names[0]!, () => this.applyView(views[choice.selectedIndex - 1]), "scene-view");
      element.append(row("View", choice));
    }
    element.append(row("All", all.element), make("div", { class: "list" }, ...lines));
    return element;
  }

  /** Shows a view of the scene; without one, all bodies. */
  private applyView(view?: ViewInfo): void {
    const shown = view?.bodies ?? [];
    this.stage.bodies.forEach((body, i) => this.fades[i]!(shown.length === 0 || shown.includes(body.name) ? 1 : 0));
    const { cut, camera } = view ?? {};
    const here = (place: Vector) => new three.Vector3(...place).sub(new three.Vector3(...this.stage.origin));
    this.cut.set(cut);
    if (camera?.position) this.actions.lookFrom(here(camera.position).toArray(), here(camera.target ?? this.stage.origin).toArray());
    else this.actions.lookFrom();
    this.setColouring(mapOf(view).colouring, view);
    this.actions.reshade();
  }

  update(frame: Frame): void {
    this.developer.update(frame);
    this.forces?.add(frame);
    for (const slider of this.sliders) slider(frame);
    this.showWarnings(frame);
  }

  private showWarnings({ counts }: Frame): void {
    const bad = counts.steps_not_converged ?? 0;
    const inverted = counts.inverted_tets ?? { now: 0, most: 0 };
    const lines: [string, string][] = [];
    if (bad > 0) lines.push(["NOT CONVERGED", `${bad} ${bad === 1 ? "step" : "steps"}: do not trust positions`]);
    for (const warning of counts.plan?.warnings ?? []) lines.push(["plan", warning]);
    if (inverted.most > 0) lines.push(["inverted tets", `${inverted.now} now, ${inverted.most} at most`]);
    const tooFar = counts.too_far?.steps ?? 0;
    if (tooFar > 0) {
      const thinnest = counts.too_far?.thinnest ?? 0;
      const thin = thinnest > 0 ? ` (${inWords(thinnest, this.stage.units, length)} thin)` : "";
      lines.push(["too far", `${tooFar} ${tooFar === 1 ? "step" : "steps"}: something may have gone through a body${thin}`]);
    }
    const text = lines.flat().join("");
    if (this.warnings.textContent === text) return;
    this.warnings.replaceChildren(...lines.map(([name, value]) => make("tr", { class: "warning" }, make("td", {}, name), make("td", {}, value))));
  }

  state(state: State): void {
    this.settings?.update(state.settings);
  }

  clearTimes(): void {
    this.developer.clear();
    this.forces?.clear();
  }
}
