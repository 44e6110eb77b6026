// Makes the pictures of the docs with the page itself, in a headless browser.
//   node viewer/pictures.mjs build/release/apps/palpate/palpate docs/gallery
// Needs chromium, and img2webp (Debian: webp) for the animation.
import { spawn, spawnSync } from "node:child_process";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { launch, webgl } from "../tests/browser.mjs";

const [command, folder] = process.argv.slice(2);
const browser = await launch(webgl);

async function serve(what, ...flags) {
  const child = spawn(command, ["view", what, "--json", "--no-browser", ...flags], { stdio: ["ignore", "pipe", "inherit"] });
  const line = await new Promise((resolve) => child.stdout.once("data", (data) => resolve(String(data))));
  return { child, address: JSON.parse(line).address };
}

async function open(address, size) {
  const page = await browser.newPage({ viewport: size });
  await page.goto(address);
  await waitFor(page, async () => (await page.textContent("#clock")).startsWith("t = "));
  return page;
}

async function waitFor(page, check) {
  while (!(await check())) await page.waitForTimeout(50);
}

const time = async (page) => Number(/t = ([\d.]+)/.exec(await page.textContent("#clock"))[1]);

/** Steps until a simulated time, so that the picture does not depend on how fast this machine is. */
async function playTo(page, end) {
  await page.click("#play");
  await waitFor(page, async () => (await time(page)) >= end);
  await page.click("#play");
}

/** The orbit, cut open: a plate is pushed up along its floor and lifts the bulb. */
async function animation() {
  const { child, address } = await serve("scenes/eye.json", "--paused", "--speed", "max");
  const page = await open(address, { width: 760, height: 500 });
  await page.selectOption("#scene-view", "tissues");
  await page.click("#panel-toggle");
  await page.focus("#canvas");
  for (let i = 0; i < 5; ++i) await page.keyboard.press("+");
  const place = mkdtempSync(join(tmpdir(), "palpate-pictures-"));
  const files = [];
  await page.click("#play");
  for (let t = 0; t <= 1.5; t += 0.05) {
    await waitFor(page, async () => (await time(page)) >= t - 1e-9);
    const file = join(place, `${String(files.length).padStart(3, "0")}.png`);
    await page.locator("#view").screenshot({ path: file });
    files.push(file);
  }
  const made = spawnSync("img2webp", ["-loop", "0", "-lossy", "-q", "75", "-m", "6", "-d", "100", ...files.slice(0, -1), "-d", "1200", files.at(-1), "-o", join(folder, "viewer.webp")]);
  if (made.status !== 0) console.error(`no animation: ${made.error ?? made.stderr}`);
  rmSync(place, { recursive: true });
  await page.close();
  child.kill();
}

/** One picture of the whole page. */
async function picture(name, scene, prepare, size = { width: 1200, height: 720 }, end = 0.3) {
  const { child, address } = await serve(scene, "--paused", "--speed", "max");
  const page = await open(address, size);
  if (end > 0) await playTo(page, end);
  await prepare(page);
  await page.waitForTimeout(800);
  await page.screenshot({ path: join(folder, `viewer-${name}.png`) });
  await page.close();
  child.kill();
}

const wanted = process.argv.slice(4);
const pictures = {
  animation,
  stacking: () => picture("stacking", "scenes/stacking.json", async (page) => {
    await page.selectOption("#colouring", "depth");
    await page.check("#cut");
  }),
  eye: () => picture("eye", "scenes/eye.json", (page) => page.selectOption("#scene-view", "organs"), undefined, 1),
  skull: () => picture("skull", "scenes/skull.json", (page) => page.selectOption("#scene-view", "displacement"), undefined, 1),
  contacts: () => picture("contacts", "examples/scenes/press.json", async (page) => {
    for (const id of ["show-arrows", "show-borders"]) await page.check(`#${id}`);
    await page.selectOption("#colouring", "displacement");
    await page.click("#theme");
  }, undefined, 0.6),
};
for (const [name, make] of Object.entries(pictures)) if (wanted.length === 0 || wanted.includes(name)) await make();
await browser.close();
