// The ends of the scale of colours: automatic, which grows with the values, or fixed.
import type { BodySet } from "./bodies";
import { choose, make, row } from "./parts";
import type { Stage } from "./protocol";
import { shownAmount } from "./readouts";

export class ScaleControl {
  readonly element = make("div", { id: "scale" });
  private readonly kind = choose(["automatic", "fixed"], "automatic", (value) => this.setKind(value === "automatic"), "scale-kind");
  private readonly least = this.end("scale-least", "Start of the scale");
  private readonly most = this.end("scale-most", "End of the scale");
  private readonly hint = make("small", { id: "scale-hint", role: "status", class: "hint" });
  private readonly ends: HTMLElement;

  constructor(
    private readonly stage: Stage,
    private readonly bodies: BodySet,
    private readonly changed: () => void,
  ) {
    const reset = make("button", { id: "scale-reset", title: "Fit the scale to what is shown now", onclick: () => this.reset() }, "Reset");
    this.ends = row("From, to", make("span", { class: "ends" }, this.least, this.most));
    this.element.append(row("Scale", make("span", { class: "ends" }, this.kind, reset)), this.ends, this.hint);
    this.show();
  }

  private end(id: string, label: string): HTMLInputElement {
    return make("input", { type: "number", step: "any", id, "aria-label": label, "aria-describedby": "scale-hint", onchange: () => this.setEnds() });
  }

  /** Shows the current scale. */
  show(): void {
    const { scale, colouring } = this.bodies;
    this.element.hidden = colouring === "body";
    this.kind.value = scale.automatic ? "automatic" : "fixed";
    this.ends.hidden = scale.automatic;
    this.refuse("");
    if (this.element.hidden) return;
    const { factor } = shownAmount(this.stage, this.bodies).unit;
    this.least.value = String(Number((factor * scale.least).toPrecision(6)));
    this.most.value = String(Number((factor * scale.most).toPrecision(6)));
  }

  private setKind(automatic: boolean): void {
    const { least, most } = this.bodies.scale;
    this.bodies.setScale(automatic ? undefined : { least, most });
    this.show();
    if (!automatic && !(least < most)) this.refuse("All is 0 so far: set the end of the scale.");
    this.changed();
  }

  /** The numbers are in the unit of the legend. Those that make no scale stay where they were typed, and the scale stays. */
  private setEnds(): void {
    const { factor } = shownAmount(this.stage, this.bodies).unit;
    const least = this.least.valueAsNumber / factor;
    const most = this.most.valueAsNumber / factor;
    if (!(least < most)) return this.refuse("Not taken: the first number has to be less than the second.");
    this.bodies.setScale({ least, most });
    this.show();
    this.changed();
  }

  private refuse(why: string): void {
    this.hint.textContent = why;
    for (const input of [this.least, this.most]) input.setAttribute("aria-invalid", String(why !== ""));
  }

  private reset(): void {
    this.bodies.setScale();
    this.show();
    this.changed();
  }
}
