// Tests report pages in a headless Chromium: node html_browser.mjs PAGE MATRIX SCREENSHOTS
//
// Exits with status 1 and prints the failed checks if there are any.
import assert from "node:assert/strict";
import { writeFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { pathToFileURL } from "node:url";

import { browser } from "../webdriver.mjs";

const [page, matrix, screenshots] = process.argv.slice(2);

const { call, run, close } = await browser();
try {
  const cdp = (cmd, params) => call("POST", "/goog/cdp/execute", { cmd, params });
  const log = (type) => call("POST", "/se/log", { type });
  const open = (file) => call("POST", "/url", { url: pathToFileURL(file).href });
  const wait = (ms) => new Promise((resolve) => setTimeout(resolve, ms));
  const until = async (what, script, ...args) => {
    for (let i = 0; i < 100; i += 1) { if (await run(script, ...args)) { return; } await wait(50); }
    assert.fail(`timed out waiting for ${what}`);
  };
  const screenshot = async (name) => writeFileSync(join(screenshots, name), Buffer.from(await call("GET", "/screenshot"), "base64"));
  const setColorScheme = (value) => cdp("Emulation.setEmulatedMedia", { features: [{ name: "prefers-color-scheme", value }] });
  const keys = (...values) => call("POST", "/actions", { actions: [{ type: "key", id: "keys",
    actions: values.flatMap((value) => [{ type: "keyDown", value }, { type: "keyUp", value }]) }] });
  // Drags from one position to another, both relative to the size of the element.
  const drag = async (css, [x0, y0], [x1, y1]) => {
    // Elements that were never rendered have no size yet, so scroll repeatedly.
    for (let i = 0; i < 3; i += 1) { await run("document.querySelector(arguments[0]).scrollIntoView({block: 'center', behavior: 'instant'})", css); await wait(100); }
    const box = await run("const e = document.querySelector(arguments[0]); const b = e.getBoundingClientRect(); return [b.left, b.top, b.width, b.height];", css);
    const at = (x, y) => ({ type: "pointerMove", duration: 0, origin: "viewport", x: Math.round(box[0] + x * box[2]), y: Math.round(box[1] + y * box[3]) });
    await call("POST", "/actions", { actions: [{ type: "pointer", id: "mouse", parameters: { pointerType: "mouse" },
      actions: [at(x0, y0), { type: "pointerDown", button: 0 }, at(x1, y1), { type: "pointerUp", button: 0 }] }] });
  };
  const pixels = (css) => run("return [...document.querySelectorAll(arguments[0])].map((c) => [...c.getContext('2d').getImageData(0, 0, c.width, c.height).data].join());", css);
  const colors = () => run("const s = getComputedStyle(document.body); return [s.backgroundColor, s.color];");
  // Contrast of text with its background according to WCAG 2.
  const contrasts = () => run(`
    const parse = (c) => (c.match(/[\\d.]+/g) || []).map(Number);
    const light = ([r, g, b]) => [r, g, b].map((v) => v / 255).map((v) => v <= .04045 ? v / 12.92 : ((v + .055) / 1.055) ** 2.4).reduce((sum, v, i) => sum + v * [.2126, .7152, .0722][i], 0);
    const behind = (e) => { for (; e; e = e.parentElement) { const c = parse(getComputedStyle(e).backgroundColor); if (c.length === 3 || c[3] > .99) return c; } return [255, 255, 255]; };
    const poor = [];
    for (const e of document.querySelectorAll("body *")) {
      if (![...e.childNodes].some((n) => n.nodeType === 3 && n.data.trim()) || !e.checkVisibility() || /^(SCRIPT|STYLE|OPTION|METER)$/.test(e.tagName)) continue;
      const style = getComputedStyle(e);
      const [a, b] = [light(parse(style.color)), light(behind(e))];
      const ratio = (Math.max(a, b) + .05) / (Math.min(a, b) + .05);
      if (ratio < 4.5) poor.push([e.tagName, e.className, e.textContent.slice(0, 30), ratio.toFixed(2)].join(" "));
    }
    return [...new Set(poor)].slice(0, 10);`);

  // 1. Light and dark mode, set by the system and by the button.
  await open(page);
  await setColorScheme("light");
  const light = await colors();
  assert.deepEqual(await contrasts(), [], "light: text too faint");
  await screenshot("report-light.png");
  await setColorScheme("dark");
  const dark = await colors();
  assert.notDeepEqual(light, dark, "dark and light mode differ");
  assert.deepEqual(await contrasts(), [], "dark: text too faint");
  await screenshot("report-dark.png");
  await run("document.getElementById('theme').click()");
  assert.deepEqual(await colors(), light, "the button overrules the system");
  assert.equal(await run("return document.getElementById('theme').getAttribute('aria-pressed')"), "false");
  await setColorScheme("light");

  // 2. Hostile output remains text.
  assert.match(await call("GET", "/title"), / — PTM 1\.2$/);
  assert.equal(await run("return document.scripts.length"), 1);
  assert.ok(await run("return document.querySelector('pre.stderr').textContent.includes('<script>')"));
  assert.equal(await run("return document.querySelectorAll('img[src=x]').length"), 0);

  // 3. Every image is valid and has alternative text.
  await run("document.getElementById('open').click()");
  await until("images", "return [...document.images].every((i) => i.complete)");
  const images = await run("return [...document.images].map((i) => [i.naturalWidth, i.alt])");
  assert.ok(images.length > 100, `${images.length} images`);
  assert.ok(images.every(([width, alt]) => width > 0 && alt));
  // The target of a link scrolls into view below the filter, even among hundreds of open cases.
  await run("[...document.querySelectorAll('article.cause a')].filter((a) => a.getAttribute('href').startsWith('#')).at(-1).click()");
  await wait(500);
  const [bottom, top] = await run("const t = document.getElementById(decodeURIComponent(location.hash.slice(1))); return [document.querySelector('.tools').getBoundingClientRect().bottom, t.getBoundingClientRect().top]");
  assert.ok(top >= bottom && top < 500, `filter ends at ${bottom}, target begins at ${top}`);
  await run("document.getElementById('close').click()");
  assert.equal(await run("return document.querySelectorAll('details.case[open]').length"), 0);

  // 4. Light: dragging changes both images, and each displays the polynomial under that light.
  const id = await run("const f = [...document.querySelectorAll('figure.preview[data-channels=\"9\"][data-kind=raw]')].sort((a, b) => Math.min(b.dataset.width, b.dataset.height) - Math.min(a.dataset.width, a.dataset.height))[0]; for (let e = f; e; e = e.parentElement) if (e.tagName === 'DETAILS') e.open = true; return f.closest('details.case').id");
  await until("the preview", "return document.querySelectorAll('#' + arguments[0] + ' canvas').length === 3", id);
  const before = await pixels(`#${id} canvas`);
  await drag(`#${id} canvas`, [0.5, 0.5], [0.35, 0.65]);
  const after = await pixels(`#${id} canvas`);
  assert.notEqual(before[0], after[0], "expected changes with the light");
  assert.notEqual(before[1], after[1], "received changes with the light");
  assert.notEqual(after[0], after[1], "wrong samples look different");
  await screenshot("report-preview.png");
  const [data, u, v] = await run("const f = document.querySelector('#' + arguments[0] + ' figure.preview'); const r = f.querySelectorAll('input'); return [{...f.dataset}, Number(r[0].value), Number(r[1].value)]", id);
  assert.ok(u < -0.1 && v < -0.1, `u ${u}, v ${v}`);
  // The slider moves in steps, and the image at a step is known.
  await run("const r = document.querySelectorAll('#' + arguments[0] + ' input'); r[0].value = 0.25; r[1].value = -0.5; r[1].dispatchEvent(new Event('input'))", id);
  const [shown] = await pixels(`#${id} canvas`);
  const raw = Buffer.from(data.expected, "base64");
  const [scale, bias] = [data.scale, data.bias].map((text) => text.split(" ").map(Number));
  const powers = [0.0625, 0.25, -0.125, 0.25, -0.5, 1];
  const computed = [];
  for (let at = 0; at < raw.length; at += 9) {
    const luminance = powers.reduce((sum, power, i) => sum + power * (raw[at + i] - bias[i]) * scale[i], 0);
    for (const channel of [6, 7, 8]) { computed.push(Math.min(255, Math.max(0, luminance * raw[at + channel] / 255))); }
    computed.push(255);
  }
  shown.split(",").forEach((value, i) => assert.ok(Math.abs(value - computed[i]) <= 1, `sample ${i}: ${value}, computed ${computed[i]}`));

  // 5. Keyboard operation of the sliders, the filter and a case.
  const previous = await pixels(`#${id} canvas`);
  await run("document.querySelector('#' + arguments[0] + ' input').focus()", id);
  await keys("\uE014", "\uE014", "\uE014");
  assert.notEqual((await pixels(`#${id} canvas`))[0], previous[0], "arrow keys move the light");
  await keys("/");
  assert.equal(await run("return document.activeElement.id"), "filter", "the slash key leaves a slider");
  await run("document.activeElement.blur(); scrollTo(0, document.body.scrollHeight)");
  await keys("/");
  assert.equal(await run("return document.activeElement.id"), "filter");
  const seen = () => run("const b = document.getElementById('filter').getBoundingClientRect(); return b.top >= 0 && b.bottom <= innerHeight");
  assert.ok(await seen(), "the filter comes into view");
  const folds = () => run("return [...document.querySelectorAll('details.more, details.others')].map((f) => f.open)");
  const folded = await folds();
  const visible = () => run("return [...document.querySelectorAll('details.case')].filter((c) => !c.hidden).length");
  const all = await visible();
  await keys(..."hand-");
  await until("the filter", "return / of /.test(document.getElementById('found').textContent)");
  const some = await visible();
  assert.ok(some > 0 && some < all, `${some} of ${all}`);
  await screenshot("report-filter.png");
  await keys(..."zzz");
  await until("the empty result", "return /^No case matches/.test(document.getElementById('found').textContent)");
  assert.ok(await seen(), "the filter stays in view");
  await keys("\uE00C");
  assert.equal(await visible(), all);
  assert.deepEqual(await folds(), folded, "the folds are unchanged");
  await run("const all = [...document.querySelectorAll('details.case:not([open]) > summary')]; const s = all.find(s => s.checkVisibility()); s.focus(); s.scrollIntoView()");
  await keys("\uE007");
  assert.ok(await run("return document.activeElement.parentElement.open"), "Enter opens a case");
  // Tab moves to a visible element.
  await keys("\uE004");
  assert.notEqual(await run("return getComputedStyle(document.activeElement).outlineStyle"), "none");

  // 6. A click on a clause filters the cases that test it.
  const clause = await run("const t = document.querySelector('button.tile[data-state=fail]'); t.focus(); return t.dataset.clause");
  await keys("\uE007");
  await until("the clause", "return document.getElementById('filter').value === arguments[0]", clause);
  const named = await run("return [...document.querySelectorAll('details.case')].filter((c) => !c.hidden).map((c) => c.querySelector('summary .clauses').textContent.split(' '))");
  assert.ok(named.length > 0 && named.every((clauses) => clauses.includes(clause)), clause);
  await run("document.getElementById('clauses').scrollIntoView({behavior: 'instant'})");
  await screenshot("report-clauses.png");

  // The filter is part of the URL, all counts reflect it, and the URL sets it.
  assert.equal(await run("return decodeURIComponent(location.hash)"), `#filter=${clause}`);
  const counted = () => run("return [...document.querySelectorAll('button.chip .count')].map((c) => c.textContent)");
  assert.ok((await counted()).some((count) => / of /.test(count)), "the counts follow the filter");
  const groups = await run("return [...document.querySelectorAll('section.group:not([hidden])')].map((g) => [g.querySelector('h3 .count').textContent.split(' ')[0], String(g.querySelectorAll('details.case:not([hidden])').length)])");
  assert.ok(groups.length > 0 && groups.every(([says, shown]) => says === shown), JSON.stringify(groups));
  await run("document.querySelector('button.chip[data-outcome=pass]').click()");
  assert.equal(await run("return document.getElementById('filter').value"), `${clause} is:pass`);
  assert.equal(await visible(), 0, "a passing case has no card");
  await open(page);
  await run("location.hash = '#filter=is%3Afail'");
  await until("the filter of the address", "return document.getElementById('filter').value === 'is:fail'");
  assert.equal(await visible(), all);
  assert.equal(await run("return document.querySelector('button.chip[data-outcome=fail]').getAttribute('aria-pressed')"), "true");

  // The divider between expected and received moves, and a command is copied or selected.
  await open(page);
  const divider = () => run("return document.querySelector('.scene .slide').style.getPropertyValue('--at')");
  await drag(".scene .slide", [0.5, 0.5], [0.2, 0.5]);
  const moved = Number.parseFloat(await divider());
  assert.ok(moved > 15 && moved < 25, `the divider is at ${moved} percent`);
  assert.match(await run("return document.querySelector('.scene figcaption').textContent"), /^The image is |^Red and |^Rows and |^This decoder /);
  await run("document.querySelector('details.case button.copy').click()");
  await until("copied", "return /^Copied|^Selected/.test(document.querySelector('details.case button.copy').textContent)");
  assert.match(await run("return document.querySelector('details.case pre.command').textContent"), /^ptm-conform check --case \S+ -- decoder/);
  const download = await run("const a = document.querySelector('details.case a[download]'); return [a.download, a.href.slice(0, 5)]");
  assert.match(download[0], /\.ptm$/);
  assert.equal(download[1], "data:");

  // 7. Every form field and button has an accessible name.
  const nameless = await run("return [...document.querySelectorAll('button, input, [role=img]')].filter((e) => !(e.textContent.trim() || e.getAttribute('aria-label') || e.labels?.length)).map((e) => e.outerHTML)");
  assert.deepEqual(nameless, []);

  // 8. Narrow windows and printing.
  for (const width of [1280, 768, 390]) {
    await cdp("Emulation.setDeviceMetricsOverride", { width, height: 844, deviceScaleFactor: 1, mobile: true });
    await open(page);
    assert.ok(await run("return document.documentElement.scrollWidth <= innerWidth + 1"), `the page does not scroll sideways at ${width} pixels`);
  }
  await screenshot("report-narrow.png");
  await cdp("Emulation.clearDeviceMetricsOverride", {});
  await run("window.folded = 0; addEventListener('beforeprint', () => { window.folded = document.querySelectorAll('details:not([open])').length; })");
  await run("dispatchEvent(new Event('beforeprint')); dispatchEvent(new Event('afterprint'))");
  assert.equal(await run("return window.folded"), 0, "everything is open while printing");
  assert.ok(await run("return document.querySelectorAll('details:not([open])').length > 0"), "everything is closed again after printing");

  // 9. Matrix of decoders.
  await open(matrix);
  assert.equal(await run("return document.querySelectorAll('table.matrix thead tr:first-child th').length"), 4);
  assert.deepEqual(await contrasts(), [], "matrix: text too faint");
  await screenshot("matrix.png");
  await run("const s = document.querySelector('.scroll.tall'); s.scrollTop = s.scrollHeight");
  const [head, area] = await run("return ['table.matrix thead th', '.scroll.tall'].map((css) => document.querySelector(css).getBoundingClientRect().top)");
  assert.ok(Math.abs(head - area) < 2, `the table head is at ${head}, its scroll area begins at ${area}`);

  // 10. No errors, and no requests except for the pages themselves. Warnings about reading canvases are caused by this
  //     test, not by the page.
  const errors = (await log("browser")).filter((entry) => !/INFO|DEBUG/.test(entry.level) && !entry.message.includes("willReadFrequently"));
  assert.deepEqual(errors, []);
  const requestedUrls = async () => (await log("performance"))
    .map((entry) => JSON.parse(entry.message).message)
    // The browser also loads internal pages.
    .filter((message) => message.method === "Network.requestWillBeSent" && message.params.documentURL.startsWith("file:"))
    .map((message) => message.params.request.url)
    .filter((url) => !url.startsWith("data:"));
  const requests = await requestedUrls();
  const pages = [page, matrix].map((file) => pathToFileURL(file).href);
  assert.deepEqual(requests.filter((url) => !pages.includes(url.split("#")[0])), []);
  // A page that sends a request is detected.
  const external = join(dirname(page), "asking.html");
  writeFileSync(external, "<!DOCTYPE html><title>asking</title><img src='missing.png'>");
  await open(external);
  assert.deepEqual((await requestedUrls()).map((url) => url.split("/").at(-1)), ["asking.html", "missing.png"]);
  console.log(`${images.length} images, ${all} cards, ${requests.length} requests, all for the pages themselves`);
} finally {
  await close();
}
