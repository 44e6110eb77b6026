// Forces over simulated time: contact forces on the bodies with the largest ones, and forces of pulls. For a
// running simulation over the last frames, for stored results over the whole run, with a mark at the current
// frame.
import type { BodySet } from "./bodies";
import { css, niceAbove, short } from "./colours";
import type { Frame, Stage } from "./protocol";
import { force, unitForPeople } from "./units";

interface Sample {
  time: number;
  bodies: number[];
  held: number;
}

const most = 300;
const lines = 4;

export class ForceChart {
  private samples: Sample[] = [];
  /** For stored results: the time shown. */
  private mark?: number;

  constructor(
    private readonly canvas: HTMLCanvasElement,
    private readonly stage: Stage,
    private readonly bodies: BodySet,
  ) {
    const { forces } = stage;
    if (forces) this.samples = forces.times.map((time, i) => ({ time, bodies: forces.bodies.map((of) => of[i]!), held: 0 }));
    new ResizeObserver(() => this.draw()).observe(canvas);
  }

  add(frame: Frame): void {
    if (this.stage.forces) {
      this.mark = frame.time;
      this.draw();
      return;
    }
    if (!frame.forces) return;
    const last = this.samples.at(-1);
    if (last && frame.time < last.time) this.samples = [];
    if (last && frame.time === last.time) this.samples.pop();
    const held = frame.counts.pulls?.[0]?.force ?? frame.counts.driven?.find((motion) => motion.force)?.force ?? [0];
    this.samples.push({ time: frame.time, bodies: frame.forces.map((w) => Math.hypot(...w.force)), held: Math.hypot(...held) });
    if (this.samples.length > most) this.samples.shift();
    this.draw();
  }

  clear(): void {
    if (!this.stage.forces) this.samples = [];
    this.draw();
  }

  /** The bodies with the largest forces, and the hand. */
  private shown(): { name: string; colour: string; of: (sample: Sample) => number }[] {
    const peaks = this.stage.bodies.map((_, b) => Math.max(0, ...this.samples.map((s) => s.bodies[b] ?? 0)));
    const order = peaks.map((_, b) => b).filter((b) => peaks[b]! > 0).sort((a, b) => peaks[b]! - peaks[a]!);
    const list = order.slice(0, lines).map((b) => ({ name: this.stage.bodies[b]!.name, colour: css(this.bodies.meshes[b]!.colour), of: (s: Sample) => s.bodies[b] ?? 0 }));
    if (this.samples.some((s) => s.held > 0)) list.push({ name: "hand", colour: "#d55e00", of: (s) => s.held });
    return list;
  }

  /** The sample at the mark; without a mark, the last. */
  private shownSample(): Sample {
    const { mark } = this;
    const next = mark === undefined ? undefined : this.samples.find((s) => s.time >= mark - 1e-9 * Math.abs(mark));
    return next ?? this.samples.at(-1)!;
  }

  private draw(): void {
    const context = this.canvas.getContext("2d")!;
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (width === 0) return;
    this.canvas.width = Math.round(width * devicePixelRatio);
    this.canvas.height = Math.round(height * devicePixelRatio);
    context.setTransform(devicePixelRatio, 0, 0, devicePixelRatio, 0, 0);
    const style = getComputedStyle(this.canvas);
    context.font = `11px ${style.fontFamily}`;
    const shown = this.shown();
    const top = niceAbove(Math.max(...this.samples.map((s) => Math.max(0, ...shown.map((line) => line.of(s)))), 0));
    const unit = unitForPeople(top, this.stage.units, force);
    const floor = height - 14 * (shown.length + 1);
    const begin = this.samples[0]?.time ?? 0;
    const span = Math.max((this.samples.at(-1)?.time ?? 0) - begin, 1e-9);
    shown.forEach((line, i) => {
      context.strokeStyle = context.fillStyle = line.colour;
      context.lineWidth = 1.6;
      context.beginPath();
      for (const s of this.samples) context.lineTo(((s.time - begin) / span) * width, floor - (line.of(s) / (top || 1)) * (floor - 14));
      context.stroke();
      const y = floor + 14 * (i + 1) + 4;
      context.fillRect(2, y - 6, 10, 3);
      context.fillStyle = style.color;
      const now = line.of(this.shownSample());
      context.fillText(`${line.name}: ${short(unit.factor * now)} ${unit.name}`, 16, y);
    });
    context.fillStyle = style.color;
    context.fillRect(0, floor, width, 1);
    if (this.mark !== undefined) context.fillRect(((this.mark - begin) / span) * (width - 1), 14, 1, floor - 14);
    context.fillText(top > 0 ? `${short(unit.factor * top)} ${unit.name}` : "no forces yet", 2, 10);
  }
}
