// Every control of the page that other tests do not cover, each key, and touch, in a headless browser.
import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import { faceColour, glued, middle, noComplaints, open, openSection, patch, pictures, pixels, PNG, serve, shot, tag, text, until, write } from "./page_support.mjs";

const blue = [0.2, 0.4, 0.8];
write("blue.json", { ...glued, gravity: [0, 0, 0], bodies: [{ ...glued.bodies[0], color: blue }] });
const theme = (page) => page.evaluate(() => document.documentElement.dataset.theme);
const background = async (page) => (await patch(page, (r, g, b) => r < 60 && g < 60 && b < 70)).count;
const written = (page) => page.evaluate(() => window.written.splice(0));

/** Keeps what is written on canvases. */
function keepWritten() {
  const real = CanvasRenderingContext2D.prototype.fillText;
  window.written = [];
  CanvasRenderingContext2D.prototype.fillText = function (words, ...place) {
    window.written.push(words);
    real.call(this, words, ...place);
  };
}

test("settings that are numbers or words act on every page", async () => {
  const server = await serve("scene.json", { flags: ["--paused"] });
  const page = await open(server.address, {}, keepWritten);
  const other = await open(server.address);
  await page.selectOption("#speed", "0.1");
  await until("the speed", async () => (await other.inputValue("#speed")) === "0.1");
  for (const id of ["settings", "developer"]) await openSection(page, id);
  await page.fill("#friction", "100");
  await until("friction", async () => (await other.inputValue("#friction")) === "100");
  await page.selectOption("#stiffness-word", "number");
  await until("a stiffness", () => page.isVisible("#stiffness"));
  await page.fill("#stiffness", "150");
  await until("the stiffness", async () => (await other.inputValue("#stiffness")) === "150");
  for (const id of ["order", "sort"]) {
    const values = await page.$$eval(`#${id} option`, (options) => options.map((o) => o.value));
    const next = values.find((value) => value !== values[0]);
    await page.selectOption(`#${id}`, next);
    await until(id, async () => (await other.inputValue(`#${id}`)) === next);
  }
  await page.selectOption("#budget-word", "ms");
  await until("a budget", () => page.isVisible("#budget"));
  await page.fill("#budget", "120");
  await until("the budget", async () => (await other.inputValue("#budget")) === "120");
  await written(page);
  await page.fill("#budget-line", "77");
  await until("the line of the budget", async () => (await written(page)).includes("budget 77 ms"));
  await page.click("#step");
  await until("it runs with all this", async () => (await text(page, "clock")).includes("step 1"));
  noComplaints(page);
  noComplaints(other);
  await page.close();
  await other.close();
  await server.end();
});

test("the ends of a fixed scale", async () => {
  const server = await serve("patient.json", { flags: ["--paused"] });
  const page = await open(server.address);
  await page.selectOption("#colouring", "displacement");
  assert.equal(await page.inputValue("#scale-most"), "4", "as a view of the scene has it");
  await page.selectOption("#scale-kind", "automatic");
  assert.equal(await page.isVisible("#scale-least"), false);
  assert.deepEqual(await page.locator("#legend-ticks span").allTextContents(), ["all 0"], "one tick where nothing has moved");
  await page.selectOption("#scale-kind", "fixed");
  assert.match(await text(page, "scale-hint"), /set the end/);
  await page.fill("#scale-most", "6");
  await page.keyboard.press("Tab");
  await page.fill("#scale-least", "2");
  await page.keyboard.press("Tab");
  assert.equal(await text(page, "legend-ticks"), "246");
  await page.fill("#scale-least", "8");
  await page.keyboard.press("Tab");
  assert.match(await text(page, "scale-hint"), /^Not taken/);
  assert.equal(await page.getAttribute("#scale-least", "aria-invalid"), "true");
  assert.equal(await text(page, "legend-ticks"), "246", "what does not begin below its end is not taken");
  await page.fill("#scale-most", "1");
  await page.keyboard.press("Tab");
  assert.equal(await text(page, "legend-ticks"), "246", "nor from 8 to 1");
  assert.equal(await page.isVisible("#scale-hint"), true);
  await page.fill("#scale-most", "10");
  await page.keyboard.press("Tab");
  assert.equal(await text(page, "legend-ticks"), "8910", "both numbers are typed one after the other");
  assert.equal(await page.isVisible("#scale-hint"), false);
  await page.selectOption("#scale-kind", "automatic");
  assert.equal(await page.isVisible("#scale-least"), false);
  noComplaints(page);
  await page.close();
  await server.end();
});

