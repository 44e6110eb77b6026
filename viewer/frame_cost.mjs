// What it costs the page to draw a frame of a scene, on whatever draws here (in headless Chromium: the software renderer).
//   node viewer/frame_cost.mjs build/release/apps/palpate/palpate scenes/eye.json [WIDTH HEIGHT]
// Turns the view 60 times and waits after each frame until it is drawn; prints least, median and largest milliseconds, and those of the processor.
import { spawn } from "node:child_process";
import { readdirSync, readFileSync } from "node:fs";
import { launch, webgl } from "../tests/browser.mjs";

/** Seconds of the processor that the page (scripts, layout) and what rasterises for it have used: a busy machine does not count. */
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
const child = spawn(command, ["view", scene, "--json", "--no-browser", "--paused", "--threads", "1"], { stdio: ["ignore", "pipe", "inherit"] });
const line = await new Promise((resolve) => child.stdout.once("data", (data) => resolve(String(data))));
const browser = await launch(webgl);
const page = await browser.newPage({ viewport: { width: Number(width), height: Number(height) } });
await page.addInitScript(() => {
  const real = window.requestAnimationFrame.bind(window);
  window.frameTimes = [];
  window.requestAnimationFrame = (draw) => real((now) => {
    const begin = performance.now();
    draw(now);
    const canvas = document.getElementById("canvas");
    const gl = canvas.getContext("webgl2");
    if (!gl || !window.counting) return;
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));  // waits until all is drawn
    const took = performance.now() - begin;
    if (took > 3) window.frameTimes.push(took);
  });
});
await page.goto(JSON.parse(line).address);
while (!(await page.textContent("#clock")).startsWith("t = ")) await page.waitForTimeout(50);
await page.waitForTimeout(1000);
await page.focus("#canvas");
await page.evaluate(() => (window.counting = true));
const before = seconds();
for (let i = 0; i < 60; ++i) {
  await page.keyboard.press("ArrowLeft");
  await page.waitForTimeout(30);
}
const after = seconds();
const times = (await page.evaluate(() => window.frameTimes)).sort((a, b) => a - b);
const ms = (i) => times[Math.min(i, times.length - 1)].toFixed(1);
const each = (what) => ((1000 * (after[what] - before[what])) / times.length).toFixed(1);
console.log(`${scene}, ${width} x ${height}: ${times.length} frames, ms: least ${ms(0)}, median ${ms(times.length >> 1)}, largest ${ms(times.length - 1)}; processor a frame: page ${each("page")} ms, rasterising ${each("raster")} ms`);
await browser.close();
child.kill();
