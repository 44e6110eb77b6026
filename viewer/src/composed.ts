// The view as one picture: the bodies with all that lies over them and belongs to them, such as legend, scale bar and axes.
import { byId } from "./parts";

/** What belongs to a picture; not the mouse's label, messages or controls. */
const overlays = ["tags", "triad", "scale-bar", "legend"];

const sides = ["Top", "Right", "Bottom", "Left"] as const;

export class Composed {
  readonly canvas = document.createElement("canvas");
  private readonly context = this.canvas.getContext("2d", { alpha: false })!;

  constructor(private readonly view: HTMLCanvasElement) {}

  /** Sets the size to that of the view. */
  fit(): void {
    const ratio = Math.min(devicePixelRatio, 2);
    this.canvas.width = Math.round(this.view.clientWidth * ratio);
    this.canvas.height = Math.round(this.view.clientHeight * ratio);
  }

  /** Draws the view, which must have been drawn in this turn of the event loop. */
  draw(): void {
    const { context, canvas, view } = this;
    const box = view.getBoundingClientRect();
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.drawImage(view, 0, 0, canvas.width, canvas.height);
    context.setTransform(canvas.width / box.width, 0, 0, canvas.height / box.height, 0, 0);
    context.translate(-box.left, -box.top);
    for (const id of overlays) this.add(byId(id));
  }

  /** Draws an element of the page and all in it: box, canvas, lines of text. */
  private add(element: HTMLElement): void {
    if (element.hidden) return;
    const style = getComputedStyle(element);
    const box = element.getBoundingClientRect();
    if (box.width > 0 && box.height > 0) this.addBox(style, box);
    if (element instanceof HTMLCanvasElement) this.context.drawImage(element, box.left, this.onPixel(box.top), box.width, box.height);
    for (const child of element.childNodes) {
      if (child instanceof HTMLElement) this.add(child);
      else if (child instanceof Text) this.addText(child, style);
    }
  }

  /** The nearest height of the page that is one of a pixel: where browsers put text and pictures. */
  private onPixel(y: number): number {
    const { d, f } = this.context.getTransform();
    return (Math.round(d * y + f) - f) / d;
  }

  private addBox(style: CSSStyleDeclaration, { left, top, width, height }: DOMRect): void {
    const { context } = this;
    context.beginPath();
    context.roundRect(left, top, width, height, parseFloat(style.borderTopLeftRadius) || 0);
    context.fillStyle = style.backgroundColor;
    context.fill();
    const wide = sides.map((side) => (style[`border${side}Style`] === "none" ? 0 : parseFloat(style[`border${side}Width`])));
    if (wide.every((w) => w > 0)) {
      context.lineWidth = wide[0]!;
      context.strokeStyle = style.borderTopColor;
      context.stroke();
      return;
    }
    const [up, right, down, side] = wide as [number, number, number, number];
    const bars: [number, number, number, number][] = [
      [left, top, width, up], [left + width - right, top, right, height], [left, top + height - down, width, down], [left, top, side, height],
    ];
    bars.forEach((bar, i) => {
      context.fillStyle = style[`border${sides[i]!}Color`];
      context.fillRect(...bar);
    });
  }

  private addText(text: Text, style: CSSStyleDeclaration): void {
    const words = text.data.trim();
    if (words === "") return;
    const range = document.createRange();
    range.selectNodeContents(text);
    const { left, top, height } = range.getBoundingClientRect();
    this.context.font = `${style.fontWeight} ${style.fontSize} ${style.fontFamily}`;
    const { fontBoundingBoxAscent: above, fontBoundingBoxDescent: below } = this.context.measureText(words);
    this.context.fillStyle = style.color;
    this.context.fillText(words, left, this.onPixel(top + (height - above - below) / 2 + above));
  }
}
