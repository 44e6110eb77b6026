// What is read off beside the bodies: the force of the pull, the picked point, the scale of colours, time and rate.
import * as three from "three";
import type { BodySet } from "./bodies";
import { amountGradient, short } from "./colours";
import { byId, make } from "./parts";
import type { Connection, Frame, Stage } from "./protocol";
import type { SceneView } from "./scene_view";

function forceText(force: readonly number[], stage: Stage): string {
  const { length, mass, time } = stage.units;
  const unit = length === "m" && mass === "kg" && time === "s" ? "N" : `${mass} ${length}/${time}²`;
  return `${short(Math.hypot(...force))} ${unit}`;
}

/** The force of the pull, beside its end. */
export function showTag(frame: Frame, stage: Stage, view: SceneView): void {
  const pull = frame.counts.pulls?.[0];
  const tag = byId("tag");
  tag.hidden = !pull;
  if (!pull) return;
  tag.textContent = forceText(pull.force, stage);
  const { x, y } = view.place(new three.Vector3(...pull.target));
  tag.style.transform = `translate(${x + 14}px, ${y - 30}px)`;
}

/** What there is to say of a picked vertex. */
export function pickedLines(vertex: number | null, frame: Frame | undefined, stage: Stage, bodies: BodySet): [string, string][] {
  if (vertex === null) return [];
  const unit = stage.units.length;
  const place = bodies.vertex(vertex).add(new three.Vector3(...stage.origin));
  const body = stage.bodies.find((b) => b.vertices[0] <= vertex && vertex < b.vertices[1]);
  const pull = frame?.counts.pulls?.find((p) => p.vertex === vertex);
  const lines: [string, string][] = [
    ["body", body?.name ?? ""],
    [`position (${unit})`, place.toArray().map(short).join(", ")],
    ["displacement", `${short(bodies.displacement(vertex))} ${unit}`],
    ["depth", `${short(bodies.depths[vertex]!)} ${unit}`],
  ];
  if (pull) lines.push(["pulled with", forceText(pull.force, stage)]);
  return lines;
}

/** The scale of the colours, in the unit of the scene. */
export function showLegend(stage: Stage, bodies: BodySet): void {
  const legend = byId("legend");
  legend.hidden = bodies.colouring === "body";
  if (legend.hidden) return;
  byId("legend-title").textContent = `${bodies.colouring === "depth" ? "Depth" : "Displacement"} (${stage.units.length})`;
  const bar = byId<HTMLCanvasElement>("legend-bar");
  const context = bar.getContext("2d")!;
  context.fillStyle = amountGradient(context, bar.width);
  context.fillRect(0, 0, bar.width, bar.height);
  const ticks = [0, 0.5, 1].map((share) => short(share * bodies.scale));
  const element = byId("legend-ticks");
  if (element.textContent !== ticks.join("")) element.replaceChildren(...ticks.map((tick) => make("span", {}, tick)));
}

/** Simulated time, and how many frames and bytes come in a second. */
export class Rate {
  private time = performance.now();
  private bytes = 0;
  private frames = 0;
  private text = "";

  show(frame: Frame, stage: Stage, connection: Connection): void {
    const now = performance.now();
    if (now - this.time > 1000) {
      const seconds = (now - this.time) / 1000;
      const frames = (connection.frames - this.frames) / seconds;
      const bytes = (connection.bytes - this.bytes) / seconds;
      this.text = `, ${frames.toFixed(0)} frames/s, ${(bytes / 1e6).toFixed(1)} MB/s`;
      this.time = now;
      this.frames = connection.frames;
      this.bytes = connection.bytes;
    }
    const step = frame.counts.step === undefined ? "" : `, step ${frame.counts.step}`;
    byId("clock").textContent = `t = ${frame.time.toFixed(3)} ${stage.units.time}${step}${this.text}`;
  }
}