test("a list of bodies ends with a whole line, and a motion that begins later says when", async () => {
  const box = (i) => ({ name: `box ${i}`, box: { cells: [1, 1, 1], size: [0.01, 0.01, 0.01] }, translate: [0.02 * i, 0, 0], obstacle: true });
  const moved = { ...box(0), obstacle: undefined, motion: { keyframes: [{ time: 0.5 }, { time: 1, translate: [0, 0, 0.01] }] } };
  for (const count of [11, 20]) {
    write("many.json", { name: "many", time_step: 0.01, bodies: [moved, ...Array.from({ length: count - 1 }, (_, i) => box(i + 1))] });
    const server = await serve("many.json", { flags: ["--paused"] });
    const page = await open(server.address);
    const { rest, last } = await page.$eval(".list", (list) => {
      const lines = [...list.querySelectorAll(".body")].map((line) => line.getBoundingClientRect());
      const end = list.getBoundingClientRect().bottom;
      return { rest: lines.filter((line) => line.top < end - 0.5 && line.bottom > end + 0.5).length, last: lines.at(-1).bottom - end };
    });
    assert.equal(rest, 0, `${count} bodies: no line is half hidden`);
    assert.equal(last < 1, count === 11, "a short list has no scroll bar");
    assert.equal(await page.getAttribute("#motion-0", "aria-valuetext"), "from 0.5 s");
    assert.equal(await page.textContent(".slider:has(#motion-0) output"), "from 0.5 s");
    noComplaints(page);
    await page.close();
    await server.end();
  }
});

test("a saved picture and a video have the legend, the scale bar, the axes and forces", async () => {
  const server = await serve("patient.json", { flags: ["--paused"] });
  for (const deviceScaleFactor of [1, 2]) {
    const page = await open(server.address, { deviceScaleFactor, bypassCSP: true });
    await page.selectOption("#scene-view", "moved");
    await page.waitForTimeout(1000);
    const seen = await pixels(page, "#view");
    const [saved] = await Promise.all([page.waitForEvent("download"), page.click("#picture")]);
    const png = readFileSync(await saved.path());
    const picture = PNG.sync.read(png);
    writeFileSync(join(pictures, `viewer-saved-${deviceScaleFactor}.png`), png);
    assert.deepEqual([picture.width, picture.height], [seen.width, seen.height]);
    for (const id of ["legend", "scale-bar", "triad"]) await sameThere(page, id, seen, picture, deviceScaleFactor);
    if (deviceScaleFactor === 1) {
      await page.click("#video");
      for (const key of ["ArrowLeft", "ArrowRight"]) {
        await page.focus("#canvas");
        await page.keyboard.press(key);
        await page.waitForTimeout(700);
      }
      const [video] = await Promise.all([page.waitForEvent("download"), page.click("#video")]);
      const bytes = readFileSync(await video.path()).toString("base64");
      const frame = await page.evaluate(async (data) => {
        const film = document.createElement("video");
        film.muted = true;
        film.src = `data:video/webm;base64,${data}`;
        await new Promise((resolve, reject) => { film.onloadeddata = resolve; film.onerror = () => reject(new Error(film.error.message)); });
        const frame = new Promise((resolve) => film.requestVideoFrameCallback(resolve));
        await film.play();
        await frame;
        const canvas = document.createElement("canvas");
        canvas.width = film.videoWidth, canvas.height = film.videoHeight;
        canvas.getContext("2d").drawImage(film, 0, 0);
        return canvas.toDataURL("image/png").split(",")[1];
      }, bytes);
      writeFileSync(join(pictures, "viewer-video-frame.png"), frame, "base64");
      const film = PNG.sync.read(Buffer.from(frame, "base64"));
      assert.deepEqual([film.width, film.height], [seen.width, seen.height]);
      for (const id of ["legend", "scale-bar", "triad"]) await sameThere(page, id, seen, film, 1, 12);
    }
    noComplaints(page);
    await page.close();
  }
  await server.end();
});

