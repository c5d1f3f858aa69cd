// Tests the page for dropped files in a headless Chromium: node drop.mjs PAGE
//
// Drops a legal file, a damaged file and a file of another kind, and moves the light.

import assert from "node:assert/strict";
import { pathToFileURL } from "node:url";

import { browser } from "../webdriver.mjs";

const { call, run, close } = await browser();
const until = async (what, script) => {
  for (let i = 0; i < 200; i += 1) {
    if (await run(script)) return;
    await new Promise((resolve) => setTimeout(resolve, 50));
  }
  assert.fail(`timed out waiting for ${what}`);
};
const status = "document.getElementById('status').textContent";
const drop = (index) => run(`
  const [, name, contents] = JSON.parse(document.getElementById("samples").textContent)[arguments[0]];
  const dataTransfer = new DataTransfer();
  dataTransfer.items.add(new File([Uint8Array.from(atob(contents), (c) => c.charCodeAt(0))], name));
  document.dispatchEvent(new DragEvent("drop", { dataTransfer, bubbles: true, cancelable: true }));`, index);
const pixels = () => run("const c = document.getElementById('picture'); return [...c.getContext('2d').getImageData(0, 0, c.width, c.height).data].join()");
try {
  await call("POST", "/url", { url: pathToFileURL(process.argv[2]).href });
  await until("the module", `return ${status}.startsWith("Ready")`);

  await drop(0);
  await until("the map", `return ${status}.includes("PTM_FORMAT_LRGB, 65 × 65")`);
  const before = await pixels();
  await run(`
    const ball = document.getElementById("ball"), box = ball.getBoundingClientRect();
    const at = (type, x, y) => ball.dispatchEvent(new PointerEvent(type, { pointerId: 1, buttons: 1, clientX: box.left + x * box.width, clientY: box.top + y * box.height }));
    ball.setPointerCapture = () => {};
    at("pointerdown", 0.5, 0.5);
    at("pointermove", 0.9, 0.4);`);
  await until("the light", "return document.getElementById('light').textContent.startsWith('u 0.8')");
  assert.notEqual(await pixels(), before, "the image changes with the light");

  await drop(1);
  await until("the error", `return ${status}.includes("not decoded") && document.querySelector("#faults .fault")?.textContent.includes("clause 2.")`);
  await drop(2);
  await until("another kind of file", `return ${status}.includes("not decoded") && document.querySelector("#faults .fault")?.textContent.includes("clause 2.1/1")`);
  for (const button of [0, 1, 2]) {
    await run("document.querySelectorAll('#try button')[arguments[0]].click()", button);
    await until(`sample ${button}`, `return ${status}.includes(JSON.parse(document.getElementById("samples").textContent)[${button}][1])`);
  }
  console.log("three files dropped, the light moved");
} finally {
  await close();
}
