// Cut bodies in a headless browser: the control of the cut, its faces, and picking there.
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import { command, faceColour, folder, glued, hasColour, middle, near, noComplaints, open, patch, patient, pixels, PNG, scene, serve, shot, tag, text, until, write } from "./page_support.mjs";

const blue = [0.2, 0.4, 0.8];
const red = [0.8, 0.3, 0.2];
const boxWithColour = { ...glued, gravity: [0, 0, 0], bodies: [{ ...glued.bodies[0], color: blue }] };
const coloured = { ...patient, bodies: patient.bodies.map((body) => (body.name === "lower" ? { ...body, color: blue } : body)) };
write("coloured.json", { ...boxWithColour, name: "coloured" });
write("coloured-patient.json", coloured);
const [, half] = patient.output.views;
const oblique = { ...half, name: "oblique", cut: { point: [0, 0, 40], normal: [1, -1, 0], bodies: ["lower"] } };
const closed = { ...half, name: "closed", cut: undefined };
write("oblique.json", { ...coloured, output: { views: [oblique, half, closed] } });

test("a cut has faces in the colour of the body, and edges show", async () => {
  const server = await serve("coloured.json", { flags: ["--paused"] });
  const page = await open(server.address);
  await page.selectOption("#cut-axis", "y");
  await page.check("#cut-flip");
  await page.check("#cut");
  await until("a face", () => hasColour(page, faceColour(blue)));
  await page.check("#show-edges");
  await shot(page, "cut-face");
  noComplaints(page);
  await page.close();
  await server.end();
});

/** Moves a slider of the panel to a place between 0 and 1. */
const slide = (page, id, fraction) => page.locator(`#${id}`).fill(String(Math.round(200 * fraction)));

test("the cut of a named view can be moved, turned round and closed", async () => {
  const server = await serve("coloured-patient.json", { flags: ["--paused"] });
  const page = await open(server.address);
  const face = () => patch(page, faceColour(blue), 3);
  const before = await face();
  assert.ok(before.count > 1000, "the view cuts the body open");
  assert.deepEqual(await control(page), { on: true, axis: "y", flip: true, place: "0 mm" });
  await slide(page, "cut-place", 0.4);
  await page.click("#fit");  // the other half may have to be fitted: counts are compared as fitted
  const moved = await face();
  assert.ok(moved.count > 1000, "the body stays cut open");
  assert.ok(Math.hypot(moved.x - before.x, moved.y - before.y) > 3, "its face moves");
  assert.equal(await page.isChecked("#cut"), true);
  const skin = () => patch(page, (r, g, b) => b > r + 60);
  const half = await skin();
  await page.uncheck("#cut-flip");
  const other = await skin();
  assert.ok(Math.hypot(other.x - half.x, other.y - half.y) > 10, "the other half is kept");
  await page.check("#cut-flip");
  await page.click("#fit");
  const back = await face();
  assert.ok(Math.abs(back.count - moved.count) < 20);
  await page.uncheck("#cut");
  const whole = await skin();
  assert.ok(Math.hypot(whole.x - half.x, whole.y - half.y) > 3, "the body is closed");
  await page.check("#cut");
  await page.click("#fit");
  assert.ok(Math.abs((await face()).count - moved.count) < 20);
  await page.selectOption("#cut-axis", "z");
  assert.equal((await control(page)).on, true);
  assert.ok(Math.abs((await face()).count - moved.count) > 100, "another face");
  await page.selectOption("#scene-view", "everything");
  assert.equal((await control(page)).on, false);
  await page.selectOption("#scene-view", "lower-half");
  const again = await face();
  assert.ok(Math.abs(again.count - before.count) < 20, "the view has its own cut again");
  noComplaints(page);
  await page.close();
  await server.end();
});

