// Values beside the bodies: the force of the pull, the picked point, the scale of colours, time and rate.
import * as three from "three";
import type { BodySet } from "./bodies";
import { amountGradient, css, neutral, short } from "./colours";
import { byId, make } from "./parts";
import type { Connection, Frame, Stage } from "./protocol";
import type { SceneView } from "./scene_view";
import { force, forceText, inWords, length, unitForPeople, type UnitForPeople } from "./units";

interface Held {
  force: readonly number[];
  place: three.Vector3;
  /** For a pull: the largest force that the tissue can bear. */
  most?: number;
}

/** What users hold: pulls of all pages, and bodies with a prescribed motion that are moved by hand. */
function heldIn(frame: Frame, stage: Stage, bodies: BodySet): Held[] {
  const pulls = (frame.counts.pulls ?? []).map((pull) => ({ force: pull.force, place: bodies.vertex(pull.vertex), most: pull.most }));
  const driven = (frame.counts.driven ?? []).flatMap((motion, i) =>
    motion.force && stage.motions[i] ? [{ force: motion.force, place: middleOf(stage.motions[i].body, bodies) }] : []);
  return [...pulls, ...driven];
}

function middleOf(body: number, bodies: BodySet): three.Vector3 {
  const [begin, end] = bodies.meshes[body]!.info.vertices;
  const place = new three.Vector3();
  for (let v = begin; v < end; ++v) place.add(bodies.vertex(v));
  return place.divideScalar(end - begin);
}

/** At the limit, the spring has the force that the tissue can bear, minus that of its damper. */
const nearLimit = 0.97;

/** Shows the force on each point or body that is held, next to it. */
export function showTags(frame: Frame, stage: Stage, bodies: BodySet, view: SceneView): void {
  const held = heldIn(frame, stage, bodies);
  const tags = byId("tags");
  while (tags.children.length < held.length) tags.append(make("div", { class: "tag" }));
  while (tags.children.length > held.length) tags.lastElementChild!.remove();
  held.forEach((one, i) => showTag(tags.children[i] as HTMLElement, one, stage, view));
}

function showTag(tag: HTMLElement, held: Held, stage: Stage, view: SceneView): void {
  const limited = held.most !== undefined && Math.hypot(...held.force) >= nearLimit * held.most;
  tag.textContent = forceText(held.force, stage.units) + (limited ? " – the most this tissue can take" : "");
  tag.classList.toggle("limited", limited);
  const { x, y } = view.place(held.place);
  const left = x > 0.6 * view.canvas.clientWidth ? x - 14 - tag.offsetWidth : x + 14;
  tag.style.transform = `translate(${left}px, ${y - 30}px)`;
}

/** The values at a picked vertex, as text. */
export function pickedLines(vertex: number | null, frame: Frame | undefined, stage: Stage, bodies: BodySet): [string, string][] {
  if (vertex === null) return [];
  const unit = unitForPeople(stage.diagonal, stage.units, length);
  const place = bodies.vertex(vertex).add(new three.Vector3(...stage.origin));
  const body = stage.bodies.find((b) => b.vertices[0] <= vertex && vertex < b.vertices[1]);
  const pull = frame?.counts.pulls?.find((p) => p.vertex === vertex);
  const lines: [string, string][] = [
    ["body", body?.name ?? ""],
    [`position (${unit.name})`, place.toArray().map((x) => short(unit.factor * x)).join(", ")],
    ["displacement", inWords(bodies.displacement(vertex), stage.units, length)],
    ["depth", inWords(bodies.depths[vertex]!, stage.units, length)],
  ];
  if (pull) {
    lines.push(["pulled with", forceText(pull.force, stage.units)]);
    lines.push(["tissue can take", inWords(pull.most, stage.units, force)]);
  }
  return lines;
}

/** The quantity that colours show, and its unit of display. */
export function shownAmount(stage: Stage, bodies: BodySet): { title: string; unit: UnitForPeople } {
  const field = stage.fields?.find((f) => f.name === bodies.colouring);
  const { least, most } = bodies.scale;
  const unit = unitForPeople(Math.max(Math.abs(least), Math.abs(most)), stage.units, field?.dimension ?? [0, 1, 0]);
  const title = field?.title ?? bodies.colouring;
  return { title: title[0]!.toUpperCase() + title.slice(1), unit };
}

/** The scale of the colours. */
export function showLegend(stage: Stage, bodies: BodySet): void {
  const legend = byId("legend");
  legend.hidden = bodies.colouring === "body";
  if (legend.hidden) return;
  const { title, unit } = shownAmount(stage, bodies);
  byId("legend-title").textContent = unit.name ? `${title} (${unit.name})` : title;
  const bar = byId<HTMLCanvasElement>("legend-bar");
  const context = bar.getContext("2d")!;
  const { automatic, least, most } = bodies.scale;
  const equal = !(least < most);
  context.fillStyle = equal ? css(neutral) : amountGradient(context, bar.width);
  context.fillRect(0, 0, bar.width, bar.height);
  const none = automatic ? "all 0" : "the scale has no ends";
  const ticks = equal ? [none] : [0, 0.5, 1].map((fraction) => short(unit.factor * (least + fraction * (most - least))));
  const element = byId("legend-ticks");
  if (element.textContent !== ticks.join("")) element.replaceChildren(...ticks.map((tick) => make("span", {}, tick)));
}

/** ", stage press (2 of 3)", in a scene with stages. */
function stageText({ counts: { plan } }: Frame, { stages = [] }: Stage): string {
  if (!plan) return "";
  return plan.done ? ", all stages done" : `, stage ${plan.stage} (${plan.number} of ${stages.length})`;
}

/** Simulated time; for developers also frames and bytes per second. */
export class Rate {
  private time = performance.now();
  private bytes = 0;
  private frames = 0;

  show(frame: Frame, stage: Stage, connection: Connection): void {
    const now = performance.now();
    if (now - this.time > 1000) {
      const seconds = (now - this.time) / 1000;
      const frames = (connection.frames - this.frames) / seconds;
      const bytes = (connection.bytes - this.bytes) / seconds;
      byId("rate").textContent = `${frames.toFixed(0)} frames/s, ${(bytes / 1e6).toFixed(1)} MB/s`;
      this.time = now;
      this.frames = connection.frames;
      this.bytes = connection.bytes;
    }
    const step = frame.counts.step === undefined ? "" : `, step ${frame.counts.step}`;
    byId("clock").textContent = `t = ${frame.time.toFixed(3)} ${stage.units.time}${step}${stageText(frame, stage)}`;
  }
}
