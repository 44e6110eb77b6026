// Common parts of the page's tests: scenes, servers, pages of a headless browser, and pixels.
//   PALPATE_COMMAND   the command
//   PALPATE_PICTURES  where screenshots go
import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { mkdirSync, mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before } from "node:test";
import { launch, root, webgl } from "../browser.mjs";

export const { PNG } = createRequire(join(root, "viewer/package.json"))("pngjs");

export const { PALPATE_COMMAND: command, PALPATE_PICTURES: pictures } = process.env;
export const folder = mkdtempSync(join(tmpdir(), "palpate-page-"));
mkdirSync(pictures, { recursive: true });
/** Writes a scene into the folder that servers run in. */
export const write = (name, scene) => writeFileSync(join(folder, name), JSON.stringify(scene));

export const material = { young_modulus: 20000, mass_damping: 2, stiffness_damping: 0.002 };
export const scene = {
  name: "two boxes", time_step: 0.01, duration: 0.4,
  contact: { friction: 0.3 }, output: { every: 2 },
  bodies: [
    { name: "plate", box: { cells: [2, 2, 1], size: [0.3, 0.3, 0.02] }, translate: [0, 0, -0.01], obstacle: true },
    { name: "lower", box: { cells: [4, 4, 3], size: [0.12, 0.12, 0.08] }, translate: [0, 0, 0.0405], material },
    { name: "upper", box: { cells: [3, 3, 3], size: [0.08, 0.08, 0.06] }, translate: [0.01, 0.01, 0.112], material },
    { name: "press", box: { cells: [1, 1, 1], size: [0.03, 0.03, 0.03] }, translate: [0.13, 0, 0.1],
      motion: { keyframes: [{ time: 0 }, { time: 1, translate: [0, 0, -0.05] }] } },
  ],
};
export const glued = {
  name: "glued box", time_step: 0.01,
  bodies: [{ name: "box", box: { cells: [4, 4, 4], size: [0.1, 0.1, 0.1] }, material,
    fixed: [{ box: { lower: [-1, -1, -1], upper: [1, 1, -0.049] } }] }],
};
write("scene.json", scene);
write("glued.json", glued);
// A scene of a patient: axes named by sides, millimetres and grams, two named views.
export const patient = {
  ...scene, name: "patient", axes: "LPS", units: { length: "mm", mass: "g", time: "s" }, gravity: [0, 0, -9810],
  bodies: scene.bodies.map((body) => ({
    ...body,
    box: { ...body.box, size: body.box.size.map((x) => 1000 * x) },
    translate: body.translate.map((x) => 1000 * x),
    ...(body.material ? { material: { ...body.material, density: 0.001 } } : {}),
    ...(body.motion ? { motion: { keyframes: [{ time: 0 }, { time: 1, translate: [0, 0, -50] }] } } : {}),
  })),
  output: { views: [
    { name: "moved", displacement: { most: 4 } },
    { name: "lower-half", camera: { position: [300, -400, 200], target: [0, 0, 40] }, bodies: ["plate", "lower"], cut: { point: [0, 0, 0], normal: [0, -1, 0] } },
  ] },
};
write("patient.json", patient);
let browser;
const servers = new Set();

/** Starts the command; resolves with its address and a function that ends it. */
export async function serve(what, { environment = {}, flags = [] } = {}) {
  const child = spawn(command, ["view", what, "--json", "--no-browser", "--threads", "1", ...flags],
    { cwd: folder, env: { ...process.env, ...environment } });
  servers.add(child);
  let errors = "";
  child.stderr.on("data", (text) => (errors += text));
  const ended = new Promise((resolve) => child.on("exit", (code) => { servers.delete(child); resolve(code); }));
  const line = await new Promise((resolve, reject) => {
    child.stdout.once("data", (data) => resolve(String(data)));
    child.once("exit", () => reject(new Error(`the server ended: ${errors}`)));
  });
  const { address, port } = JSON.parse(line);
  return { address, port, end: () => { child.kill("SIGTERM"); return ended; } };
}

