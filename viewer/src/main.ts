// The page of `palpate view`: connects the socket, the view, the panel and the keys.
import * as three from "three";
import { BodySet } from "./bodies";
import { short } from "./colours";
import { bindKeys, showKeys } from "./keyboard";
import { Layers } from "./layers";
import { Hover, showScaleBar, Triad } from "./overlay";
import { Panel } from "./panel";
import { Notice } from "./notice";
import { byId } from "./parts";
import { Connection, type Arrays, type Binary, type Frame, type Refusal, type Stage, type State } from "./protocol";
import { pickedLines, Rate, showLegend, showTags } from "./readouts";
import { Recorder, savePicture } from "./record";
import { SceneView } from "./scene_view";
import { Shadows } from "./shadows";
import "./style.css";
import { Touch } from "./touch";

const speeds = ["0.05", "0.1", "0.25", "0.5", "1", "2", "max"];

class Page {
  private readonly view = new SceneView(byId<HTMLCanvasElement>("canvas"));
  private readonly recorder = new Recorder(this.view.canvas);
  private readonly connection: Connection;
  private readonly touch: Touch;
  private stage?: Stage;
  /** The header as it came: frames change parts of it. */
  private stageText = "";
  private bodies?: BodySet;
  private layers?: Layers;
  private panel?: Panel;
  private state?: State;
  private frame?: Frame;
  private arrays?: Arrays;
  private drawn = 0;
  private picked: number | null = null;
  private readonly notices = new Notice();
  private readonly rate = new Rate();
  private readonly triad = new Triad();
  private readonly shadows = new Shadows(this.view);
  private readonly hover = new Hover(() => this.look());

