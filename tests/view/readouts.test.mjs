// Values shown beside the bodies, in a headless browser: letters of the axes, units, the frame, scales, forces.
import assert from "node:assert/strict";
import { test } from "node:test";
import { glued, middle, noComplaints, open, pixels, patch, serve, shot, tag, text, time, until, write } from "./page_support.mjs";

test("letters of the axes never lie over each other, from wherever they are seen", async () => {
  const server = await serve("patient.json", { flags: ["--paused"] });
  const page = await open(server.address, {}, () => {
    const real = CanvasRenderingContext2D.prototype.fillText;
    CanvasRenderingContext2D.prototype.fillText = function (letter, x, y) {
      if (this.canvas.id === "triad") window.letters.push([letter, x, y]);
      real.call(this, letter, x, y);
    };
    window.letters = [];
  });
  await page.focus("#canvas");
  const seen = new Set();
  for (let turn = 0; turn < 40; ++turn) {
    await page.evaluate(() => (window.letters = []));
    await page.keyboard.press(turn < 12 ? "ArrowUp" : "ArrowLeft");
    await until("they are drawn", () => page.evaluate(() => window.letters.length > 0));
    const letters = await page.evaluate(() => window.letters.slice(-6));
    for (const [i, [letter, x, y]] of letters.entries()) {
      seen.add(letter);
      for (const [other, u, v] of letters.slice(i + 1)) {
        if (letter !== other) assert.ok(Math.hypot(x - u, y - v) > 12, `${letter} and ${other} after ${turn} turns`);
      }
    }
  }
  assert.deepEqual([...seen].sort(), ["A", "I", "L", "P", "R", "S"]);
  noComplaints(page);
  await page.close();
  await server.end();
});

test("the letters of the axes are whole on screens with any number of pixels", async () => {
  const server = await serve("patient.json", { flags: ["--paused"] });
  for (const deviceScaleFactor of [1, 1.5, 2, 3]) {
    const page = await open(server.address, { deviceScaleFactor }, () => {
      const real = CanvasRenderingContext2D.prototype.fillText;
      window.letters = [];
      CanvasRenderingContext2D.prototype.fillText = function (letter, x, y) {
        if (this.canvas.id === "triad") {
          const { actualBoundingBoxLeft: l, actualBoundingBoxRight: r, actualBoundingBoxAscent: u, actualBoundingBoxDescent: d } = this.measureText(letter);
          const corners = [[x - l, y - u], [x + r, y + d]].map(([p, q]) => this.getTransform().transformPoint({ x: p, y: q }));
          window.letters.push([letter, corners.every((p) => p.x >= 0 && p.y >= 0 && p.x <= this.canvas.width && p.y <= this.canvas.height)]);
        }
        real.call(this, letter, x, y);
      };
    });
    await page.focus("#canvas");
    for (let turn = 0; turn < 16; ++turn) {
      await page.keyboard.press(turn < 4 ? "ArrowUp" : "ArrowLeft");
      await page.waitForTimeout(60);
    }
    await page.waitForTimeout(300);
    const letters = await page.evaluate(() => window.letters);
    assert.deepEqual([...new Set(letters.map(([letter]) => letter))].sort(), ["A", "I", "L", "P", "R", "S"]);
    assert.deepEqual(letters.filter(([, whole]) => !whole), [], `${deviceScaleFactor} pixels a unit`);
    await shot(page, `triad-${deviceScaleFactor}`);
    // What is drawn has its middle in the middle: lines of all axes begin there.
    const drawn = await page.evaluate(() => {
      const canvas = document.getElementById("triad");
      const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
      let [sum, x, y] = [0, 0, 0];
      for (let i = 0; i < canvas.width * canvas.height; ++i) {
        const a = data[4 * i + 3];
        sum += a, x += a * (i % canvas.width), y += a * Math.floor(i / canvas.width);
      }
      return { x: x / sum / canvas.width, y: y / sum / canvas.height };
    });
    assert.ok(Math.abs(drawn.x - 0.5) < 0.12 && Math.abs(drawn.y - 0.5) < 0.12, `${drawn.x}, ${drawn.y}`);
    noComplaints(page);
    await page.close();
  }
  await server.end();
});

test("small lengths read in millimetres", async () => {
  const server = await serve("glued.json", { flags: ["--paused"] });
  const page = await open(server.address);
  assert.match(await text(page, "scale-bar"), /^(1|2|5)0* mm$/);
  const { x, y } = await middle(page);
  await page.mouse.click(x, y);
  await page.click("#play");
  await until("a displacement", async () => /displacement[\d.e-]+ mm/.test(await text(page, "pick")));
  assert.match(await text(page, "pick"), /position \(m\)/, "a scene of 17 cm");
  noComplaints(page);
  await page.close();
  await server.end();
});

test("what a slider reads is not cut off", async () => {
  const server = await serve("glued.json", { flags: ["--paused"] });
  const page = await open(server.address, { viewport: { width: 1440, height: 900 } });
  const cut = await page.$$eval(".slider output", (outputs) => outputs.filter((o) => o.checkVisibility()).map((o) => {
    o.textContent = "-0.131 mm";
    return o.scrollWidth > o.clientWidth;
  }));
  assert.ok(cut.length > 0 && !cut.includes(true), `${cut.length} sliders`);
  await page.close();
  await server.end();
});

/** The middle of the blue body and its size, as parts of the view, and its pixels. */
async function seenBody(page) {
  const { width, height } = await page.locator("#canvas").boundingBox();
  const { count, x, y } = await patch(page, (r, g, b) => b > r + 30);
  return { x: x / width, y: y / height, fraction: count / (width * height), count };
}

