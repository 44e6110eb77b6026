// Over the view: the directions of the axes, a scale bar, and the body under the mouse.
import * as three from "three";
import type { BodySet } from "./bodies";
import { niceBelow, short } from "./colours";
import { byId } from "./parts";
import type { Frame, Stage, Wrench } from "./protocol";
import type { SceneView } from "./scene_view";
import { forceText, inWords, length, torque, unitForPeople, type Units } from "./units";

const opposite: Record<string, string> = { L: "R", R: "L", A: "P", P: "A", S: "I", I: "S" };
const sides: Record<string, string> = { L: "left", R: "right", A: "anterior", P: "posterior", S: "superior", I: "inferior" };
const colours = ["#d1495b", "#2e933c", "#3066be"];

/** Minimum distance between letters, pixels. */
const letterSize = 14;

/** An end of an axis in the view; z points to the eye. */
interface End {
  direction: three.Vector3;
  letter: string;
  colour: string;
  strong: boolean;
}

/** The three axes as lines from a centre, those that point away behind the others; with the sides of a patient if the scene names them. */
export class Triad {
  private readonly context = byId<HTMLCanvasElement>("triad").getContext("2d")!;
  private last = "";

  draw(view: SceneView, axes: string | undefined, ink: string): void {
    const state = view.camera.quaternion.toArray().map((x) => x.toFixed(3)).join() + axes + ink + devicePixelRatio;
    if (state === this.last) return;
    this.last = state;
    const canvas = this.context.canvas;
    const size = canvas.clientWidth;
    canvas.width = canvas.height = Math.round(size * devicePixelRatio);
    this.context.setTransform(devicePixelRatio, 0, 0, devicePixelRatio, canvas.width / 2, canvas.height / 2);
    this.context.font = "600 12px system-ui, sans-serif";
    this.context.textAlign = "center";
    this.context.textBaseline = "middle";
    const turn = view.camera.quaternion.clone().invert();
    const ends = [0, 1, 2].flatMap((axis) => (axes ? [1, -1] : [1]).map((sign) => {
      const direction = new three.Vector3().setComponent(axis, sign).applyQuaternion(turn);
      const letter = axes ? (sign > 0 ? axes[axis]! : opposite[axes[axis]!]!) : "XYZ"[axis]!;
      return { direction, letter, colour: colours[axis]!, strong: sign > 0 };
    }));
    ends.sort((a, b) => a.direction.z - b.direction.z);
    for (const end of ends) this.drawLine(end, 0.34 * size);
    this.drawLetters(ends.reverse(), 0.34 * size + 9, ink);
    const named = axes ? [...axes].map((side, i) => `${"xyz"[i]} ${sides[side]}`).join(", ") : "x, y, z";
    canvas.setAttribute("aria-label", `Orientation of the axes: ${named}`);
  }

  private drawLine({ direction, colour, strong }: End, size: number): void {
    const context = this.context;
    context.globalAlpha = direction.z < -0.2 ? 0.45 : 1;
    context.strokeStyle = colour;
    context.lineWidth = strong ? 2.5 : 1;
    context.beginPath();
    context.moveTo(0, 0);
    context.lineTo(size * direction.x, -size * direction.y);
    context.stroke();
    context.globalAlpha = 1;
  }

  /** Labels, the nearest first; none is drawn over another. */
  private drawLetters(ends: readonly End[], size: number, ink: string): void {
    const context = this.context;
    const taken: [number, number][] = [];
    context.fillStyle = ink;
    for (const { direction, letter } of ends) {
      const [x, y] = [size * direction.x, -size * direction.y];
      if (taken.some(([u, v]) => Math.hypot(x - u, y - v) < letterSize)) continue;
      taken.push([x, y]);
      context.globalAlpha = direction.z < -0.2 ? 0.45 : 1;
      context.fillText(letter, x, y);
    }
    context.globalAlpha = 1;
  }
}

/** A scale bar with a round length, for the depth at which the camera looks. */
export function showScaleBar(view: SceneView, units: Units): void {
  const size = niceBelow(140 / view.pixelsPer());
  const unit = unitForPeople(size, units, length);
  const bar = byId("scale-bar");
  bar.style.width = `${(size * view.pixelsPer()).toFixed(1)}px`;
  const text = `${short(unit.factor * size)} ${unit.name}`;
  if (bar.textContent !== text) bar.textContent = text;
}

/** The name of the body under the mouse, with the force of its contacts and of what holds it, if the server sends them. */
export class Hover {
  private body: number | null = null;
  private place = { x: 0, y: 0 };

  constructor(private readonly changed: () => void) {}

  get on(): boolean {
    return this.body !== null;
  }

  move(body: number | null, x: number, y: number): void {
    const before = this.body;
    this.body = body;
    this.place = { x, y };
    if ((before === null) !== (body === null)) this.changed();
  }

  show(stage: Stage, frame: Frame | undefined, bodies: BodySet): void {
    const element = byId("hover");
    element.hidden = this.body === null || bodies.opacity(this.body) === 0;
    if (element.hidden || this.body === null) return;
    const wrench = frame?.forces?.[this.body];
    const lines = [stage.bodies[this.body]!.name];
    const add = (name: string, of?: Wrench) => {
      if (of && Math.hypot(...of.force) > 0) {
        lines.push(`${name}: ${forceText(of.force, stage.units)}, ${inWords(Math.hypot(...of.torque), stage.units, torque)}`);
      }
    };
    add("contacts", wrench);
    add("held by", wrench?.held);
    element.textContent = lines.join("\n");
    element.style.transform = `translate(${this.place.x + 14}px, ${this.place.y + 16}px)`;
  }
}
