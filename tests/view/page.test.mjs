// The page of `palpate view` in a headless browser: actions of a user and their effects.
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { readFileSync, statSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import { command, folder, glued, hasColour, material, middle, noComplaints, open, openSection, patch, serve, shot, tag, text, time, until, write } from "./page_support.mjs";

/** The colour of arrows of contacts. */
const arrow = [230, 0, 200];

// One corner of a tet in a box: three border edges, each through its top.
const pricked = {
  name: "pricked box",
  bodies: [
    { name: "box", box: { cells: [1, 1, 1], size: [0.1, 0.1, 0.1] }, obstacle: true },
    { name: "needle", mesh: "needle.mesh", material },
  ],
};
writeFileSync(join(folder, "needle.mesh"), `MeshVersionFormatted 2
Dimension 3
Vertices 4
0.01 0.02 0.03 0
0.03 0.02 0.2 0
-0.01 0.025 0.2 0
0 0.05 0.2 0
Tetrahedra 1
1 2 3 4 0
End
`);
write("pricked.json", pricked);

test("loads, plays, pauses, steps, resets", async () => {
  const server = await serve("scene.json", { flags: ["--paused"] });
  const page = await open(server.address);
  assert.equal(await text(page, "title"), "two boxes");
  assert.equal(await time(page), 0);
  await page.click("#step");
  await until("one step", async () => (await time(page)) === 0.01);
  await page.click("#play");
  await until("it plays", async () => (await time(page)) > 0.1);
  assert.equal(await text(page, "play"), "Pause");
  await page.keyboard.press("Space");
  await until("it pauses", async () => (await text(page, "play")) === "Play");
  let stopped;
  await until("it stands still", async () => {
    stopped = await time(page);
    await page.waitForTimeout(1500);
    return (await time(page)) === stopped;
  });
  await page.keyboard.press("n");
  await until("a step by key", async () => Math.abs((await time(page)) - stopped - 0.01) < 1e-9);
  await page.click("#reset");
  await until("back at the start", async () => (await time(page)) === 0);
  noComplaints(page);
  await page.close();
  assert.equal(await server.end(), 0);
});

test("a drag moves tissue, says with what force, and lets it go", async () => {
  const server = await serve("glued.json");
  const page = await open(server.address);
  await until("it has settled", async () => (await time(page)) > 0.5);
  const { x, y } = await middle(page);
  await page.mouse.move(x, y);
  await page.mouse.down();
  await page.mouse.move(x + 60, y - 60, { steps: 4 });
  await until("a force is told", async () => parseFloat(await tag(page)) > 0);
  assert.match(await tag(page), / m?N/);
  const displacement = async () => parseFloat(/displacement([\d.e-]+)/.exec(await text(page, "pick"))[1]);
  await page.waitForTimeout(300);
  const pulled = await displacement();
  await shot(page, "drag");
  await page.mouse.up();
  await until("it is let go", async () => (await tag(page)) === "");
  await until("it goes back", async () => (await displacement()) < 0.7 * pulled);
  // The same with keys alone.
  await page.focus("#canvas");
  await page.keyboard.press("g");
  for (let i = 0; i < 4; ++i) await page.keyboard.press("ArrowUp");
  await until("a force by keys", async () => parseFloat(await tag(page)) > 0);
  await page.keyboard.press("g");
  await until("let go by key", async () => (await tag(page)) === "");
  noComplaints(page);
  await page.close();
  await server.end();
});

test("settings act, on every page, and layers show", async () => {
  const server = await serve("scene.json");
  const page = await open(server.address);
  const other = await open(server.address);
  await until("it has settled", async () => (await time(page)) > 0.4);
  assert.equal(await page.isVisible("#structure"), false, "what developers look at is closed");
  for (const id of ["settings", "developer"]) await openSection(page, id);
  await page.selectOption("#structure", "hash");
  await until("the other page follows", async () => (await other.inputValue("#structure")) === "hash");
  await page.fill("#gravity", "0");
  await until("gravity on the other page", async () => (await other.inputValue("#gravity")) === "0");
  await page.selectOption("#cells_per_primitive-word", "number");
  await until("cells per primitive", async () => (await other.inputValue("#cells_per_primitive-word")) === "number");
  const running = await time(page);
  await until("it runs on", async () => (await time(page)) > running);
  await page.click("text=Restore");
  await until("as in the scene", async () => (await other.inputValue("#structure")) === "compact" &&
    (await other.inputValue("#cells_per_primitive-word")) === "exact");
  for (const id of ["show-arrows", "show-borders", "show-cells"]) await page.check(`#${id}`);
  await page.selectOption("#colouring", "depth");
  await until("the legend shows", () => page.isVisible("#legend"));
  await until("cells are counted", async () => (await text(page, "counts")).includes("cells in use"));
  await shot(page, "layers");
  await page.focus("#canvas");
  await page.keyboard.press("3");
  await until("displacement", async () => (await text(page, "legend-title")).startsWith("Displacement (mm)"));
  await page.check("#cut");
  await page.locator("#fade-all").fill("60");
  await page.waitForTimeout(200);
  await page.keyboard.press("t");
  await shot(page, "cut");
  noComplaints(page);
  noComplaints(other);
  await page.close();
  await other.close();
  await server.end();
});

test("an odd number of crossings is drawn", async () => {
  const server = await serve("pricked.json", { flags: ["--paused"] });
  const page = await open(server.address, {}, () => {
    const real = window.requestAnimationFrame.bind(window);
    window.requestAnimationFrame = (draw) => real(function later(now) { window.held ? real(later) : draw(now); });
  });
  const counted = (what, number) => async () => new RegExp(`${what}\\s*${number}(?!\\d)`).test(await text(page, "counts"));
  await until("three crossings", counted("crossings", 3));
  // Nothing is drawn until they have arrived, as on a busy machine.
  await page.evaluate(() => (window.held = true));
  await openSection(page, "developer");
  await page.check("#show-borders");
  await page.waitForTimeout(500);
  await page.evaluate(() => (window.held = false));
  await page.waitForTimeout(500);
  await shot(page, "crossings");
  noComplaints(page);
  await page.close();
  await server.end();
});

test("a body with a prescribed motion follows the hand", async () => {
  const server = await serve("scene.json", { flags: ["--speed", "max"] });
  const page = await open(server.address);
  await page.locator("#motion-0").fill("100");
  const run = page.locator("text=Follow its path");
  await until("it is held", () => run.isEnabled());
  await run.click();
  await until("it is let run", () => run.isDisabled());
  noComplaints(page);
  await page.close();
  await server.end();
});

test("finds the server again after a restart", async () => {
  const environment = { PALPATE_VIEW_TOKEN: "a-token-for-this-test" };
  let server = await serve("scene.json", { environment });
  const page = await open(server.address);
  await until("it plays", async () => (await time(page)) > 0.05);
  await page.selectOption("#colouring", "depth");
  await page.check("#cut");
  await page.uncheck(".body:has-text('upper') input[type=checkbox]");
  await server.end();
  await until("it says so", () => page.isVisible("#notice"));
  server = await serve("scene.json", { environment, flags: ["--port", String(server.port), "--paused"] });
  await until("it shows the new run", async () => (await time(page)) === 0);
  await page.click("#play");
  await until("it plays again", async () => (await time(page)) > 0.02);
  assert.equal(await page.isVisible("#notice"), false);
  assert.equal(await page.inputValue("#colouring"), "depth", "what the user has chosen stays");
  assert.equal(await page.isChecked("#cut"), true);
  assert.equal(await page.isChecked(".body:has-text('upper') input[type=checkbox]"), false);
  const own = page.complaints.filter((c) => !/WebSocket connection|ERR_CONNECTION_REFUSED/.test(c));
  assert.deepEqual(own, [], "the browser itself reports the connections that failed; nothing else may");
  await page.close();
  await server.end();
});

test("replays stored results, with a slider, and exports", async () => {
  const ran = spawnSync(command, ["run", "scene.json", "--out", "results", "--no-picture", "--quiet", "--set", 'output.fields=["von_mises", "contact_pressure", "stress", "deformation_gradient", "principal_directions"]'], { cwd: folder });
  assert.equal(ran.status, 0, String(ran.stderr));
  const server = await serve("results", { flags: ["--paused"] });
  const page = await open(server.address);
  assert.equal(await text(page, "frame-number"), "1 of 21");
  await page.fill("#seek", "12");
  await until("the frame is shown", async () => (await text(page, "frame-number")) === "13 of 21");
  assert.ok(Math.abs((await time(page)) - 0.24) < 1e-9);
  await page.click("#canvas", { position: { x: 5, y: 5 } });
  await page.keyboard.press("b");
  await until("a frame back", async () => (await text(page, "frame-number")) === "12 of 21");
  // Fields of the frames, and the forces of the run.
  const offered = await page.$$eval("#colouring option", (options) => options.map((o) => o.value));
  const of = (field, components) => components.map((component) => `${field}_${component}`);
  const tensor = ["xx", "xy", "xz", "yx", "yy", "yz", "zx", "zy", "zz"];
  const directions = ["1x", "1y", "1z", "2x", "2y", "2z", "3x", "3y", "3z"];
  assert.deepEqual([...offered].sort(), ["body", "contact_pressure", ...of("deformation_gradient", tensor), "depth", "displacement",
    ...of("principal_directions", directions), ...of("stress", ["xx", "xy", "xz", "yy", "yz", "zz"]), "von_mises"], "each a number");
  const groups = await page.$$eval("#colouring optgroup", (all) => all.map((group) => `${group.label}: ${group.children.length}`));
  assert.deepEqual(groups, ["stress: 6", "deformation gradient: 9", "principal directions: 9"]);
  await page.selectOption("#colouring", "deformation_gradient_zz");
  await until("a scale without a unit", async () => (await text(page, "legend-title")) === "Deformation gradient zz");
  await until("about 1", async () => {
    const ends = (await page.locator("#legend-ticks span").allTextContents()).map(parseFloat);
    return ends[0] === 0 && ends[2] >= 1 && ends[2] <= 2;
  });
  await page.selectOption("#colouring", "principal_directions_1z");
  await until("components of a unit vector", async () => {
    const ends = (await page.locator("#legend-ticks span").allTextContents()).map(parseFloat);
    return ends[0] >= -1 && ends[0] < 0 && ends[2] <= 1 && ends[2] > 0;
  });
  await page.selectOption("#colouring", "stress_zz");
  await until("a scale of one component", async () => /^Stress zz \((k|M|m|µ)?Pa\)$/.test(await text(page, "legend-title")));
  await until("compression is negative", async () => parseFloat((await page.locator("#legend-ticks span").first().textContent()) ?? "0") < 0);
  await page.selectOption("#colouring", "von_mises");
  await until("a scale of stress", async () => /stress \((k|M|m|µ)?Pa\)/i.test(await text(page, "legend-title")));
  await page.click("#forces summary");
  const ink = () => page.evaluate(() => {
    const canvas = document.getElementById("force-chart");
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    return data.reduce((sum, value, i) => sum + (i % 4 === 3 && value > 0 ? 1 : 0), 0);
  });
  await until("a chart of the run", async () => (await ink()) > 500);
  await page.selectOption("#colouring", "body");
  const [picture] = await Promise.all([page.waitForEvent("download"), page.click("#picture")]);
  assert.equal(picture.suggestedFilename(), "two boxes.png");
  const png = readFileSync(await picture.path());
  assert.equal(png.subarray(1, 4).toString(), "PNG");
  await page.click("#video");
  await page.click("#play");
  await until("the end", async () => (await text(page, "frame-number")) === "21 of 21");
  await page.waitForTimeout(1500);
  const [video] = await Promise.all([page.waitForEvent("download"), page.click("#video")]);
  assert.equal(video.suggestedFilename(), "two boxes.webm");
  assert.equal(readFileSync(await video.path()).subarray(0, 4).toString("hex"), "1a45dfa3", "EBML, which WebM begins with");
  assert.ok(statSync(await video.path()).size > 1000);
  await shot(page, "replay");
  noComplaints(page);
  await page.close();
  await server.end();
});

test("fits a small window and works by keys", async () => {
  const server = await serve("scene.json");
  const page = await open(server.address, { viewport: { width: 380, height: 640 } });
  assert.equal(await page.isVisible("#panel"), false, "the panel waits until it is asked for");
  await page.click("#panel-toggle");
  assert.equal(await page.isVisible("#panel"), true);
  const wide = await page.evaluate(() => document.documentElement.scrollWidth > innerWidth);
  assert.equal(wide, false, "nothing is wider than the window");
  await shot(page, "small");
  await page.keyboard.press("?");
  assert.equal(await page.isVisible("#keys"), true);
  await page.keyboard.press("Escape");
  // Everything that can be clicked can be reached with Tab, and has a name.
  const nameless = await page.evaluate(() =>
    [...document.querySelectorAll("button, input, select, summary")]
      .filter((e) => !(e.textContent.trim() || e.getAttribute("aria-label") || e.closest("label")?.textContent.trim() || e.labels?.length))
      .map((e) => e.outerHTML));
  assert.deepEqual(nameless, []);
  noComplaints(page);
  await page.close();
  await server.end();
});

test("begins with a named view, names bodies under the mouse, shows sides and a scale", async () => {
  const server = await serve("patient.json", { flags: ["--paused"] });
  const page = await open(server.address);
  assert.equal(await page.inputValue("#scene-view"), "lower-half", "the first that shows bodies as they are");
  assert.equal(await page.isChecked("#cut"), true);
  assert.equal(await page.isChecked("text=upper >> xpath=.. >> input[type=checkbox]"), false);
  const sections = await page.locator("#panel summary").allTextContents();
  assert.deepEqual(sections.map((name) => name.replace(/ \(.*/, "")), ["Bodies", "Cut", "Colours", "Touch", "Motion", "Forces", "Settings", "Developer"]);
  assert.equal(await page.getAttribute("#triad", "aria-label"), "Orientation of the axes: x left, y posterior, z superior");
  assert.match(await text(page, "scale-bar"), /^(1|2|5)0* mm$/);
  const { x, y } = await middle(page);
  await page.mouse.move(x, y);
  await until("a name by the mouse", async () => (await page.isVisible("#hover")) && (await text(page, "hover")) === "lower");
  await page.mouse.move(4, 200);
  await page.mouse.move(6, 210);
  await until("no name beside the bodies", async () => !(await page.isVisible("#hover")));
  // The search under the mouse has a pause after each, so a name is shown at once only after that.
  const named = await page.evaluate(async ([x, y]) => {
    const move = (clientX, clientY) =>
      document.querySelector("#canvas").dispatchEvent(new PointerEvent("pointermove", { clientX, clientY, pointerType: "mouse", isPrimary: true, bubbles: true }));
    for (let tries = 0; tries < 100; ++tries) {
      await new Promise((resolve) => setTimeout(resolve, 100));
      move(x, y);
      const shown = !document.querySelector("#hover").hidden;
      move(6, 210);
      if (shown) return true;
    }
    return false;
  }, [x, y]);
  assert.ok(named);
  await until("no name after a fast mouse either", async () => !(await page.isVisible("#hover")));
  await shot(page, "named-view");
  noComplaints(page);
  await page.close();
  await server.end();
});

test("marks the picked point, and shows arrows of contacts of seen bodies alone", async () => {
  const server = await serve("scene.json");
  const page = await open(server.address);
  await until("it has settled", async () => (await time(page)) > 0.5);
  await page.click("#play");
  const marker = [213, 94, 0];
  const fade = async (opacity) => {
    for (const body of ["lower", "upper"]) await page.locator(`.body:has-text("${body}") input[type=range]`).fill(opacity);
  };
  await fade("0.3");
  assert.equal(await hasColour(page, arrow), false);
  assert.equal(await page.isVisible("#arrows-hint"), false);
  await page.check("#show-arrows");
  assert.match(await text(page, "arrows-hint"), /cut or faded/);
  await until("an arrow", () => hasColour(page, arrow));
  const through = (await patch(page, arrow)).count;
  await fade("1");
  const outside = (await patch(page, arrow)).count;
  assert.ok(outside < 0.4 * through, `bodies that are not faded cover arrows: ${outside} pixels, ${through} before`);
  await fade("0.3");
  await page.selectOption("#colouring", "displacement");
  assert.ok((await patch(page, arrow)).count > 0.5 * through, "whatever colours show, arrows have their own");
  await page.selectOption("#colouring", "body");
  for (const body of ["lower", "upper"]) await page.uncheck(`.body:has-text("${body}") input[type=checkbox]`);
  await until("no arrow floats where no body is seen", async () => !(await hasColour(page, arrow)));
  await page.check(`.body:has-text("lower") input[type=checkbox]`);
  await page.uncheck("#show-arrows");
  await page.locator(".body:has-text('lower') input[type=range]").fill("1");
  assert.equal(await hasColour(page, marker), false);
  const { x, y } = await middle(page);
  await page.mouse.click(x, y + 20);
  await until("a marker", () => hasColour(page, marker));
  await shot(page, "marker");
  await page.focus("#canvas");
  for (let i = 0; i < 31; ++i) await page.keyboard.press("ArrowLeft");
  await shot(page, "marker-behind");
  assert.equal(await hasColour(page, marker), false, "from behind, the body covers it");
  noComplaints(page);
  await page.close();
  await server.end();
});

test("shows arrows of contacts of edges", async () => {
  // Two bars of one cell that cross: no point is in the other.
  const bar = (name, size, translate) => ({ name, box: { cells: [1, 1, 1], size }, translate });
  write("bars.json", { name: "bars", gravity: [0, 0, 0], bodies: [
    { ...bar("lower", [0.2, 0.02, 0.02], [0, 0, 0]), obstacle: true }, { ...bar("upper", [0.02, 0.2, 0.02], [0.003, 0.001, 0.019]), material }] });
  const server = await serve("bars.json", { flags: ["--paused"] });
  const page = await open(server.address);
  assert.match(await text(page, "counts"), /contacts0/);
  await page.locator("#fade-all").fill("60");
  assert.equal(await hasColour(page, arrow), false);
  await page.check("#show-arrows");
  await until("an arrow", () => hasColour(page, arrow));
  await shot(page, "edge-arrows");
  await page.uncheck(".body:has-text('lower') input[type=checkbox]");
  await until("none where a body is hidden", async () => !(await hasColour(page, arrow)));
  noComplaints(page);
  await page.close();
  await server.end();
});

test("the scale of colours is automatic, fixed or reset; a view fixes it; fields have units", async () => {
  const server = await serve("patient.json");
  const page = await open(server.address);
  await page.selectOption("#scene-view", "moved");
  assert.equal(await page.inputValue("#scale-kind"), "fixed");
  assert.equal(await page.inputValue("#scale-most"), "4");
  await until("the legend ends there", async () => (await text(page, "legend-ticks")) === "024");
  await page.fill("#scale-most", "10");
  await page.keyboard.press("Tab");
  assert.equal(await text(page, "legend-ticks"), "0510");
  await page.click("#scale-reset");
  assert.equal(await page.inputValue("#scale-kind"), "automatic");
  await until("it has moved", async () => (await time(page)) > 0.5);
  await page.selectOption("#colouring", "von_mises");
  await until("stress in a unit people read", async () => /^Von Mises stress \((m|k|M)?Pa\)$/.test(await text(page, "legend-title")));
  await until("its scale has an end", async () => parseFloat((await page.locator("#legend-ticks span").last().textContent()) ?? "0") > 0);
  await shot(page, "stress");
  noComplaints(page);
  await page.close();
  await server.end();
});

test("tells the force of contacts and of the motor of a prescribed body, in newtons, also in a chart", async () => {
  const server = await serve("patient.json");
  const page = await open(server.address);
  await page.selectOption("#scene-view", "everything");
  await until("it has settled", async () => (await time(page)) > 0.6);
  await openSection(page, "forces");
  await page.locator("#force-chart").scrollIntoViewIfNeeded();
  const { x, y } = await middle(page);
  await page.mouse.move(x, y);
  await until("the wrench under the mouse", async () => /contacts: .* [mµn]?N, .* [mµn]?N m$/.test(await text(page, "hover")));
  await page.waitForTimeout(500);
  await page.locator("#motion-0").fill("100");
  await until("what the motor gives", async () => /N$/.test(await tag(page)));
  await shot(page, "forces");
  noComplaints(page);
  await page.close();
  await server.end();
});

test("a pull is no harder than the tissue can take, and the page says so", async () => {
  const server = await serve("glued.json");
  const page = await open(server.address);
  await until("it has settled", async () => (await time(page)) > 0.3);
  const { x, y } = await middle(page);
  await page.mouse.move(x, y);
  await page.mouse.down();
  await page.mouse.move(x + 300, y - 250, { steps: 3 });
  await until("it says so", async () => (await tag(page)).includes("the most this tissue can take"));
  await shot(page, "limited");
  await page.mouse.up();
  noComplaints(page);
  await page.close();
  await server.end();
});

test("a slow machine draws half the pixels along each side while the picture moves, and all when it stands still", async () => {
  const server = await serve("glued.json", { flags: ["--paused"] });
  const page = await open(server.address, {}, () => {
    const real = window.requestAnimationFrame.bind(window);
    window.requestAnimationFrame = (draw) => real((now) => {
      draw(now);
      if (!window.slow) return;
      for (const end = performance.now() + 60; performance.now() < end;);
    });
  });
  await page.waitForTimeout(1000);
  const width = () => page.evaluate(() => document.getElementById("canvas").width);
  const full = await width();
  assert.equal(full, await page.evaluate(() => document.getElementById("canvas").clientWidth));
  await page.evaluate(() => (window.slow = true));
  await page.focus("#canvas");
  await until("half of the pixels", async () => {
    await page.keyboard.press("ArrowLeft");
    return (await width()) === Math.floor(full / 2);
  });
  await until("all of them", async () => (await width()) === full);
  noComplaints(page);
  await page.close();
  await server.end();
});
