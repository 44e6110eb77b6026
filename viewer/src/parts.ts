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

/** A choice among values; `labels` are texts for those that are not shown as they are. */
export function choose(values: readonly string[], value: string, change: (value: string) => void, id?: string, labels: readonly string[] = values): HTMLSelectElement {
  const select = make("select", { id, onchange: () => change(select.value) }, ...values.map((v, i) => make("option", { value: v }, labels[i]!)));
  select.value = value;
  return select;
}

export interface Slider {
  element: HTMLElement;
  set(value: number): void;
}

/** A slider with its value; `show` formats the value, `logarithmic` sets its scale. */
export function slider(options: {
  id?: string;
  low: number;
  high: number;
  value: number;
  logarithmic?: boolean;
  show: (value: number) => string;
  change: (value: number) => void;
  label: string;
}): Slider {
  const parts = 200;
  const { low, high, logarithmic } = options;
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
      const value = toValue(input.valueAsNumber / parts);
      show(value);
      options.change(value);
    },
  });
  const show = (value: number) => {
    output.textContent = options.show(value);
    input.setAttribute("aria-valuetext", options.show(value));
  };
  const set = (value: number) => {
    if (document.activeElement !== input) input.value = String(Math.round(parts * toFraction(value)));
    show(value);
  };
  set(options.value);
  return { element: make("span", { class: "slider" }, input, output), set };
}
