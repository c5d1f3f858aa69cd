// Tests pages of the site in a headless Chromium: node browser.mjs SITE SCREENSHOTS [AXE]
//
// AXE is the file axe.min.js of axe-core. If it is given, every page is also checked with it in light and dark mode. Exits
// with status 1 and prints the failed checks if there are any.
import assert from "node:assert/strict";
import { existsSync, readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { pathToFileURL } from "node:url";

import { browser } from "../webdriver.mjs";

const [site, screenshots, axe] = process.argv.slice(2);

// One page of every kind.
const PAGES = ["index.html", "format/index.html", "format/2.4.html", "format/2.9.8.html", "cases/index.html", "cases/hand-rgb-blocks.html",
  "misreadings/index.html", "misreadings/big-endian-index.html", "misreadings/v-negated.html", "rulings/motion-half.html", "codes/PTM-E010.html", "readers/cceh-rti.html",
  "scoreboard.html", "texture/index.html", "texture/cases.html", "glossary.html", "docs/index.html", "docs/check.html", "drop.html"].filter((page) => existsSync(join(site, page)));
const WIDTHS = [390, 768, 1280];

const { call, run, close } = await browser();
try {
  const cdp = (cmd, params) => call("POST", "/goog/cdp/execute", { cmd, params });
  const log = (type) => call("POST", "/se/log", { type });
  const open = (page) => call("POST", "/url", { url: pathToFileURL(join(site, page)).href });
  const setColorScheme = (value) => cdp("Emulation.setEmulatedMedia", { features: [{ name: "prefers-color-scheme", value }] });
  const until = async (what, script) => {
    for (let i = 0; i < 100; i += 1) { if (await run(script)) { return; } await new Promise((resolve) => setTimeout(resolve, 50)); }
    assert.fail(`timed out waiting for ${what}`);
  };

  for (const page of PAGES) {
    for (const scheme of axe ? ["light", "dark"] : ["light"]) {
      await setColorScheme(scheme);
      await open(page);
      assert.ok(await run("return document.querySelectorAll('main').length === 1 && document.querySelectorAll('h1').length === 1"), `${page} has one main and one h1`);
      assert.equal(await run("return [...document.images].filter((i) => !i.alt).length"), 0, `${page}: an image has no alternative text`);
      if (axe) {
        await run(readFileSync(axe, "utf8"));
        const found = await call("POST", "/execute/async", { script: "const done = arguments[0]; axe.run().then((r) => done(r.violations.map((v) => [v.id, v.nodes.length, v.nodes[0].html.slice(0, 160), v.nodes[0].any[0]?.message ?? ''])));", args: [] });
        assert.deepEqual(found, [], `${page}, ${scheme}: axe`);
      }
    }
    await setColorScheme("light");
    // Pages fit the window at every width.
    for (const width of WIDTHS) {
      await cdp("Emulation.setDeviceMetricsOverride", { width, height: 1000, deviceScaleFactor: 1, mobile: false });
      const excess = await run("return document.documentElement.scrollWidth - innerWidth");
      if (screenshots && axe) {
        writeFileSync(join(screenshots, `${page.replaceAll("/", "-")}-${width}.png`), Buffer.from(await call("GET", "/screenshot"), "base64"));
      }
      assert.ok(excess <= 0, `${page} at ${width}: ${excess} pixels too wide`);
      // Text and tables have the width of the page. The scoreboard may be wider.
      const [main, ...parts] = await run("return [document.querySelector('main'), ...document.querySelectorAll('main > p, main > .scroll:not(.wide)')].map((e) => e.getBoundingClientRect().width)");
      assert.ok(parts.every((part) => Math.abs(part - main) < 1), `${page} at ${width}: ${main}, ${parts}`);
    }
    await cdp("Emulation.clearDeviceMetricsOverride", {});
  }

  // The search box finds ids and words.
  await open("format/2.4.html");
  await run("const s = document.getElementById('search'); s.focus(); s.value = 'lut-count'; s.dispatchEvent(new Event('input'))");
  await until("a search result", "return document.querySelector('#hits a b')?.textContent === 'lut-count'");
  assert.equal(await run("return document.querySelector('#hits a').getAttribute('href')"), "../rulings/lut-count.html");
  const filter = (text) => run("const f = document.getElementById('list-filter'); f.value = arguments[0]; f.dispatchEvent(new Event('input'))", text);
  // The filter of a list is part of the URL, and the URL sets the filter.
  await open("scoreboard.html");
  const all = await run("return document.querySelectorAll('tbody tr:not([hidden])').length");
  await run("document.getElementById('differing').click()");
  const differing = await run("return document.querySelectorAll('tbody tr:not([hidden])').length");
  assert.ok(differing > 0 && differing < all, `${differing} of ${all} clauses differ`);
  await filter("2.8");
  assert.equal(await run("return location.search"), "?2.8");

  // The filter of the cases opens the groups with cases that match.
  await open("cases/index.html");
  await filter("2.4/8");
  const opened = await run("return [...document.querySelectorAll('.gallery details:not([hidden])')].map((e) => e.open && !!e.querySelector('li:not([hidden])'))");
  assert.ok(opened.length > 1 && opened.every(Boolean), `${opened}`);
  await filter("");
  assert.equal(await run("return document.querySelectorAll('.gallery details[open], .gallery [hidden]').length"), 0);
  // The dial moves the light in both images. A negated v is invisible under a light from above.
  await open("misreadings/v-negated.html");
  await until("two images", "return document.querySelectorAll('.object canvas').length === 2");
  const images = async () => {
    const canvases = await call("POST", "/elements", { using: "css selector", value: ".object canvas" });
    const taken = [];
    for (const canvas of canvases) { taken.push(await call("GET", `/element/${Object.values(canvas)[0]}/screenshot`)); }
    return taken;
  };
  const before = await images();
  await run("document.querySelector('.dial').dispatchEvent(new KeyboardEvent('keydown', { key: 'Home' }))");
  await until("the light", "return document.querySelector('.object output').textContent === 'u 0.00, v 0.00'");
  const after = await images();
  assert.notEqual(before[0], before[1]);
  assert.equal(after[0], after[1], "a mistake in v is visible under a light from above");
  assert.ok(after.every((image, i) => image !== before[i]));

  const errors = (await log("browser")).map((entry) => entry.message);
  assert.deepEqual(errors, [], "messages on the console");
  const requests = (await log("performance")).map((entry) => JSON.parse(entry.message).message)
    .filter(({ method, params }) => method === "Network.requestWillBeSent" && params.documentURL.startsWith("file:")).map(({ params }) => params.request.url)
    .filter((url) => !/^(file|data|blob):/.test(url));
  assert.deepEqual(requests, [], "network requests");
  console.log(`${PAGES.length} pages`);
} catch (error) {
  console.log(String(error.stack ?? error));
  process.exitCode = 1;
} finally {
  await close();
}