test("another size of the window fits the view again, unless a user has turned it", async () => {
  write("fitted.json", { ...glued, gravity: [0, 0, 0], bodies: [{ ...glued.bodies[0], color: [0.2, 0.4, 0.8] }] });
  const server = await serve("fitted.json", { flags: ["--paused"] });
  const page = await open(server.address, { viewport: { width: 1400, height: 450 } });
  const wide = await seenBody(page);
  await page.setViewportSize({ width: 900, height: 900 });
  const high = await seenBody(page);
  assert.ok(Math.abs(high.x - 0.5) < 0.1 && Math.abs(high.y - 0.5) < 0.1);
  assert.ok(high.fraction > 0.3, `it fills the window: ${high.fraction}`);
  assert.ok(wide.fraction > 0.1);
  await page.click("#fit");
  const same = await seenBody(page);
  assert.ok(Math.abs(same.count - high.count) < 0.01 * high.count, `as Fit does: ${high.count}, ${same.count}`);
  await page.focus("#canvas");
  await page.keyboard.press("-");
  await page.keyboard.press("-");
  const far = await seenBody(page);
  await page.setViewportSize({ width: 1000, height: 900 });
  const kept = await seenBody(page);
  assert.ok(far.count < 0.9 * high.count);
  assert.ok(Math.abs(kept.count - far.count) < 0.02 * far.count, "what a user has set stays");
  await page.click("#fit");
  const fitted = await seenBody(page);
  assert.ok(fitted.count > 1.1 * kept.count, "until Fit");
  noComplaints(page);
  await page.close();
  await server.end();
});

test("an automatic scale is that of soft bodies: prescribed bodies may go far", async () => {
  const server = await serve("scene.json", { flags: ["--speed", "max"] });
  const page = await open(server.address);
  await page.selectOption("#colouring", "displacement");
  await until("the press has gone far", async () => (await time(page)) > 1);
  const end = parseFloat(await page.locator("#legend-ticks span").last().textContent());
  assert.match(await text(page, "legend-title"), /\(mm\)/);
  assert.ok(end > 0 && end < 25, `the press goes 50 mm, tissue less: ${end}`);
  // A body shown alone has a scale.
  for (const body of ["lower", "upper"]) await page.uncheck(`.body:has-text("${body}") input[type=checkbox]`);
  await page.click("#scale-reset");
  await until("its own scale", async () => {
    const last = parseFloat(await page.locator("#legend-ticks span").last().textContent());
    return last * ((await text(page, "legend-title")).includes("(mm)") ? 1 : 1000) >= 50;
  });
  noComplaints(page);
  await page.close();
  await server.end();
});

test("a body casts a shadow on what lies below it, and none when it is hidden", async () => {
  // The plate has points at its corners alone, far from the ball: what darkens its middle is not their occlusion.
  write("shadow.json", {
    name: "shadow", time_step: 0.01, gravity: [0, 0, -9.81],
    bodies: [
      { name: "plate", box: { cells: [1, 1, 1], size: [0.4, 0.4, 0.02] }, translate: [0, 0, -0.01], obstacle: true },
      { name: "ball", ball: { radius: 0.03, resolution: 4 }, translate: [0, 0, 0.08], material: { young_modulus: 20000 } },
    ],
    output: { views: [{ name: "low", camera: { position: [0, -0.6, 0.25], target: [0, 0, 0] } }] },
  });
  const server = await serve("shadow.json", { flags: ["--paused"] });
  const page = await open(server.address);
  /** The least brightness of a row through the middle of the plate, and that of its ends. */
  const row = async () => {
    const { width, height, data } = await pixels(page);
    const at = (x, y) => data[4 * (Math.round(x * width) + width * Math.round(y * height)) + 1];
    let y = 0.3;  // the plate's middle: as wide as the view allows, below the ball
    while (at(0.3, y) > 200 || at(0.7, y) > 200) y += 0.01;
    y += 0.12;
    const values = Array.from({ length: 81 }, (_, i) => at(0.3 + 0.005 * i, y));
    return { least: Math.min(...values), ends: Math.max(values[0], values[80]) };
  };
  await shot(page, "shadow");
  const lit = await row();
  assert.ok(lit.least < 0.93 * lit.ends, `darker in the shadow: ${lit.least}, not ${lit.ends}`);
  await page.uncheck(".body:has-text('ball') input[type=checkbox]");
  const alone = await row();
  assert.ok(alone.least > 0.96 * alone.ends, `no ball, no shadow: ${alone.least}, ${alone.ends}`);
  noComplaints(page);
  await page.close();
  await server.end();
});

test("every page tells the forces of all hands", async () => {
  const server = await serve("glued.json");
  const pages = [await open(server.address), await open(server.address)];
  for (const [i, page] of pages.entries()) {
    const { x, y } = await middle(page);
    await page.mouse.move(x + 30 * i, y);
    await page.mouse.down();
    await page.mouse.move(x + 30 * i, y - 50, { steps: 3 });
  }
  for (const page of pages) {
    await until("two forces", async () => /^[\d.]+ m?N.*; [\d.]+ m?N/.test(await tag(page)));
  }
  await shot(pages[0], "two-hands");
  await pages[1].mouse.up();
  await until("one is left", async () => /^[^;]+$/.test(await tag(pages[0])));
  await pages[0].mouse.up();
  await until("none is left", async () => (await tag(pages[1])) === "");
  for (const page of pages) {
    noComplaints(page);
    await page.close();
  }
  await server.end();
});
