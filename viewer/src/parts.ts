// Small pieces of the panel.

type Child = Node | string;

/** An element with attributes, listeners ("onclick") and children. */
export function make<K extends keyof HTMLElementTagNameMap>(
  tag: K,
  attributes: Record<string, unknown> = {},
  ...children: Child[]
): HTMLElementTagNameMap[K] {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value as EventListener);
    else if (value === true) element.setAttribute(name, "");
    else if (value !== false && value !== undefined) element.setAttribute(name, String(value));
  }
  element.append(...children);
  return element;
}

export function byId<T extends HTMLElement>(id: string): T {
  const element = document.getElementById(id);
  if (!element) throw new Error(`no element ${id}`);
  return element as T;
}

export function section(title: string, open: boolean, ...children: Child[]): HTMLDetailsElement {
  return make("details", { open }, make("summary", {}, title), ...children);
}

export function row(label: string, ...children: Child[]): HTMLLabelElement {
  return make("label", { class: "row" }, make("span", {}, label), ...children);
}

export function check(label: string, on: boolean, change: (on: boolean) => void, id?: string): HTMLLabelElement {
  const box = make("input", { type: "checkbox", id, onchange: () => change(box.checked) });
  box.checked = on;
  return make("label", { class: "check" }, box, label);
}

/** A value of a choice; `label` says how it reads, where not as itself. Neighbours of one `group` stand under its name. */
export interface Choice {
  value: string;
  label?: string;
  group?: string;
}

/** A choice among values. */
export function choose(choices: readonly (string | Choice)[], value: string, change: (value: string) => void, id?: string): HTMLSelectElement {
  const select = make("select", { id, onchange: () => change(select.value) });
  let place: HTMLElement = select;
  let last: string | undefined;
  for (const one of choices) {
    const { value, label, group }: Choice = typeof one === "string" ? { value: one } : one;
    if (group !== last) {
      place = group === undefined ? select : make("optgroup", { label: group });
      if (place !== select) select.append(place);
    }
    last = group;
    place.append(make("option", { value }, label ?? value));
  }
  select.value = value;
  return select;
}

export interface Slider {
  element: HTMLElement;
  /** `text` says what is read instead of the value. */
  set(value: number, text?: string): void;
  range(low: number, high: number): void;
}

/** A slider with its value; `show` formats the value, `logarithmic` sets its scale. */
export function slider(options: {
  id?: string;
  low: number;
  high: number;
  value: number;
  logarithmic?: boolean;
  show: (value: number) => string;
  /** The value that is taken for one of the slider; without it, that one. */
  snap?: (value: number) => number;
  change: (value: number) => void;
  label: string;
}): Slider {
  const parts = 200;
  const { logarithmic } = options;
  let { low, high } = options;
  const toValue = (t: number) => (logarithmic ? low * (high / low) ** t : low + t * (high - low));
  const toFraction = (v: number) => (logarithmic ? Math.log(v / low) / Math.log(high / low) : (v - low) / (high - low));
  const output = make("output");
  const input = make("input", {
    type: "range",
    id: options.id,
    min: 0,
    max: parts,
    "aria-label": options.label,
    oninput: () => {
      const wanted = toValue(input.valueAsNumber / parts);
      const value = options.snap?.(wanted) ?? wanted;
      show(value);
      options.change(value);
    },
  });
  const show = (value: number, text = options.show(value)) => {
    output.textContent = text;
    input.setAttribute("aria-valuetext", text);
  };
  const set = (value: number, text?: string) => {
    if (document.activeElement !== input) input.value = String(Math.round(parts * toFraction(value)));
    show(value, text);
  };
  set(options.value);
  const range = (least: number, most: number) => {
    low = least;
    high = most;
  };
  return { element: make("span", { class: "slider" }, input, output), set, range };
}
