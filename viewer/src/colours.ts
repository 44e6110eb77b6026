// Colours that can be distinguished with any colour vision.

export type Colour = [number, number, number];

function parse(hex: string): Colour {
  const value = parseInt(hex.slice(1), 16);
  return [(value >> 16) / 255, ((value >> 8) & 255) / 255, (value & 255) / 255];
}

/** The colour of bodies that amounts do not colour, and of places without a value, as in pictures. */
export const neutral: Colour = [0.72, 0.72, 0.74];
export const noValue: Colour = [0.92, 0.92, 0.93];

/** The colours for amounts: viridis (van der Walt & Smith 2015), dark to light, as in the pictures of `palpate run`. */
const amounts = [
  "#440154", "#482475", "#414487", "#355f8d", "#2a788e", "#21908d", "#22a884", "#42be71", "#7ad151", "#bddf26", "#fde725",
].map(parse);

/** Writes the colour of a fraction in [0, 1] at `place` of `colours`. */
export function amountColour(fraction: number, colours: Float32Array, place: number): void {
  const x = Math.min(Math.max(fraction, 0), 1) * (amounts.length - 1);
  const i = Math.min(Math.floor(x), amounts.length - 2);
  const low = amounts[i]!;
  const high = amounts[i + 1]!;
  for (let c = 0; c < 3; ++c) colours[place + c] = low[c]! + (x - i) * (high[c]! - low[c]!);
}

export function amountGradient(context: CanvasRenderingContext2D, width: number): CanvasGradient {
  const gradient = context.createLinearGradient(0, 0, width, 0);
  amounts.forEach((c, i) => gradient.addColorStop(i / (amounts.length - 1), css(c)));
  return gradient;
}

export function css(colour: Colour): string {
  return `rgb(${colour.map((c) => Math.round(255 * c)).join(" ")})`;
}

/** Colours of the phases of a step, in their order. */
export const phaseColours = ["#56b4e9", "#0072b2", "#009e73", "#f0e442", "#e69f00", "#cc79a7", "#d55e00"];

/** The smallest of some round numbers that is not below x, for ends of scales; like nice_above() in src/io. */
export function niceAbove(x: number): number {
  if (!(x > 0)) return 0;
  const power = 10 ** Math.floor(Math.log10(x));
  for (const factor of [1, 1.5, 2, 2.5, 3, 4, 5, 6, 8]) {
    if (factor * power >= x * (1 - 1e-9)) return factor * power;
  }
  return 10 * power;
}

/** The largest of 1, 2, 5 times a power of ten that is not above x > 0: for the length of a bar. */
export function niceBelow(x: number): number {
  const power = 10 ** Math.floor(Math.log10(x));
  const factor = [5, 2, 1].find((f) => f * power <= x * (1 + 1e-9)) ?? 1;
  return factor * power;
}

/** A number with three or four digits, for people. */
export function short(x: number): string {
  if (x === 0) return "0";
  const size = Math.abs(x);
  if (size >= 1e5 || size < 1e-3) return x.toExponential(2).replace(/\.?0+e/, "e").replace("e+", "e");
  return String(Number(x.toPrecision(size >= 1000 ? 4 : 3)));
}
