// Compares the package's `decode` with the program in a browser: node browser.mjs PACKAGE PROGRAM
//
// A headless Chromium decodes every fourth file of the suite. Size and samples, or the kind of refusal, must equal those of the
// program.

import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { createServer } from "node:http";
import { extname, join, resolve } from "node:path";
import { pathToFileURL } from "node:url";

import { browser } from "../webdriver.mjs";

const [directory, program] = process.argv.slice(2);
const { describeAnswer, corpus } = await import(pathToFileURL(resolve(directory, "corpus.mjs")));
const cases = (await corpus(program)).filter((_, i) => i % 4 === 0);
const TYPES = { ".mjs": "text/javascript", ".wasm": "application/wasm" };
const server = createServer(({ url }, response) => {
  const type = TYPES[extname(url)];
  if (type) response.setHeader("content-type", type).end(readFileSync(join(directory, url)));
  else response.setHeader("content-type", "text/html").end(url === "/" ? "" : cases[Number(url.slice(1))]?.file);
}).listen(0, "127.0.0.1");
await new Promise((listening) => server.on("listening", listening));
const script = `
  const [count, done] = arguments;
  (async () => {
    const { load } = await import("/reference.mjs");
    const reference = await load(await (await fetch("/reference.wasm")).arrayBuffer());
    const answers = [];
    for (let i = 0; i < count; i++) {
      const file = new Uint8Array(await (await fetch("/" + i)).arrayBuffer());
      answers.push(await (${describeAnswer})(reference.decode, file));
    }
    return answers;
  })().then(done, (error) => done(String(error)));`;
const { call, run, close } = await browser();
try {
  await call("POST", "/timeouts", { script: 600_000 });
  await call("POST", "/url", { url: `http://127.0.0.1:${server.address().port}/` });
  const answers = await call("POST", "/execute/async", { script, args: [cases.length] });
  cases.forEach(({ id, answer }, i) => assert.equal(answers[i], answer, id));
  console.log(`${cases.length} files in ${await run("return navigator.userAgent")}: equal to the program`);
} finally {
  await close();
  server.close();
}
