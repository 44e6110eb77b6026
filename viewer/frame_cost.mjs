// Cost of drawing a frame of a scene on the page, with the renderer of this machine (headless Chromium: in software).
//   node viewer/frame_cost.mjs build/release/apps/palpate/palpate scenes/eye.json [WIDTH HEIGHT]
// Prints CPU milliseconds per frame of the page (scripts, layout) and of rasterisation, so other load does not count: for an
// empty canvas of that size (the browser alone), while the view rotates, and while the simulation runs in real time.
import { spawn } from "node:child_process";
import { readdirSync, readFileSync } from "node:fs";
import { launch, webgl } from "../tests/browser.mjs";

/** Seconds of the processor that the page and what rasterises for it have used. */
function seconds() {
  const ticks = { renderer: 0, "gpu-process": 0 };
  for (const id of readdirSync("/proc").filter((name) => /^\d+$/.test(name))) {
    try {
      const type = /--type=(gpu-process|renderer)/.exec(readFileSync(`/proc/${id}/cmdline`, "latin1"))?.[1];
      if (!type || !descends(id)) continue;
      const fields = readFileSync(`/proc/${id}/stat`, "latin1").split(") ")[1].split(" ");
      ticks[type] += Number(fields[11]) + Number(fields[12]);
    } catch {
      // has ended meanwhile
    }
  }
  return { page: ticks.renderer / 100, raster: ticks["gpu-process"] / 100 };
}

/** Whether a process is one of ours: others may have browsers too. */
function descends(id) {
  for (let up = Number(id); up > 1; ) {
    if (up === process.pid) return true;
    up = Number(readFileSync(`/proc/${up}/stat`, "latin1").split(") ")[1].split(" ")[1]);
  }
  return false;
}

const [command, scene, width = "1440", height = "900"] = process.argv.slice(2);
const viewport = { width: Number(width), height: Number(height) };
const browser = await launch(webgl);

/** Counts pictures that are drawn with WebGL, and waits until each is there. */
function count() {
  const real = window.requestAnimationFrame.bind(window);
  window.frames_drawn = 0;
  let drawn = false;
  for (const name of ["clear", "drawElements"]) {
    const own = WebGL2RenderingContext.prototype[name];
    WebGL2RenderingContext.prototype[name] = function (...values) { drawn = this; return own.apply(this, values); };
  }
  window.requestAnimationFrame = (draw) => real((now) => {
    draw(now);
    if (!drawn) return;
    drawn.readPixels(0, 0, 1, 1, drawn.RGBA, drawn.UNSIGNED_BYTE, new Uint8Array(4));
    drawn = false;
    ++window.frames_drawn;
  });
}

/** Tells what a frame takes while something is done. */
async function measure(page, what, act) {
  await page.waitForTimeout(1000);
  const drawn = () => page.evaluate(() => window.frames_drawn);
  const [before, first] = [seconds(), await drawn()];
  await act();
  const [after, last] = [seconds(), await drawn()];
  const each = (part) => ((1000 * (after[part] - before[part])) / (last - first)).toFixed(1);
  console.log(`${what}: ${last - first} frames; a frame: page ${each("page")} ms, rasterising ${each("raster")} ms`);
}

const empty = await browser.newPage({ viewport });
await empty.addInitScript(count);
await empty.goto("about:blank");
await empty.setContent(`<style>body { margin: 0 }</style><canvas width="${width}" height="${height}"></canvas>`);
await measure(empty, `an empty canvas of ${width} x ${height}`, () => empty.evaluate(() => new Promise((resolve) => {
  const gl = document.querySelector("canvas").getContext("webgl2", { antialias: true, stencil: true });
  let left = 60;
  const draw = () => {
    gl.clearColor(left / 60, 0.5, 0.5, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    if (--left > 0) requestAnimationFrame(draw);
    else resolve();
  };
  requestAnimationFrame(draw);
})));
await empty.close();

const child = spawn(command, ["view", scene, "--json", "--no-browser", "--paused", "--threads", "1"], { stdio: ["ignore", "pipe", "inherit"] });
const line = await new Promise((resolve) => child.stdout.once("data", (data) => resolve(String(data))));
const page = await browser.newPage({ viewport });
await page.addInitScript(count);
await page.goto(JSON.parse(line).address);
while (!(await page.textContent("#clock")).startsWith("t = ")) await page.waitForTimeout(50);
await page.focus("#canvas");
await measure(page, `${scene}, turned`, async () => {
  for (let i = 0; i < 60; ++i) {
    await page.keyboard.press("ArrowLeft");
    await page.waitForTimeout(30);
  }
});
await measure(page, `${scene}, running`, async () => {
  await page.click("#play");
  await page.waitForTimeout(6000);
  await page.click("#play");
});
await browser.close();
child.kill();
