// Stages on the page of `palpate view`: bodies that come and go, the name of the stage, the slider of a motion.
import assert from "node:assert/strict";
import { test } from "node:test";
import { material, noComplaints, open, patch, serve, shot, text, until, write } from "./page_support.mjs";

const red = [0.9, 0.05, 0.05];
const isRed = (r, g, b) => r > 90 && g < 0.45 * r && b < 0.45 * r;
write("staged.json", {
  name: "staged", time_step: 0.01,
  bodies: [
    { name: "plate", box: { cells: [2, 2, 1], size: [0.3, 0.3, 0.02] }, translate: [0, 0, -0.01], obstacle: true },
    { name: "box", box: { cells: [3, 3, 3], size: [0.1, 0.1, 0.1] }, translate: [-0.06, 0, 0.0505], material },
    { name: "tool", box: { cells: [1, 1, 1], size: [0.1, 0.1, 0.1] }, translate: [0.06, 0, 0.08], obstacle: true, absent: true, color: red },
  ],
  stages: [
    { name: "alone", until: { time: 0.03 } },
    { name: "enter", insert: ["tool"], until: { time: 0.05 },
      move: [{ body: "tool", motion: { keyframes: [{ time: 0.05, translate: [0, 0, -0.005] }] } }] },
    { name: "leave", remove: ["tool"], until: { time: 0.03 } },
  ],
});

test("bodies come and go with their stage", async () => {
  const server = await serve("staged.json", { flags: ["--paused"] });
  const page = await open(server.address);
  const clock = () => text(page, "clock");
  const steps = async (count, last) => {
    for (let i = 0; i < count; ++i) await page.keyboard.press("n");
    await until(`step ${last}`, async () => (await clock()).includes(`step ${last},`));
  };
  assert.match(await clock(), /stage alone \(1 of 3\)/);
  assert.ok((await patch(page, isRed)).count < 100, "the tool is not there yet: an axis of the triad is red too");
  assert.equal(await page.locator("#motion-0").isVisible(), false, "nothing moves it");
  assert.ok((await text(page, "panel")).includes("tool (absent)"));
  await steps(3, 3);
  assert.match(await clock(), /stage enter \(2 of 3\)/);
  const { count, x, y } = await patch(page, isRed);
  assert.ok(count > 500, `the tool is shown: ${count} pixels`);
  await shot(page, "stage-enter");
  assert.equal(await page.locator("#motion-0").isVisible(), true);
  assert.equal(await page.locator("#motion-0").getAttribute("aria-valuetext"), "0.03 s", "times of the run");
  const box = await page.locator("#canvas").boundingBox();
  await page.mouse.move(box.x + x, box.y + y);
  await page.mouse.down();
  await page.mouse.move(box.x + x + 40, box.y + y, { steps: 4 });
  await steps(1, 4);
  const { x: moved } = await patch(page, isRed);
  assert.ok(moved > x + 1, `it follows the mouse: ${x} to ${moved}`);
  await page.mouse.up();
  await page.click("text=Follow its path");
  await steps(4, 8);
  assert.match(await clock(), /stage leave \(3 of 3\)/);
  assert.ok((await patch(page, isRed)).count < 100, "the tool is gone");
  assert.equal(await page.locator("#motion-0").isVisible(), false);
  await steps(3, 11);
  assert.match(await clock(), /all stages done/);
  await page.click("#reset");
  await until("the first stage again", async () => (await clock()).includes("stage alone"));
  assert.equal(await page.locator("#notice").isVisible(), false);
  noComplaints(page);
  await page.close();
  assert.equal(await server.end(), 0);
});
