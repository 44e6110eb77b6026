// Makes the pictures of the docs with the page itself, in a headless browser.
//   node viewer/pictures.mjs build/release/apps/palpate/palpate docs/viewer [animation|eye|skull|stacking|ct|stored ...]
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

/** Single steps until a simulated time, so that the picture does not depend on how fast this machine is. */
async function stepTo(page, end) {
  while ((await time(page)) < end - 1e-9) {
    const before = await page.textContent("#clock");
    await page.keyboard.press("n");
    await waitFor(page, async () => (await page.textContent("#clock")) !== before);
  }
}

/** Draws the mouse's arrow where it is: pictures leave it out. */
async function showMouse(page) {
  await page.evaluate(() => {
    const arrow = document.createElementNS("http://www.w3.org/2000/svg", "svg");
    arrow.setAttribute("viewBox", "0 0 16 24");
    arrow.style.cssText = "position: fixed; width: 20px; height: 30px; pointer-events: none; z-index: 9; left: -99px";
    arrow.innerHTML = '<path d="M1 1v18l4.5-4 3 7 3-1.3-3-6.7H15z" fill="#fff" stroke="#000" stroke-width="1.4"/>';
    document.body.append(arrow);
    addEventListener("pointermove", (event) => { arrow.style.left = `${event.clientX}px`; arrow.style.top = `${event.clientY}px`; }, { capture: true });
  });
}

/** Moves the mouse to the point that a hand at a place takes hold of: the force is shown beside it. */
async function nearestPoint(page, at, x, y) {
  await at(x, y);
  await page.mouse.down();
  await waitFor(page, async () => (await page.locator(".tag").count()) > 0);
  const place = await page.evaluate(() => new DOMMatrix(getComputedStyle(document.querySelector(".tag")).transform));
  await page.mouse.up();
  const beside = [place.e - 14, place.f + 30];  // as showTag() puts it
  await at(...beside);
  return beside;
}

/** The orbit, cut open: a plate lifts the bulb; a hand pulls the lateral rectus down from it, and lets go. */
async function animation() {
  const { child, address } = await serve("scenes/eye.json", "--paused", "--speed", "max");
  const page = await open(address, { width: 1200, height: 800 });
  await page.selectOption("#scene-view", "tissues");
  // A weak spring: its line is long enough to be seen, and a hand can tell 5 mN from 15.
  await page.locator("#strength").fill("0");
  await page.click("#panel-toggle");
  await page.click("#fit");
  await showMouse(page);
  const place = mkdtempSync(join(tmpdir(), "palpate-pictures-"));
  const files = [];
  const box = await page.locator("#canvas").boundingBox();
  const at = (x, y) => page.mouse.move(box.x + x, box.y + y);
  let [x, y] = [0.56 * box.width, 0.64 * box.height];
  const force = async () => {
    const [, amount, unit] = /([\d.]+) (m?)N/.exec((await page.locator(".tag").allTextContents()).join()) ?? [0, "0", "m"];
    return Number(amount) * (unit === "m" ? 1 : 1000);
  };
  let far = 0;
  for (let step = 0; step < 38; ++step) {
    // By single steps, so that each picture has all its pixels: while it runs, a slow machine draws fewer.
    await stepTo(page, 0.04 * step);
    if (step === 11) [x, y] = await nearestPoint(page, at, x, y);
    if (step === 12) await page.mouse.down();
    // Further until the hand feels 15 mN, which the tissue can bear.
    if (step > 12 && step < 32 && (await force()) < 15) far += 8;
    if (step > 12 && step < 32) await at(x + 0.25 * far, y + 0.97 * far);
    if (step === 32) await page.mouse.up();
    await page.waitForTimeout(700);
    const file = join(place, `${String(files.length).padStart(3, "0")}.png`);
    await page.locator("#view").screenshot({ path: file });
    files.push(file);
  }
  // Each picture for itself: what is taken from the one before leaves blocks.
  const made = spawnSync("img2webp", ["-loop", "0", "-lossy", "-q", "90", "-kmin", "0", "-kmax", "1", "-m", "6", "-d", "100", ...files.slice(0, -1), "-d", "1000", files.at(-1), "-o", join(folder, "../gallery/viewer.webp")]);
  if (made.status !== 0) console.error(`no animation: ${made.error ?? made.stderr}`);
  if (process.env.KEEP) spawnSync("cp", [...files, process.env.KEEP]);
  rmSync(place, { recursive: true });
  await page.close();
  child.kill();
}

/** Stored results of a scene, in a folder that is gone at the end. */
function store(scene, steps) {
  const place = mkdtempSync(join(tmpdir(), "palpate-pictures-"));
  process.on("exit", () => rmSync(place, { recursive: true }));
  const made = spawnSync(command, ["run", scene, "--steps", String(steps), "--out", join(place, "results"), "--no-picture", "--quiet"]);
  if (made.status !== 0) throw new Error(String(made.stderr));
  return join(place, "results");
}

const asItIs = async () => {};

/** Name of the pictures; what is shown; until when it runs; what is done then. */
const shown = {
  eye: [() => "scenes/eye.json", 0.6, asItIs],
  skull: [() => "scenes/skull.json", 0.8, asItIs],
  stacking: [() => "scenes/stacking.json", 0.3, async (page) => {
    await page.selectOption("#colouring", "depth");
    await page.check("#cut");
  }],
  // './dev run scenes/skull-ct.json' makes its meshes.
  ct: [() => "scenes/skull-ct.json", 0.8, async (page) => { await page.selectOption("#scene-view", "tissues"); }],
  stored: [() => store("scenes/eye.json", 130), 1.3, async (page) => { await page.selectOption("#colouring", "displacement"); }],
};

/** Goes to a time; in stored results the slider goes to their end. */
async function showEnd(page, end) {
  if (await page.isVisible("#seek")) {
    await page.focus("#seek");
    await page.keyboard.press("End");
    await waitFor(page, async () => (await time(page)) >= end - 1e-9);
  } else {
    await stepTo(page, end);
  }
}

/** The page at the size of a desk and of a phone, in both themes, with the panel where there is room. */
async function look(what) {
  const [scene, end, prepare] = shown[what];
  const { child, address } = await serve(scene(), "--paused", "--speed", "max");
  for (const [name, size] of [["desk", { width: 1440, height: 900 }], ["phone", { width: 390, height: 844 }]]) {
    const page = await open(address, size);
    await showEnd(page, end);
    if (name === "phone") await page.click("#panel-toggle");
    await prepare(page);
    if (name === "phone") await page.click("#panel-toggle");
    await page.click("#fit");
    for (const theme of ["light", "dark"]) {
      await page.evaluate(() => document.activeElement.blur());
      await page.mouse.move(size.width / 2, 0);
      await page.waitForTimeout(1500);
      await page.screenshot({ path: join(folder, `viewer-${what}-${name}-${theme}.png`) });
      await page.click("#theme");
    }
    await page.close();
  }
  child.kill();
}

const wanted = process.argv.slice(4);
for (const name of ["animation", ...Object.keys(shown)]) {
  if (wanted.length > 0 && !wanted.includes(name)) continue;
  await (name === "animation" ? animation() : look(name));
}
await browser.close();
