// Settings that can change while a simulation runs. The controls show the settings of the server, so that
// several pages agree.
import type { Settings, Stage, Vector } from "./protocol";
import { choose, make, row, section, slider, type Slider } from "./parts";
import { short } from "./colours";

type Change = (settings: Settings) => void;

/** A setting that is a word or a number. */
interface Field {
  key: string;
  label: string;
  word: string;
  low: number;
  high: number;
  start: number;
  logarithmic: boolean;
  unit?: string;
  whole?: boolean;
  developer?: boolean;
}

export class SettingsPanel {
  /** The settings for users, and those only for developers of the contact query. */
  readonly element: HTMLDetailsElement;
  readonly developer: HTMLElement = make("div");
  private readonly updates: ((settings: Settings) => void)[] = [];

  constructor(
    private readonly stage: Stage,
    private readonly change: Change,
  ) {
    this.element = section("Settings", false);
    this.element.id = "settings";
    const contact = stage.settings.contact ?? {};
    this.addGravity();
    const units = stage.units;
    const si = units.length === "m" && units.mass === "kg" && units.time === "s";
    const stiffness = stage.typical_stiffness ?? 1000;
    const fields: Field[] = [
      { key: "stiffness", label: "Contact stiffness", word: "auto", low: stiffness / 100, high: stiffness * 100, start: stiffness, logarithmic: true, unit: si ? "N/m" : "" },
      { key: "cells_per_primitive", label: "Cells per primitive", word: "exact", low: 1, high: 27, start: 8, logarithmic: false, whole: true, developer: true },
    ];
    this.addNumber("friction", "Friction", 0, 1.5);
    if (stage.choices?.["budget"]) this.addBudget();
    for (const field of fields) if (field.key in contact) this.addField(field);
    for (const key of ["structure", "order", "sort"]) this.addChoice(key, stage.choices?.[key] ?? []);
    this.element.append(
      row("As in the scene", this.button("Restore", () => change(stage.settings))),
    );
    this.update(stage.settings);
  }

  private button(text: string, click: () => void): HTMLButtonElement {
    const button = document.createElement("button");
    button.textContent = text;
    button.addEventListener("click", click);
    return button;
  }

  update(settings: Settings): void {
    for (const update of this.updates) update(settings);
  }

  private set(key: string, value: number | string): void {
    this.change({ contact: { [key]: value } });
  }

  /** Sets the size of gravity; its direction stays, and is -z if there is none. */
  private addGravity(): void {
    const start = this.stage.settings.gravity ?? [0, 0, 0];
    const size = Math.hypot(...start);
    const direction = size > 0 ? start.map((g) => g / size) : [0, 0, -1];
    const { length, time } = this.stage.units;
    const control = slider({
      id: "gravity",
      label: "Gravity",
      low: 0,
      high: 2 * (size || 9.81),
      value: size,
      show: (g) => `${short(g)} ${length}/${time}²`,
      change: (g) => this.change({ gravity: direction.map((d) => d * g) as Vector }),
    });
    this.updates.push((settings) => settings.gravity && control.set(Math.hypot(...settings.gravity)));
    this.element.append(row("Gravity", control.element));
  }

  private addNumber(key: string, label: string, low: number, high: number): void {
    const control = slider({ id: key, label, low, high, value: low, show: short, change: (v) => this.set(key, v) });
    this.updates.push((settings) => control.set(Number(settings.contact?.[key] ?? low)));
    this.element.append(row(label, control.element));
  }

  private addField(field: Field): void {
    let control: Slider | undefined;
    const numeric = (settings: Settings) => typeof settings.contact?.[field.key] === "number";
    const word = choose([field.word, "number"], field.word, (value) =>
      this.set(field.key, value === field.word ? field.word : field.start), `${field.key}-word`);
    word.setAttribute("aria-label", `${field.label}: ${field.word} or a number`);
    control = slider({
      id: field.key,
      label: field.label,
      low: field.low,
      high: field.high,
      value: field.start,
      logarithmic: field.logarithmic,
      show: (v) => `${short(field.whole ? Math.round(v) : v)} ${field.unit ?? ""}`,
      change: (v) => this.set(field.key, field.whole ? Math.round(v) : v),
    });
    const line = row("", control.element);
    this.updates.push((settings) => {
      line.hidden = !numeric(settings);
      word.value = numeric(settings) ? "number" : field.word;
      if (numeric(settings)) control.set(Number(settings.contact![field.key]));
    });
    (field.developer ? this.developer : this.element).append(row(field.label, word), line);
  }

  /** The time budget for all detections of a step. */
  private addBudget(): void {
    const set = (ms: number | null) => this.change({ contact: { budget: ms === null ? null : { milliseconds: ms } } });
    const given = (settings: Settings) => (settings.contact?.["budget"] as { milliseconds?: number } | undefined)?.milliseconds;
    const word = choose(["none", "ms"], "none", (value) => set(value === "none" ? null : 1), "budget-word");
    const control = slider({ id: "budget", label: "Budget of contacts", low: 0.01, high: 100, value: 1, logarithmic: true, show: (ms) => `${short(ms)} ms`, change: set });
    const line = row("", control.element);
    this.updates.push((settings) => {
      const ms = given(settings);
      line.hidden = ms === undefined;
      word.value = ms === undefined ? "none" : "ms";
      if (ms !== undefined) control.set(ms);
    });
    this.developer.append(row("Budget of contacts", word), line);
  }

  private addChoice(key: string, names: string[]): void {
    if (names.length === 0) return;
    const control = choose(names, names[0]!, (value) => this.set(key, value), key);
    this.updates.push((settings) => (control.value = String(settings.contact?.[key] ?? names[0])));
    this.developer.append(row(key[0]!.toUpperCase() + key.slice(1), control));
  }
}
