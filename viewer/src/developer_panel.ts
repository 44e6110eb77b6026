// The panel for developers of the contact query: counts, the time of each phase, layers of the grid.
import { Chart } from "./chart";
import { phaseColours } from "./colours";
import { make, row, section } from "./parts";
import type { Frame, Stage } from "./protocol";
import { inWords, length } from "./units";

export class DeveloperPanel {
  readonly element: HTMLDetailsElement;
  private readonly chart: Chart;
  private readonly table = make("table", { id: "times" });
  private readonly counts = make("table", { id: "counts" });
  private lastTable = 0;

  /** @param controls  settings and layers that belong here */
  constructor(
    private readonly stage: Stage,
    controls: readonly Node[],
  ) {
    const canvas = make("canvas", { class: "chart", "aria-label": "Milliseconds of each phase, contacts and movers over the last frames", role: "img" });
    this.chart = new Chart(canvas);
    this.chart.budget = 1e3 * stage.time_step * (stage.units.time === "ms" ? 1e-3 : 1);
    const budget = make("input", { type: "number", min: 0, step: "any", id: "budget-line", "aria-label": "Budget of a step in ms", oninput: () => {
      this.chart.budget = Math.max(0, budget.valueAsNumber || 0);
    } });
    budget.value = String(Number(this.chart.budget.toPrecision(4)));
    this.element = section("Developer", false, ...controls, this.counts, canvas, row("Budget line (ms)", budget), this.table, make("output", { id: "rate", class: "faint" }));
    this.element.id = "developer";
  }

  update(frame: Frame): void {
    this.chart.add(frame);
    const now = performance.now();
    if (now - this.lastTable < 200) return;  // faster changes cannot be read, and cost frames
    this.lastTable = now;
    this.showTimes(frame);
    this.showCounts(frame);
  }

  clear(): void {
    this.chart.clear();
  }

  private showTimes(frame: Frame): void {
    const ms = (x: number | undefined) => (x ?? 0).toFixed(x && x >= 100 ? 0 : 3);
    const rows = Object.keys(frame.ms).map((name, i) => {
      const swatch = make("span", { class: "swatch" });
      swatch.style.background = phaseColours[i] ?? "transparent";
      return make("tr", {}, make("td", {}, swatch, name), make("td", {}, ms(frame.ms[name])), make("td", {}, ms(frame.totals.ms[name])));
    });
    this.table.replaceChildren(
      make("tr", {}, make("th", {}, "ms"), make("th", {}, "now"), make("th", {}, `mean of ${frame.totals.steps}`)), ...rows,
      make("tr", {}, make("td", {}, "longest step"), make("td", {}, ms(frame.longest)), make("td", {}, ms(frame.totals.longest))));
  }

  private showCounts(frame: Frame): void {
    const counts = frame.counts;
    const lengthText = (value: number) => inWords(value, this.stage.units, length);
    const lines: [string, string | number | undefined][] = [
      ["contacts", counts.contacts], ["border edges", counts.border_edges], ["crossings", counts.crossings], ["edge contacts", counts.edge_contacts],
      ["movers", counts.movers], ["candidates", counts.candidates],
      ["deepest", counts.deepest === undefined ? undefined : lengthText(counts.deepest)],
      ["cell size", lengthText(counts.cell_size)],
      ["cells in use", frame.occupied_cells],
      ["cells dropped", counts.dropped_cells > 0 ? counts.dropped_cells : undefined],
    ];
    this.counts.replaceChildren(...lines.filter(([, v]) => v !== undefined).map(([name, value]) => make("tr", {}, make("td", {}, name), make("td", {}, String(value)))));
  }
}