/** Two pictures of the view are the same where an element lies, up to a part of a pixel, and show more than one colour there. */
async function sameThere(page, id, seen, picture, ratio, most = 6) {
  const view = await page.locator("#view").boundingBox();
  const box = await page.locator(`#${id}`).boundingBox();
  const sums = [0, 0, 0];
  let [count, inked] = [0, 0];
  const at = (x, y) => 4 * (Math.round(ratio * x) + seen.width * Math.round(ratio * y));
  const first = at(box.x - view.x + 4, box.y - view.y + 4);
  for (let y = box.y - view.y; y < box.y - view.y + box.height; ++y) {
    for (let x = box.x - view.x; x < box.x - view.x + box.width; ++x) {
      const i = at(x, y);
      ++count;
      for (const k of [0, 1, 2]) sums[k] += Math.abs(seen.data[i + 1] - picture.data[i + 1 + 4 * seen.width * (k - 1)]);
      if (Math.abs(picture.data[i] - picture.data[first]) > 40) ++inked;
    }
  }
  const differs = Math.min(...sums) / count;
  assert.ok(differs < most, `${id}, ${ratio} pixels: differs by ${differs} of 255`);
  assert.ok(inked > 0.02 * count, `${id} is there: ${inked} of ${count}`);
}

/** Takes hold of what is in the middle of the view, and pulls it to the right and up. */
async function pull(page) {
  const { x, y } = await middle(page);
  await page.mouse.move(x, y);
  await page.mouse.down();
  await page.mouse.move(x + 20, y - 10, { steps: 2 });
}

test("a pull in a pause says why nothing moves", async () => {
  const server = await serve("glued.json");
  const page = await open(server.address);
  await pull(page);
  await until("a force", async () => parseFloat(await tag(page)) > 0);
  assert.equal(await page.isVisible("#notice"), false);
  await page.mouse.up();
  await page.click("#play");
  await until("a pause", async () => (await page.textContent("#play")) === "Play");
  await pull(page);
  await until("a notice", () => page.isVisible("#notice"));
  assert.match(await page.textContent("#notice"), /paused/);
  await page.mouse.up();
  noComplaints(page);
  await page.close();
  await server.end();
});

test("a weak pull pulls less", async () => {
  const server = await serve("glued.json");
  const page = await open(server.address);
  const force = async () => {
    await pull(page);
    await until("a force", async () => parseFloat(await tag(page)) > 0);
    await page.waitForTimeout(1500);
    const [, size, prefix] = /^([\d.]+) (m?)N/.exec(await tag(page));
    await page.mouse.up();
    await until("none", async () => (await tag(page)) === "");
    return Number(size) * (prefix ? 1e-3 : 1);
  };
  const usual = await force();
  await page.fill("#strength", "0");
  const weak = await force();
  assert.ok(weak < 0.5 * usual, `${weak} N, ${usual} N`);
  noComplaints(page);
  await page.close();
  await server.end();
});

