// Tests the package: node test.mjs, in its directory. PTM_CONFORM_PROGRAM is the path of the program, if it is not installed.

import assert from "node:assert/strict";
import { existsSync, readFileSync } from "node:fs";

import { describeAnswer, corpus } from "./corpus.mjs";
import { Malformed, Unsupported, fromBase64, run } from "./index.mjs";
import { cases, check, program } from "./node.mjs";
import { load } from "./reference.mjs";

const all = cases();
assert(all.length > 2000, `${all.length} cases`);
const answers = new Map(all.filter(({ raw }) => raw).map(({ file, raw }) => [file, raw]));
const expected = new Map(all.map(({ file, expect }) => [file, expect]));
const base64 = (file) => Buffer.from(file).toString("base64");
const correct = (file) => {
  const raw = answers.get(base64(file));
  if (!raw || !["decode", "spelling"].includes(expected.get(base64(file)))) throw new Malformed("expected");
  return { ...raw, samples: fromBase64(raw.samples) };
};
const upsideDown = (file) => {
  const image = correct(file), row = image.width * image.channels;
  const rows = Array.from({ length: image.height }, (_, y) => image.samples.slice(y * row, (y + 1) * row));
  return { ...image, samples: Uint8Array.from(rows.reverse().flatMap((row) => [...row])) };
};

// `run` with the cases as data.
const good = await run(all, correct);
assert(good.passed, JSON.stringify(good.failures.slice(0, 3)));
assert(good.results.filter(({ outcome }) => outcome === "pass").length > 2000);
const turned = await run(all, upsideDown);
const hand = turned.failures.find(({ id }) => id === "hand-rgb-blocks");
assert.match(hand.says, /^texel \(0, 0\), first in channel 0: expected 24 25 26 .* received 16 17 18/);
for (const decode of [() => { throw new Malformed(); }, () => { throw new Unsupported(); }, () => null, () => { throw new TypeError("lost"); }]) {
  const { passed, failures } = await run(all, decode);
  assert(!passed);
  assert.equal(failures[0].id, "decodes-a-file");
}

// A message names the class and the line. Classes that are not declared are named with advice, and a case without its twin has no verdict.
class Damaged extends Error {}
const refuseAll = () => { throw new Damaged("no table"); };
const refusing = await run(all, refuseAll, { malformed: Damaged });
assert.match(refusing.results.find(({ id }) => id === "hand-lum").says, /^refused a legal file: Damaged: no table \(test\.mjs:\d+\)$/);
const damaged = all.find(({ twin }) => twin);
const alone = await run([damaged], correct);
assert.equal(alone.results.find(({ id }) => id === damaged.id).outcome, "inconclusive");
const undeclared = await check((file) => { try { return correct(file); } catch { return refuseAll(); } }, { options: ["--case", "hand-*", "--case", "width-*"] });
assert.match(undeclared.text, /^Damaged was thrown \d+ times and counts as a crash; if it means a file that is malformed, pass \{ malformed: Damaged \}\n/);
assert(undeclared.text.includes("Damaged is declared neither as malformed nor as unsupported"), undeclared.text);

// Known failures, errors that belong to both classes, and classes that catch everything.
const ids = turned.failures.map(({ id }) => id);
assert((await run(all, upsideDown, { known: ids })).passed);
assert(!(await run(all, correct, { known: ["hand-rgb-blocks"] })).passed);
class Refused extends Malformed {}
const unsure = await run(all, () => { throw new Refused("unsure"); }, { unsupported: Refused });
assert.equal(unsure.results.find(({ id }) => id === "hand-rgb-blocks").outcome, "unsupported");
await assert.rejects(run(all, correct, { malformed: Error }), /nearly every error/);
await assert.rejects(check(correct, { unsupported: Error }), /nearly every error/);

// `check` with the same functions.
const options = ["--case", "hand-*", "--case", "first-*"];
const checked = await check(correct, { options });
assert.equal(checked.status, 0, checked.text);
const wrong = await check({ raw: upsideDown }, { options });
assert.equal(wrong.status, 1, wrong.text);
assert(wrong.text.includes("rows-top-down") || wrong.text.includes("upside down"), wrong.text);
const lost = await check({ raw: () => { throw new TypeError("lost"); } }, { options });
assert.equal(lost.status, 3);

// The cases as data are exactly those of the program with files up to 64 KiB.
const whole = await corpus(program());
const small = whole.filter(({ file }) => file.length <= 65536);
assert.deepEqual(new Map(all.map(({ id, file }) => [id, file])), new Map(small.map(({ id, file }) => [id, base64(file)])));
// The reference decoder as WebAssembly, if the package contains it.
if (existsSync("reference.wasm")) {
  const reference = await load(readFileSync("reference.wasm"));
  const own = await run(all, (file) => reference.decode(file));
  assert(own.passed, JSON.stringify(own.failures.slice(0, 3)));
  // It decodes or refuses every file of the suite like the program.
  for (const { id, file, answer } of whole) assert.equal(await describeAnswer(reference.decode, file), answer, id);
  console.log(`${whole.length} files: equal to the program`);
  const lum = fromBase64(all.find(({ id }) => id === "hand-lum").file);
  assert.deepEqual(reference.lint(lum).map(({ code }) => code), ["PTM-W303", "PTM-W304", "PTM-W313"]);
  assert.equal(reference.relight(lum, 0, 0).samples.length, 8);
  assert.throws(() => reference.decode(new Uint8Array()), Malformed);
}
console.log("all tests passed");
