// Holds the module against the program: node test.mjs MODULE PROGRAM FOLDER
//
// For every .ptm in FOLDER: the same fields, the same findings, the same planes, the same picture under three lights. Then a
// thousand mutated files, which must neither trap nor hang, and the time of a picture of 1024 × 1024 beside plain JavaScript.
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { createHash } from "node:crypto";
import { readFileSync, readdirSync } from "node:fs";
import { join } from "node:path";

const [modulePath, program, folder] = process.argv.slice(2);
const module = await WebAssembly.compile(readFileSync(modulePath));
const start = async () => (await WebAssembly.instantiate(module, {})).exports;
const LIGHTS = [[0, 0], [0.3125, -0.4375], [-0.6, 0.5]];

const open = (wasm, file) => {
  // The memory may grow, and be another one, when room is asked for.
  const at = wasm.reserve(file.length);
  new Uint8Array(wasm.memory.buffer, at, file.length).set(file);
  wasm.open();
  return JSON.parse(Buffer.from(wasm.memory.buffer, wasm.report(), wasm.report_length()).toString());
};
const run = (...args) => spawnSync(program, args, { maxBuffer: 1 << 30 });
// A frame without its first line.
const samples = (frame) => frame.subarray(frame.indexOf(10) + 1);

const wasm = await start();
const files = readdirSync(folder).filter((name) => name.endsWith(".ptm")).sort();
assert.ok(files.length > 0, `no files in ${folder}`);
let maps = 0;
for (const name of files) {
  const path = join(folder, name);
  const { inspect, lint, map } = open(wasm, readFileSync(path));
  assert.deepEqual(inspect, JSON.parse(run("inspect", "--json", path).stdout), `${name}: fields`);
  const [said] = [JSON.parse(run("lint", "--json", path).stdout)].flat();
  assert.deepEqual(lint, said.findings, `${name}: findings`);
  const raw = run("reference", "raw", path);
  assert.equal(map !== null, raw.status === 0, `${name}: decoded`);
  if (!map) { continue; }
  maps += 1;
  assert.equal(map.planes, createHash("sha256").update(samples(raw.stdout)).digest("hex"), `${name}: planes`);
  for (const [u, v] of LIGHTS) {
    const picture = samples(run("reference", `rgb:${u},${v}`, path).stdout);
    const own = new Uint8Array(wasm.memory.buffer, wasm.relight(u, v), map.width * map.height * 4);
    assert.deepEqual(Buffer.from(own.filter((_, i) => i % 4 < 3)), picture, `${name}: under ${u}, ${v}`);
  }
}
console.log(`${files.length} files, ${maps} maps: as the program reads them`);

// Mutations come from a generator of our own, so that each run has the same.
let seed = 1;
const random = (below) => { seed = (Math.imul(seed, 1664525) + 1013904223) >>> 0; return Math.floor(seed / 2 ** 32 * below); };
let longest = 0;
for (let i = 0; i < 1000; i += 1) {
  const file = Buffer.from(readFileSync(join(folder, files[random(files.length)])));
  for (let n = random(8) + 1; n > 0; n -= 1) { file[random(file.length)] = random(256); }
  const began = performance.now();
  const { map } = open(wasm, file.subarray(0, random(4) ? file.length : random(file.length)));
  if (map && map.width * map.height < 1 << 22) { wasm.relight(0.2, 0.3); }
  longest = Math.max(longest, performance.now() - began);
}
console.log(`1000 mutated files: no trap, at most ${longest.toFixed(0)} ms`);

const side = 1024;
const payload = Buffer.alloc(side * side * 9).map(() => random(256));
const large = Buffer.concat([Buffer.from(`PTM_1.2\nPTM_FORMAT_LRGB\n${side}\n${side}\n2 2 2 2 2 2\n128 128 128 128 128 0\n`), payload]);
const fresh = await start();
const { map } = open(fresh, large);
const plain = (u, v) => {
  const out = new Uint8ClampedArray(side * side * 4);
  for (let t = 0; t < side * side; t += 1) {
    const a = (i) => (payload[t * 6 + i] - (i < 5 ? 128 : 0)) * 2;
    const l = a(0) * u * u + a(1) * v * v + a(2) * u * v + a(3) * u + a(4) * v + a(5);
    for (let c = 0; c < 3; c += 1) { out[t * 4 + c] = l * payload[side * side * 6 + t * 3 + c] / 255; }
    out[t * 4 + 3] = 255;
  }
  return out;
};
const time = (light) => {
  for (let i = 0; i < 3; i += 1) { light(0.1, 0.2); }
  const began = performance.now();
  for (let i = 0; i < 20; i += 1) { light(Math.cos(i) * 0.7, Math.sin(i) * 0.7); }
  return (performance.now() - began) / 20;
};
const [module_ms, plain_ms] = [time((u, v) => fresh.relight(u, v)), time(plain)];
console.log(`${map.width} × ${map.height}: ${module_ms.toFixed(1)} ms a picture (${(1000 / module_ms).toFixed(0)} a second); plain JavaScript ${plain_ms.toFixed(1)} ms`);
if (process.argv.includes("--speed")) { assert.ok(module_ms < 1000 / 30, "30 pictures a second"); }
