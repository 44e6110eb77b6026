// The page of the report in a headless browser, from disk and without network: every chart is drawn, nothing is on the
// console, also at the width of a phone and in grey.
//   PALPATE_PICTURES  where screenshots go
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { existsSync, mkdirSync, mkdtempSync, readFileSync, readdirSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { pathToFileURL } from "node:url";
import { launch, root, skip } from "../browser.mjs";

const pictures = process.env.PALPATE_PICTURES;
const python = join(root, "build/report-python/bin/python");
if (!existsSync(python)) skip("there is no build/report-python (./dev test makes it)");

/** The newest report that is kept. */
const kept = readdirSync(join(root, "bench/results"))
  .filter((name) => name.endsWith(".json"))
  .map((name) => join(root, "bench/results", name))
  .map((file) => ({ file, report: JSON.parse(readFileSync(file, "utf8")) }))
  .filter(({ report }) => report.kind === "all")
  .sort((a, b) => (a.report.date < b.report.date ? 1 : -1))[0];
const charts = kept.report.sections.flatMap((section) => section.charts);
const folder = mkdtempSync(join(tmpdir(), "palpate-report-"));
mkdirSync(pictures, { recursive: true });
let browser;

before(async () => {
  const made = spawnSync(python, [join(root, "bench/report/report.py"), kept.file, folder], { encoding: "utf8" });
  assert.equal(made.status, 0, made.stderr);
  browser = await launch();
});
after(async () => {
  await browser?.close();
  rmSync(folder, { recursive: true, force: true });
});

/** The page, and what it complained of and asked for. */
async function open(width, style = "") {
  const context = await browser.newContext({ viewport: { width, height: 900 }, offline: true });
  const page = await context.newPage();
  page.complaints = [];
  page.asked = [];
  page.on("console", (message) => page.complaints.push(message.text()));
  page.on("pageerror", (error) => page.complaints.push(String(error)));
  page.on("request", (request) => page.asked.push(request.url()));
  await page.goto(pathToFileURL(join(folder, "report.html")).href);
  if (style) await page.addStyleTag({ content: style });
  return page;
}

/** For each figure: its chart that is visible, how many lines that has, its size, and the smallest letters on the screen. */
const drawn = (page) =>
  page.$$eval("figure", (figures) =>
    figures.map((figure) => {
      const svgs = [...figure.querySelectorAll("svg")].filter((svg) => svg.getBoundingClientRect().width > 0);
      const box = svgs[0]?.getBoundingClientRect();
      const scale = box ? box.width / svgs[0].viewBox.baseVal.width : 0;
      const lines = [...(svgs[0]?.querySelectorAll("g.mark-line path") ?? [])].map((path) => path.getBoundingClientRect());
      const letters = [...(svgs[0]?.querySelectorAll("text") ?? [])].map((text) => parseFloat(getComputedStyle(text).fontSize) * scale);
      return {
        title: figure.getAttribute("aria-label"), visible: svgs.length, width: box?.width ?? 0,
        lines: lines.filter((line) => line.width > 5).length, smallest: Math.min(...letters),
      };
    }));

for (const [name, width, style] of [["wide", 1100, ""], ["phone", 390, ""], ["grey", 1100, "html { filter: grayscale(1) }"]]) {
  test(`${name}: opens without network, draws every chart, says nothing on the console`, async () => {
    const page = await open(width, style);
    assert.deepEqual(page.complaints, []);
    assert.deepEqual(page.asked.filter((address) => !address.startsWith("file:") && !address.startsWith("data:")), []);
    const figures = await drawn(page);
    assert.deepEqual(figures.map((f) => f.title), charts.map((chart) => chart.title));
    figures.forEach((figure, i) => {
      assert.equal(figure.visible, 1, figure.title);
      const lines = charts[i].series.filter((series) => new Set(series.x).size > 1).length;
      assert.ok(figure.lines >= lines, `${figure.title}: ${figure.lines} of ${lines} lines`);
      assert.ok(figure.width > 0.7 * Math.min(width, 640), `${figure.title} is ${figure.width} wide`);
      assert.ok(figure.smallest >= 9, `${figure.title}: letters of ${figure.smallest} pixels`);
    });
    const overflow = await page.evaluate(() => document.scrollingElement.scrollWidth - innerWidth);
    assert.ok(overflow <= 0, `the page is ${overflow} pixels wider than the screen`);
    await page.screenshot({ path: join(pictures, `report-${name}.png`), fullPage: true });
    await page.context().close();
  });
}

test("every section is there, with its verdict", async () => {
  const page = await open(1100);
  const ids = await page.$$eval("section", (sections) => sections.map((section) => section.id));
  assert.deepEqual(ids, kept.report.sections.map((section) => section.id));
  for (const id of ["table-1", "figure-6", "figure-7", "table-2", "cache-misses", "peers-points", "peers-edges", "growth", "threads"])
    assert.ok(ids.includes(id), id);
  const verdicts = await page.$$eval("section .verdict", (all) => all.map((one) => one.textContent));
  assert.deepEqual(verdicts, kept.report.sections.filter((s) => s.paper).map((s) => s.verdict));
  await page.context().close();
});
