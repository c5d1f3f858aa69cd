// Tests pages with a movable light in a headless Chromium: node relight.mjs PAGE EXPECTED SCREENSHOT …
//
// EXPECTED is the image under the light -0.35,0.4 as a PTM1 frame. Exits with status 1 and prints the failed check, if any.
import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";
import { pathToFileURL } from "node:url";

import { browser } from "../webdriver.mjs";

const { call, run, close } = await browser();
try {
  const keys = (...values) => call("POST", "/actions", { actions: [{ type: "key", id: "keys",
    actions: values.flatMap((value) => [{ type: "keyDown", value }, { type: "keyUp", value }]) }] });
  const wait = (ms) => new Promise((resolve) => setTimeout(resolve, ms));
  const shows = async (text) => {
    for (let i = 0; i < 100; i += 1) { if (await run("return document.querySelector('output').textContent") === text) { return; } await wait(20); }
    assert.fail(`the page never shows ${text}`);
  };
  for (const width of [390, 1280]) {
    await call("POST", "/window/rect", { width, height: 900 });
    for (let i = 2; i < process.argv.length; i += 3) {
      const [page, expected, screenshot] = process.argv.slice(i, i + 3);
      await call("POST", "/url", { url: pathToFileURL(page).href });
      await shows("u -0.40, v 0.40");
      await run("document.querySelector('#dial').focus()");
      await keys("\uE014"); // right arrow
      await shows("u -0.35, v 0.40");
      const frame = readFileSync(expected);
      const samples = frame.subarray(frame.indexOf("\n") + 1);
      const pixels = await run("const c = document.querySelector('canvas'); return [...c.getContext('2d').getImageData(0, 0, c.width, c.height).data].filter((_, i) => i % 4 < 3);");
      assert.equal(pixels.length, samples.length);
      const worst = Math.max(...pixels.map((value, j) => Math.abs(value - samples[j])));
      assert.ok(worst <= 1, `${page}: ${worst}`);
      assert.equal(await run("return document.documentElement.scrollWidth > innerWidth"), false, "the page scrolls sideways");
      writeFileSync(`${screenshot}-${width}.png`, Buffer.from(await call("GET", "/screenshot"), "base64"));
      await keys("\uE011"); // Home
      await shows("u 0.00, v 0.00");
      // A drag on the picture moves the light.
      const box = await run("const b = document.querySelector('canvas').getBoundingClientRect(); return [b.left, b.top, b.width, b.height];");
      const at = (x, y) => ({ type: "pointerMove", duration: 0, origin: "viewport", x: Math.round(box[0] + x * box[2]), y: Math.round(box[1] + y * box[3]) });
      await call("POST", "/actions", { actions: [{ type: "pointer", id: "finger", parameters: { pointerType: "touch" },
        actions: [at(0.5, 0.5), { type: "pointerDown", button: 0 }, at(0.75, 0.5), { type: "pointerUp", button: 0 }] }] });
      await wait(100);
      const text = await run("return document.querySelector('output').textContent");
      assert.match(text, /^u 0\.[45]\d, v -?0\.0\d$/);
      const [u] = text.match(/-?\d\.\d+/g).map(Number);
      assert.ok(Math.abs(u - 0.5) < 0.1, text);
    }
  }
} finally {
  await close();
}