test("a cut across the view looks at the eye; buttons and keys of the view", async () => {
  const server = await serve("blue.json", { flags: ["--paused"] });
  const page = await open(server.address, { colorScheme: "light" });
  const face = async () => (await patch(page, faceColour(blue), 3)).count;
  await page.selectOption("#cut-axis", "view");
  await page.check("#cut");
  const straight = await face();
  assert.ok(straight > 1000);
  const press = async (...keys) => {
    await page.focus("#canvas");
    for (const key of keys) await page.keyboard.press(key);
  };
  await press(...Array(10).fill("ArrowLeft"));
  const aslant = await face();
  assert.ok(aslant < 0.8 * straight, "the cut stays where it was");
  await press("c");
  assert.equal(await page.isChecked("#cut"), false);
  await press("c");
  assert.ok((await face()) > 1.1 * aslant, "after another cut, it looks at the eye again");
  await press("c");

  const triad = () => page.evaluate(() => document.getElementById("triad").toDataURL());
  for (const key of ["ArrowLeft", "ArrowUp", "ArrowRight", "ArrowDown"]) {
    const before = await triad();
    await press(key);
    await until(`${key} turns`, async () => (await triad()) !== before);
  }
  const pixels = async () => (await patch(page, (r, g, b) => b > r + 30)).count;
  await press("f");
  const fitted = await pixels();
  await press("-", "-");
  assert.ok((await pixels()) < 0.8 * fitted);
  await press("+", "+", "+", "+");
  assert.ok((await pixels()) > 1.1 * fitted);
  await page.click("#fit");
  assert.ok(Math.abs((await pixels()) - fitted) < 0.02 * fitted);

  assert.equal(await theme(page), "light");
  assert.ok((await background(page)) < 2000);
  await page.click("#theme");
  assert.equal(await theme(page), "dark");
  assert.ok((await background(page)) > 100000, "the view is dark");
  await press("t");
  assert.equal(await theme(page), "light");
  await page.click("#help");
  await until("the keys", () => page.isVisible("#keys"));
  assert.match(await text(page, "keys"), /cut the bodies open/);
  await page.click("#keys button");
  assert.equal(await page.isVisible("#keys"), false);

  await openSection(page, "developer");
  for (const [key, id] of [["a", "show-arrows"], ["e", "show-borders"], ["d", "show-cells"]]) {
    await press(key);
    assert.equal(await page.isChecked(`#${id}`), true, key);
  }
  for (const [key, colouring] of [["2", "depth"], ["3", "displacement"], ["1", "body"]]) {
    await press(key);
    assert.equal(await page.inputValue("#colouring"), colouring);
    assert.equal(await page.isVisible("#legend"), colouring !== "body");
  }
  const saved = async (key) => (await Promise.all([page.waitForEvent("download"), press(key)]))[0].suggestedFilename();
  assert.equal(await saved("p"), "glued box.png");
  await press("v");
  assert.equal(await text(page, "video"), "Stop");
  await press("ArrowLeft", "ArrowRight");
  await page.waitForTimeout(500);
  assert.equal(await saved("v"), "glued box.webm");
  noComplaints(page);
  await page.close();
  await server.end();
});

test("what is chosen while nothing moves is drawn, also after shadows were", async () => {
  const server = await serve("blue.json", { flags: ["--paused"] });
  const page = await open(server.address, {}, () => {
    performance.now = () => 0;  // no picture is slow, so none is drawn again with more pixels
    const real = window.requestAnimationFrame.bind(window);
    window.requestAnimationFrame = (draw) => real(function later(now) { window.held ? real(later) : draw(now); });
  });
  /** All that follows from an action comes into one picture, as on a busy machine. */
  const inOnePicture = async (act) => {
    await page.evaluate(() => (window.held = true));
    await act();
    await page.waitForTimeout(500);
    await page.evaluate(() => (window.held = false));
    await page.waitForTimeout(500);
  };
  const seen = async () => (await patch(page, (r, g, b) => b > r + 30 && b > 120)).count;
  const shown = ".body:has-text('box') input[type=checkbox]";
  for (let turn = 0; turn < 2; ++turn) {
    await inOnePicture(() => page.uncheck(shown));
    await inOnePicture(() => page.check(shown));  // draws the shadows again
    const blues = await seen();
    assert.ok(blues > 20000, "the body in its colour");
    await inOnePicture(() => page.selectOption("#colouring", "displacement"));
    assert.ok((await seen()) < 0.2 * blues, "now in the colour of 0; some of the legend is blue");
    await inOnePicture(() => page.selectOption("#colouring", "body"));
  }
  noComplaints(page);
  await page.close();
  await server.end();
});