test("a slanting cut of a view moves along its own normal, and cuts its own bodies alone", async () => {
  const server = await serve("oblique.json", { flags: ["--paused"] });
  const page = await open(server.address);
  const face = () => patch(page, faceColour(blue), 3);
  assert.equal((await control(page)).axis, "view");
  const before = await face();
  assert.ok(before.count > 1000);
  const plate = () => patch(page, faceColour([0.72, 0.72, 0.74]), 2);
  // Where a shadow begins, some pixels of its skin are as dark as a face would be.
  const few = 60;
  assert.ok((await plate()).count < few, "the plate is whole");
  await slide(page, "cut-place", 0.45);
  const moved = await face();
  assert.ok(moved.count > 1000 && Math.hypot(moved.x - before.x, moved.y - before.y) > 3);
  assert.ok((await plate()).count < few, "and stays whole");
  // Off and on again, after a rotation of the view, the plane is the same.
  await page.uncheck("#cut");
  await page.focus("#canvas");
  await page.keyboard.press("ArrowLeft");
  await page.keyboard.press("ArrowRight");
  await page.check("#cut");
  assert.ok(Math.abs((await face()).count - moved.count) < 20);
  await page.selectOption("#scene-view", "closed");
  assert.equal((await face()).count, 0);
  await page.check("#cut");
  const whole = (await plate()).count;
  assert.ok(whole > 5 * few, `a view without a cut leaves no list of bodies behind: ${whole}`);
  noComplaints(page);
  await page.close();
  await server.end();
});

test("the page says which bodies are cut, and cuts others on demand", async () => {
  const server = await serve("oblique.json", { flags: ["--paused"] });
  const page = await open(server.address);
  const plate = () => patch(page, faceColour([0.72, 0.72, 0.74]), 2);
  const pressed = () => page.$$eval(".scissors", (all) => all.filter((one) => one.getAttribute("aria-pressed") === "true").map((one) => one.getAttribute("aria-label")));
  assert.equal(await text(page, "cut-bodies"), "Cuts: lower. 3 others stay whole.");
  assert.deepEqual(await pressed(), ["Cut lower"]);
  const whole = (await plate()).count;
  await page.click("[aria-label='Cut plate']");
  assert.equal(await text(page, "cut-bodies"), "Cuts: plate, lower. 2 others stay whole.");
  assert.deepEqual(await pressed(), ["Cut plate", "Cut lower"]);
  const cut = (await plate()).count;
  assert.ok(cut > whole + 200, `the plate has a face: ${cut}, ${whole} before`);
  await shot(page, "cut-bodies");
  await page.click("[aria-label='Cut plate']");
  await page.click("[aria-label='Cut lower']");
  assert.equal(await text(page, "cut-bodies"), "Cuts: none.");
  assert.equal((await patch(page, faceColour(blue), 3)).count, 0);
  await page.click("#cut-all");
  assert.equal(await text(page, "cut-bodies"), "Cuts: all bodies.");
  assert.equal(await page.isVisible("#cut-all"), false);
  assert.equal((await pressed()).length, 4);
  await page.uncheck("#cut");
  assert.equal(await text(page, "cut-bodies"), "");
  assert.equal(await page.isVisible("[aria-label='Cut plate']"), false);
  noComplaints(page);
  await page.close();
  await server.end();
});

test("another axis of the cut keeps what is shown in the frame; places are round", async () => {
  const server = await serve("coloured-patient.json", { flags: ["--paused"] });
  const page = await open(server.address);
  const atBorder = async () => {
    const { width, height, data } = await pixels(page);
    let count = 0;
    for (let i = 0; i < width * height; ++i) {
      const [x, y] = [i % width, Math.floor(i / width)];
      // Blue or grey bodies: the background is brighter, shadows are not at all sides.
      if ((x < 2 || x >= width - 2 || y < 2) && data[4 * i + 1] < 205) ++count;
    }
    return count;
  };
  await page.selectOption("#cut-axis", "z");
  await slide(page, "cut-place", 0.35);
  await page.click("#fit");
  assert.equal(await atBorder(), 0);
  for (const axis of ["x", "y", "view", "z"]) {
    await page.selectOption("#cut-axis", axis);
    assert.equal(await atBorder(), 0, axis);
    for (const fraction of [0.31, 0.473, 0.512]) {
      await slide(page, "cut-place", fraction);
      assert.match((await control(page)).place, /^-?\d+(\.\d)? mm$/, axis);
    }
  }
  await shot(page, "cut-axis");
  noComplaints(page);
  await page.close();
  await server.end();
});

