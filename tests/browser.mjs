// The headless browser of the page's tests: Debian's chromium, driven by playwright.
import { existsSync } from "node:fs";
import { createRequire } from "node:module";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

export const root = join(dirname(fileURLToPath(import.meta.url)), "..");

/** Ends the program as ctest's SKIP_RETURN_CODE asks. */
export function skip(why) {
  console.log(`skipped: ${why}`);
  process.exit(77);
}

const executablePath = ["chromium", "chromium-browser", "google-chrome"]
  .flatMap((name) => process.env.PATH.split(":").map((place) => join(place, name)))
  .find(existsSync);
if (!existsSync(join(root, "viewer/node_modules/playwright-core"))) skip("the packages of viewer/ are not installed (npm ci)");
if (!executablePath) skip("there is no chromium (apt-get install chromium)");
const { chromium } = createRequire(join(root, "viewer/package.json"))("playwright-core");

/** Flags for pages that draw with WebGL, on machines without a GPU. */
export const webgl = ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-gpu-watchdog"];

export function launch(flags = []) {
  return chromium.launch({ executablePath, args: ["--no-sandbox", "--disable-dev-shm-usage", ...flags] });
}