test("what keys hold, the mouse does not move; a click lets it go", async () => {
  const server = await serve("glued.json");
  const page = await open(server.address, {}, () => {
    const real = WebSocket.prototype.send;
    window.sent = [];
    WebSocket.prototype.send = function (message) {
      window.sent.push(Object.keys(JSON.parse(message))[0]);
      real.call(this, message);
    };
  });
  const sent = async (name) => (await page.evaluate(() => window.sent)).filter((one) => one === name).length;
  const { x, y } = await middle(page);
  await page.focus("#canvas");
  await page.keyboard.press("g");
  await until("it is held", async () => (await sent("pull")) === 1);
  assert.equal(await page.isVisible("#crosshair"), true);
  await page.mouse.move(x + 50, y + 50, { steps: 3 });
  await page.waitForTimeout(200);
  assert.equal(await sent("move_pull"), 0);
  await page.keyboard.press("ArrowUp");
  await until("keys move it", async () => (await sent("move_pull")) === 1);
  await page.mouse.click(x, y);
  await until("it is let go", async () => (await sent("let_go")) > 0);
  assert.equal(await page.isVisible("#crosshair"), false);
  noComplaints(page);
  await page.close();
  await server.end();
});

test("one finger pulls or turns, two bring nearer", async () => {
  const server = await serve("glued.json");
  const page = await open(server.address, { hasTouch: true }, () => {
    const real = WebSocket.prototype.send;
    window.sent = [];
    WebSocket.prototype.send = function (message) {
      window.sent.push(Object.keys(JSON.parse(message))[0]);
      real.call(this, message);
    };
  });
  const fingers = await page.context().newCDPSession(page);
  const send = (type, ...touchPoints) => fingers.send("Input.dispatchTouchEvent", { type, touchPoints });
  const { x, y } = await middle(page);
  await send("touchStart", { x, y, id: 0 });
  await send("touchMove", { x: x + 40, y: y - 40, id: 0 });
  await until("a force", async () => parseFloat(await tag(page)) > 0);
  const bar = () => page.evaluate(() => document.getElementById("scale-bar").style.width + document.getElementById("scale-bar").textContent);
  const triad = () => page.evaluate(() => document.getElementById("triad").toDataURL());
  const [before, turned] = [await bar(), await triad()];
  await page.evaluate(() => (window.sent = []));
  // A second finger neither pulls nor moves the view while the first holds tissue.
  await send("touchStart", { x: x + 40, y: y - 40, id: 0 }, { x: x - 20, y, id: 1 });
  await send("touchMove", { x: x + 40, y: y - 40, id: 0 }, { x: x - 150, y, id: 1 });
  await page.waitForTimeout(300);
  assert.equal(await triad(), turned);
  assert.deepEqual((await page.evaluate(() => window.sent)).filter((name) => name !== "shown"), []);
  await send("touchEnd");
  await until("it is let go", async () => (await tag(page)) === "");
  const box = await page.locator("#canvas").boundingBox();
  const corner = { x: box.x + 30, y: box.y + 40 };
  await send("touchStart", { ...corner, id: 0 });
  await send("touchMove", { x: corner.x + 60, y: corner.y + 20, id: 0 });
  await send("touchEnd");
  await until("the view has turned", async () => (await triad()) !== turned);
  assert.equal(await bar(), before);
  await send("touchStart", { ...corner, id: 0 });
  await send("touchStart", { ...corner, id: 0 }, { x: corner.x + 60, y: corner.y, id: 1 });
  await send("touchMove", { ...corner, id: 0 }, { x: corner.x + 160, y: corner.y, id: 1 });
  await send("touchEnd");
  await until("nearer", async () => (await bar()) !== before);
  await shot(page, "touch");
  noComplaints(page);
  await page.close();
  await server.end();
});