/** What the controls of the cut say. */
async function control(page) {
  const place = await page.locator(".slider:has(#cut-place) output").textContent();
  return { on: await page.isChecked("#cut"), axis: await page.inputValue("#cut-axis"), flip: await page.isChecked("#cut-flip"), place };
}

test("a face is touched where it is seen: it names its body, is picked and pulled", async () => {
  // The upper box stands behind the face of the lower one.
  const [, lower, upper] = patient.bodies;
  const two = { ...patient, bodies: [lower, { ...upper, translate: [0, 105, 50] }] };
  const view = { name: "cut", camera: { position: [0, -400, 60], target: [0, 0, 40] }, cut: { point: [0, 0, 0], normal: [0, -1, 0], bodies: ["lower"] } };
  write("touched.json", { ...two, gravity: [0, 0, 0], output: { views: [view] } });
  const server = await serve("touched.json");
  const page = await open(server.address);
  const { x, y } = await middle(page);
  await page.mouse.move(x + 30, y);
  await page.mouse.move(x, y);
  await until("the name of the face", async () => (await page.isVisible("#hover")) && (await text(page, "hover")).startsWith("lower"));
  await page.mouse.click(x, y);
  await until("it is picked", async () => /bodylower/.test(await text(page, "pick")));
  const place = /position \(mm\)([-\d., ]+)/.exec(await text(page, "pick"))[1].split(", ").map(Number);
  assert.ok(place[1] > -1, `a vertex of the half that is kept: ${place}`);
  await page.mouse.down();
  await page.waitForTimeout(300);
  assert.ok((await tag(page)) === "" || parseFloat(await tag(page)) < 1, "a hand that stands still does not pull");
  await page.mouse.move(x + 40, y - 40, { steps: 3 });
  await until("a force", async () => parseFloat(await tag(page)) > 0);
  await until("the point follows", async () => parseFloat(/displacement([\d.e-]+)/.exec(await text(page, "pick"))[1]) > 1);
  await shot(page, "cut-pull");
  await page.mouse.up();
  await page.uncheck(".body:has-text('lower') input[type=checkbox]");
  await page.mouse.move(x + 30, y);
  await page.mouse.move(x, y);
  await until("what lies behind, once the body is hidden", async () => (await text(page, "hover")).startsWith("upper"));
  noComplaints(page);
  await page.close();
  await server.end();
});

/** A colour of viridis as published: of 0.25, between those of 0.2 and 0.3. */
const quarter = [59, 82, 139];
const grey = [0.72, 0.72, 0.74];

test("the faces of a cut show the field, on the scale of the scene's view, and rigid bodies are grey", async () => {
  // A box that flies: all of it, the inside too, has gone as far as its speed says. 1 cm of a scale of 4 cm.
  const view = (more) => ({ camera: { position: [0, -0.5, 0], target: [0, 0, 0] }, cut: { point: [0, 0, 0], normal: [0, -1, 0] }, ...more });
  const flying = {
    name: "flying", time_step: 0.01, duration: 0.1, gravity: [0, 0, 0],
    bodies: [
      { name: "box", box: { cells: [4, 4, 4], size: [0.1, 0.1, 0.1] }, translate: [-0.08, 0, 0], velocity: [0, 0, 0.1], material: { young_modulus: 20000 }, color: blue },
      { name: "wall", box: { cells: [2, 2, 2], size: [0.1, 0.1, 0.1] }, translate: [0.08, 0, 0], obstacle: true, color: red },
    ],
    output: { views: [view({ name: "plain" }), view({ name: "gone", displacement: { most: 0.04 } })] },
  };
  write("flying.json", flying);
  const made = spawnSync(command, ["run", "flying.json", "--out", "flown", "--threads", "1"], { cwd: folder });
  assert.equal(made.status, 0, String(made.stderr));
  const server = await serve("flown", { flags: ["--paused"] });
  const page = await open(server.address);
  assert.ok((await patch(page, faceColour(blue), 4)).count > 5000);
  assert.ok((await patch(page, faceColour(red), 4)).count > 5000);
  await page.selectOption("#colouring", "displacement");
  await page.focus("#seek");
  await page.keyboard.press("End");
  await until("the end", async () => (await text(page, "clock")).startsWith("t = 0.100"));
  assert.equal(await text(page, "legend-ticks"), "02040", "mm, as the view of the scene has it");
  const field = await patch(page, quarter, 3);
  assert.ok(field.count > 5000, `the face of the box has the colour of its displacement: ${field.count}`);
  assert.ok((await patch(page, faceColour(grey), 3)).count > 5000, "the wall is grey");
  for (const own of [blue, red]) assert.equal((await patch(page, faceColour(own), 4)).count, 0, "no face has the colour of its body");
  await shot(page, "cut-field");
  // The picture of the command says the same. Its light is white, so what is left of a colour is the proportion of its channels.
  const picture = PNG.sync.read(readFileSync(join(folder, "flown/gone.png")));
  const [left, right] = [middleOf(picture, 0, 0.5), middleOf(picture, 0.5, 0.8)];
  assert.ok(distance(left, quarter) < 0.06, `the box of the picture: ${left}`);
  assert.ok(distance(right, grey) < 0.06, `the wall of the picture: ${right}`);
  noComplaints(page);
  await page.close();
  await server.end();
});

