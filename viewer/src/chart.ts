// Chart of times: the last frames as stacked bars of ms per phase, with a line for the budget, and the
// contacts and movers below.
import { niceAbove, phaseColours, short } from "./colours";
import type { Frame } from "./protocol";

interface Sample {
  phases: number[];
  step: number;
  contacts: number;
  movers: number;
}

export class Chart {
  private budgetLine = 0;
  private samples: Sample[] = [];
  private readonly most = 240;
  private readonly fraction = 0.62;

  constructor(private readonly canvas: HTMLCanvasElement) {
    new ResizeObserver(() => this.draw()).observe(canvas);
  }

  /** Allowed time of a step, ms. */
  get budget(): number {
    return this.budgetLine;
  }
  set budget(ms: number) {
    this.budgetLine = ms;
    this.draw();
  }

  add(frame: Frame): void {
    if (frame.steps === 0) return;
    const values = Object.entries(frame.ms).filter(([name]) => name !== "step");
    this.samples.push({
      phases: values.map(([, ms]) => ms),
      step: frame.ms["step"] ?? 0,
      contacts: frame.counts.contacts,
      movers: frame.counts.movers,
    });
    if (this.samples.length > this.most) this.samples.shift();
    this.draw();
  }

  clear(): void {
    this.samples = [];
    this.draw();
  }

  private draw(): void {
    const context = this.canvas.getContext("2d")!;
    const ratio = devicePixelRatio;
    const width = this.canvas.clientWidth;
    const height = this.canvas.clientHeight;
    if (width === 0) return;
    this.canvas.width = Math.round(width * ratio);
    this.canvas.height = Math.round(height * ratio);
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    const style = getComputedStyle(this.canvas);
    context.font = `11px ${style.fontFamily}`;
    this.drawTimes(context, width, Math.round(this.fraction * height), style.color);
    this.drawCounts(context, width, Math.round(this.fraction * height) + 8, height, style.color);
  }

  private drawTimes(context: CanvasRenderingContext2D, width: number, height: number, ink: string): void {
    const most = niceAbove(Math.max(...this.samples.map((s) => s.step), this.budget, 1e-3));
    const bar = width / this.most;
    this.samples.forEach((sample, i) => {
      let y = height;
      sample.phases.forEach((ms, phase) => {
        const tall = (ms / most) * height;
        context.fillStyle = phaseColours[phase % phaseColours.length]!;
        context.fillRect(i * bar, y - tall, Math.ceil(bar), tall);
        y -= tall;
      });
    });
    context.strokeStyle = context.fillStyle = ink;
    if (this.budget > 0) {
      const y = height - (this.budget / most) * height;
      context.setLineDash([4, 3]);
      context.beginPath();
      context.moveTo(0, y);
      context.lineTo(width, y);
      context.stroke();
      context.setLineDash([]);
      const label = `budget ${short(this.budget)} ms`;
      context.fillText(label, width - context.measureText(label).width - 2, y < 14 ? y + 12 : y - 3);
    }
    context.fillText(`${short(most)} ms`, 2, 10);
    context.fillRect(0, height, width, 1);
  }

  private drawCounts(context: CanvasRenderingContext2D, width: number, top: number, bottom: number, ink: string): void {
    const line = (of: (sample: Sample) => number, colour: string, label: string, x: number) => {
      const most = niceAbove(Math.max(...this.samples.map(of), 1));
      context.strokeStyle = context.fillStyle = colour;
      context.beginPath();
      this.samples.forEach((s, i) => context.lineTo((i * width) / this.most, bottom - 2 - (of(s) / most) * (bottom - top - 16)));
      context.stroke();
      context.fillRect(x, top + 4, 10, 3);
      context.fillStyle = ink;
      context.fillText(`${label} (to ${short(most)})`, x + 14, top + 10);
    };
    line((s) => s.contacts, "#d55e00", "contacts", 2);
    line((s) => s.movers, "#56b4e9", "movers", width / 2);
  }
}
