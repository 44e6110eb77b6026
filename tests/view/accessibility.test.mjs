// Accessibility of the page by axe, with a running simulation and with stored results, in a headless browser.
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import { root } from "../browser.mjs";
import { command, folder, open, serve, until } from "./page_support.mjs";

const axe = readFileSync(join(root, "viewer/node_modules/axe-core/axe.min.js"), "utf8");

/** What is wrong on the page as it is now: rule and element. */
async function violations(page) {
  await page.evaluate(axe);
  const found = await page.evaluate(() => window.axe.run());
  return found.violations.map((v) => [v.id, v.nodes[0].html]);
}

/** The page with everything open that it has, wide and narrow, light and dark. */
async function look(server) {
  for (const size of [{ width: 1440, height: 900 }, { width: 390, height: 844 }]) {
    for (const colorScheme of ["light", "dark"]) {
      const page = await open(server.address, { viewport: size, colorScheme, bypassCSP: true });
      if (!(await page.isVisible("#panel"))) await page.click("#panel-toggle");
      await page.evaluate(() => document.querySelectorAll("details").forEach((section) => (section.open = true)));
      await page.selectOption("#colouring", "von_mises");
      assert.deepEqual(await violations(page), [], `${size.width} wide, ${colorScheme}`);
      await page.close();
    }
  }
}

test("axe finds nothing while a scene runs", async () => {
  const server = await serve("patient.json", { flags: ["--paused"] });
  await look(server);
  await server.end();
});

test("axe finds nothing on stored results, with slider, fields and chart", async () => {
  const fields = 'output.fields=["von_mises", "contact_pressure"]';
  const ran = spawnSync(command, ["run", "patient.json", "--out", "stored", "--steps", "10", "--no-picture", "--quiet", "--set", fields], { cwd: folder });
  assert.equal(ran.status, 0, String(ran.stderr));
  const server = await serve("stored", { flags: ["--paused"] });
  const page = await open(server.address);
  assert.equal(await page.isVisible("#seek"), true);
  await page.close();
  await look(server);
  await server.end();
});

test("axe sees a control without a name", async () => {
  const server = await serve("patient.json", { flags: ["--paused"] });
  const page = await open(server.address, { bypassCSP: true });
  await page.evaluate(() => document.body.append(document.createElement("select")));
  await until("it is there", () => page.locator("body > select").isVisible());
  assert.ok((await violations(page)).some(([rule]) => rule === "select-name"));
  await page.close();
  await server.end();
});
