// Compares the module with the program: node test.mjs MODULE PROGRAM FOLDER [--speed]
//
// Every .ptm file in FOLDER and its subfolders must give the same fields, findings, planes and images under three lights. Then
// 1,000 mutated files must neither trap nor hang, and the time for an image of 1024 × 1024 is compared with plain JavaScript.
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { createHash } from "node:crypto";
import { readFileSync, readdirSync } from "node:fs";
import { join } from "node:path";
import { isDeepStrictEqual } from "node:util";

const [modulePath, program, folder] = process.argv.slice(2);
const module = await WebAssembly.compile(readFileSync(modulePath));
const start = async () => (await WebAssembly.instantiate(module, {})).exports;
const LIGHTS = [[0, 0], [0.3125, -0.4375], [-0.6, 0.5]];

// A call may grow the memory, which replaces its buffer, so the buffer is fetched after each call.
const view = (wasm, at, length) => new Uint8Array(wasm.memory.buffer, at, length);
const open = (wasm, file) => {
  const at = wasm.reserve(file.length);
  view(wasm, at, file.length).set(file);
  wasm.open();
  wasm.examine();
  const [report, length] = [wasm.report(), wasm.report_length()];
  return JSON.parse(Buffer.from(view(wasm, report, length)).toString());
};
const relit = (wasm, u, v, { width, height }) => {
  const at = wasm.relight(u, v);
  return view(wasm, at, width * height * 4);
};
const run = (args, input) => {
  const { stdout, error } = spawnSync(program, args, { input, maxBuffer: 1 << 30 });
  if (error) { throw error; }
  return stdout;
};

const wasm = await start();
const files = readdirSync(folder, { recursive: true }).filter((name) => name.endsWith(".ptm")).sort();
assert.ok(files.length > 0, `no files in ${folder}`);
const paths = files.map((name) => join(folder, name));
// One process lints all files; another serves their planes and images.
const findings = [JSON.parse(run(["lint", "--json", ...paths]))].flat();
const views = ["raw", ...LIGHTS.map(([u, v]) => `rgb:${u},${v}`)];
const served = run(["reference", "serve"], paths.flatMap((path, i) => views.map((view) => `${i} ${view} ${path}\n`)).join(""));
let at = 0;
const line = () => { const end = served.indexOf(10, at); const text = served.toString("latin1", at, end); at = end + 1; return text; };
// Returns the samples of the next answer, or null for a refusal.
const answer = () => {
  const [, status, length] = line().split(" ");
  if (status !== "ok") { return null; }
  const end = at + Number(length);
  line();
  const samples = served.subarray(at, end);
  at = end;
  return samples;
};
let maps = 0;
// Returns the first difference of each file.
const differences = [];
for (const [i, name] of files.entries()) {
  const { inspect, lint, map } = open(wasm, readFileSync(paths[i]));
  const [planes, ...images] = views.map(answer);
  const fields = JSON.parse(run(["inspect", "--json", paths[i]]));
  assert.equal(findings[i].file, paths[i]);
  const pairs = [["fields", inspect, fields], ["findings", lint, findings[i].findings], ["decoded", map !== null, planes !== null]];
  if (map && planes) {
    maps += 1;
    pairs.push(["planes", map.planes, createHash("sha256").update(planes).digest("hex")]);
    for (const [n, [u, v]] of LIGHTS.entries()) {
      pairs.push([views[n + 1], Buffer.from(relit(wasm, u, v, map).filter((_, i) => i % 4 < 3)), images[n]]);
    }
  }
  const short = (value) => JSON.stringify(value.error ?? value).slice(0, 300);
  const wrong = pairs.find(([, own, theirs]) => !isDeepStrictEqual(own, theirs));
  if (wrong) { differences.push(`${name}, ${wrong[0]}: ${short(wrong[1])} here, ${short(wrong[2])} in the program`); }
}
assert.equal(at, served.length);
assert.equal(differences.length, 0, differences.join("\n"));
console.log(`${files.length} files, ${maps} maps: equal to the program`);

// A fixed generator makes the same mutations in every run.
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
assert.ok(longest < 10_000, `a mutated file took ${longest.toFixed(0)} ms`);
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
  // Processor time does not depend on other load of the machine.
  const began = process.cpuUsage();
  for (let i = 0; i < 20; i += 1) { light(Math.cos(i) * 0.7, Math.sin(i) * 0.7); }
  const { user, system } = process.cpuUsage(began);
  return (user + system) / 20_000;
};
const [module_ms, plain_ms] = [time((u, v) => fresh.relight(u, v)), time(plain)];
console.log(`${map.width} × ${map.height}: ${module_ms.toFixed(1)} ms per image (${(1000 / module_ms).toFixed(0)} per second); plain JavaScript ${plain_ms.toFixed(1)} ms`);
if (process.argv.includes("--speed")) { assert.ok(module_ms < 1000 / 30, "fewer than 30 images per second"); }