  constructor() {
    this.touch = new Touch(this.view, {
      stage: () => this.stage!,
      bodies: () => this.bodies!,
      send: (name, values) => this.sendOfHand(name, values),
      picked: (vertex) => this.pick(vertex),
      released: () => (byId("crosshair").hidden = true),
      strength: () => this.panel?.strength ?? 1,
      hover: (body, x, y) => this.showHover(body, x, y),
      offset: (motion) => {
        const driven = this.frame?.counts.driven?.[motion];
        return driven?.moves ? driven.offset : undefined;
      },
    });
    this.view.drawn = () => this.afterDrawing();
    this.view.resized = () => this.view.isMoved || this.fit();
    this.bindButtons();
    this.bindKeys();
    this.setTheme(matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light");
    if (innerWidth <= 720) this.togglePanel();
    this.connection = new Connection({
      stage: (stage) => this.takeStage(stage),
      frame: (frame) => this.takeFrame(frame),
      state: (state) => this.takeState(state),
      refusal: (refusal) => this.takeRefusal(refusal),
      connected: (open) => this.setConnected(open),
    });
  }

  private send(name: string, values: object = {}): void {
    this.connection.send(name, values);
  }

  /** Whether a message describes the scene that is shown, at its start. */
  private isShown({ arrays }: Binary<Stage>, text: string): boolean {
    const [rest, shown] = [arrays["rest"]!, this.bodies?.rest];
    return text === this.stageText && rest.length === shown?.length && rest.every((x, i) => x === shown[i]);
  }

  private takeStage(message: Binary<Stage>): void {
    const first = this.stage === undefined;
    const text = JSON.stringify(message.header);
    if (this.isShown(message, text)) {  // after a lost connection: what the user has chosen stays
      this.panel?.clearTimes();
      return;
    }
    this.stageText = text;
    const stage = (this.stage = message.header);
    this.view.scene.remove(...[this.bodies?.group, this.layers?.group].filter((g) => g !== undefined));
    this.bodies?.dispose();
    this.bodies = new BodySet(message);
    this.layers = new Layers(stage.diagonal, this.bodies);
    this.view.scene.add(this.bodies.group, this.layers.group);
    document.title = `${stage.name} – Palpate`;
    byId("title").textContent = stage.name;
    byId("view").classList.toggle("replay", stage.mode === "replay");
    byId("timeline").hidden = stage.mode !== "replay";
    byId<HTMLInputElement>("seek").max = String((stage.frames ?? 1) - 1);
    this.panel = new Panel(byId("panel"), stage, this.bodies, {
      send: (name, values) => this.send(name, values),
      redraw: () => this.view.redraw(),
      look: () => this.look(),
      viewDirection: () => this.view.camera.getWorldDirection(new three.Vector3()),
      reshade: () => this.reshade(),
      lookFrom: (position, target) => this.fit(position && target ? new three.Vector3(...position).sub(new three.Vector3(...target)) : this.view.corner()),
      inFrame: (change) => this.inFrame(change),
      moveMotion: (motion, time) => this.send("drive_motion", { motion, time }),
    });
    this.picked = null;
    this.view.setUp(new three.Vector3(...(stage.settings.gravity ?? [0, 0, 0])));
    this.shadows.begin(this.bodies);
    if (first) this.panel.showFirstView();
    this.look();
    this.reshade();
  }

  /** Sends what a hand does. Tissue follows only in steps, so a pull in a pause says so. */
  private sendOfHand(name: string, values?: object): void {
    this.send(name, values);
    if (name === "move_pull" && this.state?.playing === false) this.notices.show("The scene is paused. Tissue follows the pull when it plays (Space).");
  }

  /** Fits the visible parts into the frame, as seen from a direction; without one, from the current direction. */
  private fit(from = this.view.back()): void {
    if (this.bodies) this.view.fit(this.bodies.shownPositions(), from);
  }

  /** Runs a change; if all that is shown was in the frame before, it is so after it. */
  private inFrame(change: () => void): void {
    const seen = () => this.bodies && this.view.sees(this.bodies.shownPositions());
    const before = seen();
    change();
    if (before && !seen()) this.fit();
  }

  private reshade(): void {
    this.shadows.stale = true;
    this.updateLayers();
    this.showPick();
    this.view.redraw();
  }

  /** Draws the contacts of the last frame again after other bodies became visible. */
  private updateLayers(): void {
    if (this.frame && this.arrays) this.layers?.update(this.frame, this.arrays);
  }

  private takeFrame(message: Binary<Frame>): void {
    if (!this.bodies || !this.layers || !this.panel || !this.stage) return;
    const frame = (this.frame = message.header);
    this.arrays = message.arrays;
    this.bodies.update(message.arrays);
    if (frame.counts.plan && this.bodies.takePlan(frame.counts.plan)) this.shadows.stale = true;
    this.layers.update(frame, message.arrays);
    if (frame.steps > 0) this.shadows.moved();
    this.layers.setPulls(this.pullEnds(frame));
    this.panel.update(frame);
    this.showPick();
    this.hover.show(this.stage, frame, this.bodies);
    showLegend(this.stage, this.bodies);
    this.rate.show(frame, this.stage, this.connection);
    if (frame.counts.frame !== undefined) {
      const seek = byId<HTMLInputElement>("seek");
      if (document.activeElement !== seek || frame.playing) seek.value = String(frame.counts.frame);
      byId("frame-number").textContent = `${frame.counts.frame + 1} of ${this.stage.frames}`;
    }
    this.view.redraw();
  }

  /** Moves the labels that belong to places of the view. */
  private afterDrawing(): void {
    if (this.stage && this.bodies) {
      const ink = getComputedStyle(document.documentElement).getPropertyValue("--ink").trim();
      this.triad.draw(this.view, this.stage.axes, ink);
      showScaleBar(this.view, this.stage.units);
      if (this.frame) showTags(this.frame, this.stage, this.bodies, this.view);
    }
    this.recorder.drawn();
    this.tellShown();
  }

  private showHover(body: number | null, x: number, y: number): void {
    this.hover.move(body, x, y);
    if (this.stage && this.bodies) this.hover.show(this.stage, this.frame, this.bodies);
  }

  /** Asks for a new frame only after a frame was drawn, so that frames never queue up. */
  private tellShown(): void {
    if (!this.frame || this.frame.frame === this.drawn) return;
    this.drawn = this.frame.frame;
    this.send("shown", { frame: this.drawn });
  }

  private pullEnds(frame: Frame): Float32Array {
    const pulls = frame.counts.pulls ?? [];
    const ends = new Float32Array(6 * pulls.length);
    pulls.forEach((pull, i) => {
      ends.set(this.bodies!.positions.subarray(3 * pull.vertex, 3 * pull.vertex + 3), 6 * i);
      ends.set(pull.target, 6 * i + 3);
    });
    return ends;
  }

  private pick(vertex: number | null): void {
    this.picked = vertex;
    this.look();
    this.showPick();
    this.view.redraw();
  }

  private look(): void {
    const panel = this.panel;
    if (!panel || !this.layers) return;
    const { arrows, borders, cells, colouring, forces } = panel.shown;
    this.layers.showArrows = arrows;
    this.layers.showBorders = borders;
    this.layers.showCells = cells;
    const contacts = arrows || colouring === "depth" || this.picked !== null;
    const fields = (this.stage!.fields ?? []).some((field) => field.name === colouring) ? [colouring] : [];
    this.send("look", { contacts, borders, cells, inside: this.bodies!.needsInnerPoints, forces: forces || this.hover.on, fields });
    this.updateLayers();
    showLegend(this.stage!, this.bodies!);
    this.view.redraw();
  }

  private showPick(): void {
    if (!this.stage || !this.bodies) return;
    const place = this.picked === null ? null : this.bodies.vertex(this.picked);
    const seen = place !== null && this.bodies.shows(this.bodies.bodyOf(this.picked!), place);
    this.layers?.setMarker(seen ? place : null);
    this.panel?.showPick(pickedLines(this.picked, this.frame, this.stage, this.bodies));
  }

  private takeState(state: State): void {
    this.state = state;
    const play = byId("play");
    play.textContent = state.playing ? "Pause" : "Play";
    const speed = byId<HTMLSelectElement>("speed");
    const value = String(state.speed);
    if (![...speed.options].some((o) => o.value === value)) speed.add(new Option(`× ${short(Number(value))}`, value));
    speed.value = value;
    this.panel?.state(state);
    if (state.error) this.notices.show(`The simulation has stopped: ${state.error}. Reset begins again.`, true);
    else this.notices.hideError();
  }

  private takeRefusal(refusal: Refusal): void {
    this.notices.show(refusal.why);
  }

  private setConnected(open: boolean): void {
    document.body.dataset["connected"] = String(open);
    if (open) {
      this.notices.hide();
      this.look();
    } else {
      this.drawn = 0;
      this.frame = undefined;
      this.touch.letGo();
      byId("tags").replaceChildren();
      this.notices.show("No connection to the server; trying again.", true);
    }
  }

  private bindButtons(): void {
    const click = (id: string, act: () => void) => byId(id).addEventListener("click", act);
    click("play", () => this.togglePlay());
    click("step", () => this.send("step"));
    click("reset", () => this.reset());
    click("fit", () => this.fit());
    click("picture", () => this.savePicture());
    click("video", () => this.toggleVideo());
    click("theme", () => this.toggleTheme());
    click("help", showKeys);
    click("panel-toggle", () => this.togglePanel());
    const speed = byId<HTMLSelectElement>("speed");
    for (const value of speeds) speed.add(new Option(value === "max" ? "max" : `× ${value}`, value));
    speed.addEventListener("change", () => this.send("speed", { speed: speed.value === "max" ? "max" : Number(speed.value) }));
    const seek = byId<HTMLInputElement>("seek");
    seek.addEventListener("input", () => this.seek(seek.valueAsNumber));
  }

  private seek(frame: number): void {
    if (this.state?.playing) this.send("play", { on: false });
    this.send("seek", { frame });
  }

  /** One frame forwards or backwards; in a running simulation only forwards. */
  private stepBy(by: number): void {
    const frame = this.frame?.counts.frame;
    if (frame === undefined) {
      if (by > 0) this.send("step");
      return;
    }
    this.seek(Math.min(Math.max(frame + by, 0), (this.stage?.frames ?? 1) - 1));
  }

  private reset(): void {
    this.send("reset");
    this.panel?.clearTimes();
    this.panel?.setColouring(this.panel.shown.colouring);
  }

  private togglePlay(): void {
    this.send("play", { on: !this.state?.playing });
  }

  private savePicture(): void {
    this.view.draw();
    savePicture(this.view.canvas, this.stage?.name ?? "palpate");
  }

  private toggleVideo(): void {
    const button = byId("video");
    try {
      this.view.draw();
      if (this.recorder.running) this.recorder.stop();
      else this.recorder.start(this.stage?.name ?? "palpate");
      this.view.redraw();  // an unchanged canvas gives no picture
    } catch (error) {
      this.notices.show(String(error));
    }
    button.setAttribute("aria-pressed", String(this.recorder.running));
    button.textContent = this.recorder.running ? "Stop" : "Video";
  }

  private setTheme(theme: string): void {
    document.documentElement.dataset["theme"] = theme;
    this.view.setBackground(getComputedStyle(document.documentElement).getPropertyValue("--scene").trim());
  }

  private toggleTheme(): void {
    this.setTheme(document.documentElement.dataset["theme"] === "dark" ? "light" : "dark");
  }

  private togglePanel(): void {
    const closed = byId("panel").classList.toggle("closed");
    byId("panel-toggle").setAttribute("aria-expanded", String(!closed));
  }

  /** Grabs the place in the middle of the view, or releases it. */
  private toggleHold(): void {
    if (this.touch.holds) return this.touch.letGo();
    const { x, y } = this.view.middle();
    if (!this.touch.take(x, y)) this.notices.show("There is nothing to pull at the middle of the view.");
    byId("crosshair").hidden = !this.touch.holds;
  }

  private arrow(x: number, y: number): void {
    if (this.touch.holds) this.touch.nudge(x, y);
    else this.view.turn(-0.1 * x, -0.1 * y);
  }

  private bindKeys(): void {
    const tick = (id: string) => () => document.getElementById(id)?.click();
    const colours = ["body", "depth", "displacement"] as const;
    bindKeys([
      { key: " ", name: "Space", does: "play or pause", act: () => this.togglePlay() },
      { key: "n", does: "one step, or the next frame", act: () => this.stepBy(1) },
      { key: "b", does: "the frame before (stored results)", act: () => this.stepBy(-1) },
      { key: "r", does: "back to the start", act: () => this.reset() },
      { key: "g", does: "take hold of the tissue at the middle of the view, or let go; arrows then move it", act: () => this.toggleHold() },
      { key: "ArrowLeft", name: "←", does: "turn the view, or move what is held", act: () => this.arrow(-1, 0) },
      { key: "ArrowRight", name: "→", does: "", act: () => this.arrow(1, 0) },
      { key: "ArrowUp", name: "↑", does: "", act: () => this.arrow(0, 1) },
      { key: "ArrowDown", name: "↓", does: "", act: () => this.arrow(0, -1) },
      { key: "+", does: "nearer", act: () => this.view.zoom(1 / 1.1) },
      { key: "-", does: "further away", act: () => this.view.zoom(1.1) },
      { key: "f", does: "see everything", act: () => this.fit() },
      ...colours.map((c, i) => ({ key: String(i + 1), does: `colours show ${c}`, act: () => this.panel?.setColouring(c) })),
      { key: "a", does: "direction and depth of contacts", act: tick("show-arrows") },
      { key: "e", does: "border edges and crossings", act: tick("show-borders") },
      { key: "d", does: "grid cells", act: tick("show-cells") },
      { key: "c", does: "cut the bodies open", act: tick("cut") },
      { key: "p", does: "save a picture", act: () => this.savePicture() },
      { key: "v", does: "record a video", act: () => this.toggleVideo() },
      { key: "t", does: "light or dark", act: () => this.toggleTheme() },
      { key: "?", does: "this list", act: showKeys },
    ]);
  }
}

new Page();
