// Derived units for display: N, Pa and N m with a suitable prefix, from the units of the scene.
import { short } from "./colours";

export interface Units {
  length: string;
  mass: string;
  time: string;
}
/** Powers of mass, length and time. */
export type Dimension = readonly [number, number, number];
export const force: Dimension = [1, 1, -2];
export const length: Dimension = [0, 1, 0];
export const torque: Dimension = [1, 2, -2];

const exponents: Record<string, number> = {
  m: 0, cm: -2, mm: -3, um: -6, km: 3, kg: 0, g: -3, mg: -6, ug: -9, t: 3, s: 0, ms: -3, us: -6,
};
const prefixes = ["p", "n", "µ", "m", "", "k", "M", "G"];
const names: [Dimension, string][] = [[force, "N"], [torque, "N m"], [[1, -1, -2], "Pa"]];

/** A unit, and the factor from a number of the scene to it. */
export interface UnitForPeople {
  factor: number;
  name: string;
}

/** The unit of display for amounts of about this size. Units without a name of their own stay those of the scene. */
export function unitForPeople(size: number, units: Units, dimension: Dimension): UnitForPeople {
  const [mass, length, time] = dimension;
  if (mass === 0 && length === 0 && time === 0) return { factor: 1, name: "" };
  if (mass === 0 && length === 1 && time === 0) return unitOfLength(size, units.length);
  const exponent = mass * exponents[units.mass]! + length * exponents[units.length]! + time * exponents[units.time]!;
  const name = names.find(([d]) => d.every((power, i) => power === dimension[i]))?.[1];
  if (name === undefined) return { factor: 1, name: `${units.mass}^${mass} ${units.length}^${length} ${units.time}^${time}` };
  const si = Math.abs(size) * 10 ** exponent;
  const place = si > 0 && Number.isFinite(si) ? Math.floor(Math.log10(si * 1.00005) / 3) : 0;
  const step = Math.min(Math.max(place, -4), 3);
  return { factor: 10 ** (exponent - 3 * step), name: prefixes[step + 4]! + name };
}

/** Lengths below a tenth of a metre are shown in millimetres, unless the unit of the scene is smaller. */
function unitOfLength(size: number, name: string): UnitForPeople {
  const exponent = exponents[name]!;
  const metres = Math.abs(size) * 10 ** exponent;
  return metres > 0 && metres < 0.1 && exponent > -3 ? { factor: 10 ** (exponent + 3), name: "mm" } : { factor: 1, name };
}

export function inWords(value: number, units: Units, dimension: Dimension): string {
  const unit = unitForPeople(value, units, dimension);
  return `${short(unit.factor * value)} ${unit.name}`.trimEnd();
}

export function forceText(vector: readonly number[], units: Units): string {
  return inWords(Math.hypot(...vector), units, force);
}