/** A page whose console and errors are watched; `first` runs in it before its own scripts. */
export async function open(address, options = {}, first = () => {}) {
  const page = await browser.newPage({ viewport: { width: 1000, height: 640 }, ...options });
  await page.addInitScript(first);
  page.complaints = [];
  page.on("console", (m) => ["error", "warning"].includes(m.type()) && page.complaints.push(m.text()));
  page.on("pageerror", (error) => page.complaints.push(String(error)));
  await page.goto(address);
  await until("the first frame is shown", async () => (await text(page, "clock")).startsWith("t = "));
  return page;
}

export const time = (page) => page.evaluate(() => Number(/t = ([\d.]+)/.exec(document.getElementById("clock").textContent)[1]));
export const text = (page, id) => page.textContent(`#${id}`);
/** The forces beside what is held. */
export const tag = async (page) => (await page.locator(".tag").allTextContents()).join("; ");
export const shot = (page, name) => page.screenshot({ path: join(pictures, `viewer-${name}.png`) });

/** Opens a closed section of the panel. */
export const openSection = (page, id) => page.click(`#${id} > summary`);

/** Lets SwiftShader's own remarks about speed pass; nothing else. */
export function noComplaints(page) {
  const own = page.complaints.filter((c) => !/GPU stall due to ReadPixels|software WebGL|GroupMarkerNotSet/.test(c));
  assert.deepEqual(own, []);
}

export async function until(what, check, seconds = 60) {
  const end = Date.now() + 1000 * seconds;
  while (!(await check())) {
    if (Date.now() > end) assert.fail(`not within ${seconds} s: ${what}`);
    await new Promise((resolve) => setTimeout(resolve, 50));
  }
}

before(async () => {
  browser = await launch(webgl);
});
after(async () => {
  await browser?.close();
  for (const child of servers) child.kill("SIGKILL");
  rmSync(folder, { recursive: true, force: true });
});

/** The middle of the view, where both scenes have tissue. */
export async function middle(page) {
  const box = await page.locator("#canvas").boundingBox();
  return { x: box.x + box.width / 2, y: box.y + box.height / 2 };
}

/** The pixels of a part of the page, by default the view: width, height, data (4 numbers a pixel). The page's
 * screenshot(), since a locator's waits for several frames first, which are slow without a GPU. */
export async function pixels(page, selector = "#canvas") {
  await page.waitForTimeout(500);
  return PNG.sync.read(await page.screenshot({ clip: await page.locator(selector).boundingBox() }));
}

/** Whether a pixel is nearly of a colour. */
export const near = ({ data }, pixel, rgb, slack = 12) => rgb.every((c, k) => Math.abs(data[4 * pixel + k] - c) < slack);

/** How many pixels of the view are nearly of a colour, or of colours that a function says, and the middle of them. */
export async function patch(page, colour, slack = 12) {
  const picture = await pixels(page);
  const wanted = typeof colour === "function"
    ? (i) => colour(...picture.data.subarray(4 * i, 4 * i + 3)) : (i) => near(picture, i, colour, slack);
  let [count, x, y] = [0, 0, 0];
  for (let i = 0; i < picture.width * picture.height; ++i) {
    if (!wanted(i)) continue;
    ++count;
    x += i % picture.width;
    y += Math.floor(i / picture.width);
  }
  return { count, x: x / count, y: y / count };
}

export const hasColour = async (page, rgb) => (await patch(page, rgb)).count > 0;

/** The colour of the face of a cut body: that of the body, times 0.72 in linear light, as sRGB. */
export function faceColour(rgb) {
  const srgb = (x) => Math.round(255 * (x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055));
  return rgb.map((c) => srgb(0.72 * ((c + 0.055) / 1.055) ** 2.4));
}
