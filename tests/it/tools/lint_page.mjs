// Tests the page of `lint --format html` in a headless Chromium: node lint_page.mjs PAGE FILES SCREENSHOT
//
// FILES is the number of files on the page; every fourth is damaged. Exits with status 1 and prints the failed check, if any.
import assert from "node:assert/strict";
import { writeFileSync } from "node:fs";
import { pathToFileURL } from "node:url";

import { browser } from "../webdriver.mjs";

const [page, files, screenshot] = process.argv.slice(2);
const count = Number(files);
const { call, run, close } = await browser();
try {
  for (const width of [390, 1280]) {
    await call("POST", "/window/rect", { width, height: 900 });
    await call("POST", "/url", { url: pathToFileURL(page).href });
    assert.equal(await run("return document.querySelectorAll('article').length"), count);
    const overflow = () => run("return document.documentElement.scrollWidth > innerWidth");
    assert.equal(await overflow(), false, `the page scrolls sideways at ${width} pixels`);
    // Images outside the window are not loaded before they are needed.
    const broken = await run(`
      const images = [...document.querySelectorAll("article img")];
      for (const image of images) { image.loading = "eager"; }
      return Promise.all(images.map((image) => image.decode().then(() => image.naturalWidth > 0, () => false)))
        .then((good) => [good.length, good.filter((one) => !one).length]);`);
    assert.deepEqual(broken, [count * 3 / 4, 0]);
    const order = await run("return ['h1', 'header', 'form', 'article'].map((name) => document.querySelector(name).getBoundingClientRect().top)");
    assert.deepEqual(order, order.toSorted((a, b) => a - b), "the totals are above the files");
    writeFileSync(`${screenshot}-${width}.png`, Buffer.from(await call("GET", "/screenshot"), "base64"));

    const input = Object.values(await call("POST", "/element", { using: "css selector", value: "input" }))[0];
    const shown = async (text) => {
      await call("POST", `/element/${input}/clear`, {});
      await call("POST", `/element/${input}/value`, { text });
      const visible = await run("return [...document.querySelectorAll('article')].filter((one) => one.checkVisibility()).length");
      const [number] = (await run("return document.querySelector('output').textContent")).split(" ");
      assert.equal(Number(number), visible);
      return visible;
    };
    assert.equal(await shown("damaged"), count / 4);
    writeFileSync(`${screenshot}-${width}-damaged.png`, Buffer.from(await call("GET", "/screenshot"), "base64"));
    assert.equal(await overflow(), false, `the page scrolls sideways at ${width} pixels when it is filtered`);
    assert.equal(await shown("pTm-E070 damaged"), count / 4);
    assert.equal(await shown("no such text"), 0);
    assert.equal(await shown(" "), count);
    const press = (name) => run(`
      [...document.querySelectorAll("button")].find((one) => one.textContent === "${name}").click();
      return [...document.querySelectorAll("article")].filter((one) => one.checkVisibility()).length;`);
    assert.equal(await press("damaged"), count / 4);
    assert.equal(await press("sound"), count * 3 / 4);
    assert.equal(await overflow(), false, `the page scrolls sideways at ${width} pixels with buttons`);
    assert.equal(await press("all"), count);
  }
} finally {
  await close();
}