test("bodies without a colour have the same in the page and in the picture", async () => {
  const both = {
    name: "both", time_step: 0.01, duration: 0.01, gravity: [0, 0, 0],
    bodies: [
      { name: "wall", box: { cells: [2, 2, 2], size: [0.1, 0.1, 0.1] }, translate: [-0.08, 0, 0], obstacle: true },
      { name: "box", box: { cells: [4, 4, 4], size: [0.1, 0.1, 0.1] }, translate: [0.08, 0, 0], material: { young_modulus: 20000 } },
    ],
    output: { views: [{ name: "front", camera: { position: [0, -0.5, 0], target: [0, 0, 0] } }] },
  };
  write("both.json", both);
  const made = spawnSync(command, ["run", "both.json", "--out", "both", "--threads", "1"], { cwd: folder });
  assert.equal(made.status, 0, String(made.stderr));
  const server = await serve("both", { flags: ["--paused"] });
  const page = await open(server.address);
  const seen = await pixels(page);
  const picture = PNG.sync.read(readFileSync(join(folder, "both/front.png")));
  for (const [from, to, colour] of [[0, 0.5, grey], [0.5, 1, [0.93, 0.65, 0.15]]]) {
    const [here, there] = [middleOf(seen, from, to), middleOf(picture, from, to)];
    assert.ok(distance(here, colour) < 0.08, `the page: ${here}, not ${colour}`);
    assert.ok(distance(there, colour) < 0.08, `the picture: ${there}, not ${colour}`);
  }
  noComplaints(page);
  await page.close();
  await server.end();
});

/** The mean colour of a small square in the middle of a part of a picture, given by fractions of its width. */
function middleOf({ width, height, data }, from, to) {
  const sum = [0, 0, 0];
  const [x, y] = [Math.round((width * (from + to)) / 2), Math.round(height / 2)];
  for (let i = -10; i <= 10; ++i) {
    for (let j = -10; j <= 10; ++j) for (let c = 0; c < 3; ++c) sum[c] += data[4 * (x + i + width * (y + j)) + c] / 441;
  }
  return sum;
}

/** Between two colours of sRGB without their brightness. */
function distance(a, b) {
  const [p, q] = [a, b].map((rgb) => {
    const most = Math.max(...rgb);
    const linear = rgb.map((c) => (c / most) ** 2.2);
    const sum = linear.reduce((s, c) => s + c);
    return linear.map((c) => c / sum);
  });
  return Math.hypot(...p.map((c, i) => c - q[i]));
}

