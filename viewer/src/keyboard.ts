// The keys: their actions, and the list that '?' shows.
import { byId, make } from "./parts";

export interface Key {
  key: string;
  name?: string;
  does: string;
  act: () => void;
}

export function bindKeys(keys: Key[]): void {
  document.addEventListener("keydown", (event) => {
    const target = event.target as HTMLElement;
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    // A focused control keeps its own keys.
    if (target.matches("select, input[type=number]")) return;
    if (target.matches("button, summary, input") && /^( |Enter|Arrow.*|Home|End)$/.test(event.key)) return;
    const bound = keys.find((k) => k.key === event.key || k.key === event.key.toLowerCase());
    if (!bound) return;
    event.preventDefault();
    bound.act();
  });
  const rows = keys.map((k) => make("tr", {}, make("td", {}, make("kbd", {}, k.name ?? k.key.toUpperCase())), make("td", {}, k.does)));
  const dialog = byId<HTMLDialogElement>("keys");
  dialog.append(make("h2", {}, "Keys"), make("table", {}, ...rows), make("button", { onclick: () => dialog.close() }, "Close"));
}

export function showKeys(): void {
  const dialog = byId<HTMLDialogElement>("keys");
  if (dialog.open) dialog.close();
  else dialog.showModal();
}