/** A box of tets that bulges, as text of a mesh: from where ever it is seen, triangles lie edge on. */
function bulging(cells) {
  const side = Array.from({ length: cells + 1 }, (_, i) => (2 * i) / cells - 1);
  const points = side.flatMap((x) => side.flatMap((y) => side.map((z) => {
    const bulge = 0.05 * (0.4 + (0.6 * Math.max(Math.abs(x), Math.abs(y), Math.abs(z))) / (Math.hypot(x, y, z) || 1));
    return [x, y, z].map((c) => bulge * c);
  })));
  const at = ([x, y, z]) => (x * (cells + 1) + y) * (cells + 1) + z + 1;
  const tets = [];
  for (let cell = 0; cell < cells ** 3; ++cell) {
    const corner = [Math.floor(cell / cells ** 2), Math.floor(cell / cells) % cells, cell % cells];
    // One tet for each order of axes on the path from a corner of the cell to the opposite one.
    for (const order of [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [1, 0, 2], [2, 1, 0]]) {
      const path = [corner];
      for (const axis of order) path.push(path.at(-1).map((c, k) => c + (k === axis ? 1 : 0)));
      const [a, b, c, d] = path.map(at);
      tets.push((order[1] - order[0] + 3) % 3 === 1 ? [a, b, c, d] : [a, c, b, d]);
    }
  }
  const lines = (rows) => rows.map((row) => `${row.join(" ")} 0\n`).join("");
  return `MeshVersionFormatted 2\nDimension 3\nVertices ${points.length}\n${lines(points)}Tetrahedra ${tets.length}\n${lines(tets)}End\n`;
}

test("faces of bodies that overlap are clean: no stray pixels, smooth outlines", async () => {
  writeFileSync(join(folder, "bulging.mesh"), bulging(7));
  const box = (name, color, translate, rotate) => ({ name, color, obstacle: true, mesh: "bulging.mesh", translate, rotate });
  const boxes = [box("first", blue, [0, -0.02, 0], { axis: [0.2, 1, 0.1], angle: 20 }), box("second", red, [0.05, -0.01, 0.04], { axis: [0.1, 1, 0.3], angle: 50 })];
  const view = { name: "cut", camera: { position: [0.05, -0.5, 0.02], target: [0.02, 0, 0.02] }, cut: { point: [0, 0, 0], normal: [0, -1, 0] } };
  write("overlapping.json", { name: "overlapping", bodies: boxes, output: { views: [view] } });
  const server = await serve("overlapping.json", { flags: ["--paused"] });
  const page = await open(server.address);
  await page.evaluate(() => document.querySelectorAll("#view > :not(#canvas)").forEach((over) => (over.style.display = "none")));
  await shot(page, "cut-clean");
  const picture = await pixels(page);
  const { width, height, data } = picture;
  // 1, 2: a face; 3: grey only; 0: a mixture.
  const faces = [faceColour(blue), faceColour(red)];
  const kind = Array.from({ length: width * height }, (_, i) => {
    const face = faces.findIndex((rgb) => near(picture, i, rgb, 3));
    const rgb = [...data.subarray(4 * i, 4 * i + 3)];
    return face >= 0 ? face + 1 : Math.max(...rgb) - Math.min(...rgb) < 8 ? 3 : 0;
  });
  let stray = 0;
  let [sharp, smooth] = [0, 0];
  for (let y = 1; y + 1 < height; ++y) {
    for (let x = 1; x + 1 < width; ++x) {
      const i = x + width * y;
      const around = [-width - 1, -width, -width + 1, -1, 1, width - 1, width, width + 1].map((d) => kind[i + d]);
      if (around[0] !== 0 && around[0] !== kind[i] && around.every((k) => k === around[0])) ++stray;
      if (kind[i] === 0) ++smooth;
      if (kind[i] > 0 && kind[i + 1] > 0 && kind[i] !== kind[i + 1]) ++sharp;
    }
  }
  for (const face of [1, 2]) assert.ok(kind.filter((k) => k === face).length > 5000, `face ${face} is seen`);
  assert.equal(stray, 0, "pixels of another colour than all around");
  assert.ok(sharp < 0.5 * smooth, `outlines have steps: ${sharp} sides without a colour between, ${smooth} pixels with one`);
  noComplaints(page);
  await page.close();
  await server.end();
});
