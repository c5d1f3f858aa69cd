// Runs the whole suite with diagnosis in Node. The program requests views from functions of this process over a socket.

import { spawn } from "node:child_process";
import { existsSync, mkdtempSync, readFileSync, rmSync } from "node:fs";
import { createRequire } from "node:module";
import { createServer } from "node:net";
import { tmpdir } from "node:os";
import { dirname, join } from "node:path";

import { Malformed, Unsupported, describeError, refusal, rejectCatchAll } from "./index.mjs";

export { Malformed, Unsupported };

/** Returns the path of ptm-conform: PTM_CONFORM_PROGRAM, or else the program that npm installed for this machine. */
export function program() {
  if (process.env.PTM_CONFORM_PROGRAM) return process.env.PTM_CONFORM_PROGRAM;
  const carrier = `@ptm-conform/${process.platform}-${process.arch}`;
  try {
    const manifest = createRequire(import.meta.url).resolve(`${carrier}/package.json`);
    return join(dirname(manifest), "bin", "ptm-conform");
  } catch {
    throw new Error(`${carrier} is not installed; install it, or set PTM_CONFORM_PROGRAM to the path of ptm-conform`);
  }
}

/** Returns all cases, for `run`. */
export function cases() {
  return JSON.parse(readFileSync(new URL("./cases.json", import.meta.url), "utf8"));
}

/**
 * Checks functions. `raw(file)` and `coef(file)` return { width, height, channels, samples }. `rgb(file, lu, lv)` returns an
 * image with 3 channels. One function is enough. Returns { status, text, report }: the exit status, the output and the report
 * of `ptm-conform check`.
 */
export async function check(functions, { malformed = Malformed, unsupported = Unsupported, options = [] } = {}) {
  rejectCatchAll({ malformed, unsupported });
  const decoders = typeof functions === "function" ? { raw: functions } : functions;
  const directory = mkdtempSync(join(tmpdir(), "ptm-"));
  const place = (name) => join(directory, name);
  const crashes = new Map();
  const server = createServer((socket) => answerAll(socket, (view, file) => answer(decoders, view, file, { malformed, unsupported, crashes })));
  try {
    await new Promise((resolve) => server.listen(place("socket"), resolve));
    const words = ["check", "--caller", place("socket"), "--report", place("report.yaml"), "--json", place("report.json"), ...options];
    const { status, text, errors } = await finished(spawn(program(), words, { stdio: ["ignore", "pipe", "pipe"] }));
    if (!existsSync(place("report.json"))) throw new Error(errors.trim() || `ptm-conform exited with ${status}`);
    const report = JSON.parse(readFileSync(place("report.json"), "utf8"));
    return { status, text: advice(crashes, report) + text.replace(/^report: .*\n/m, ""), report };
  } finally {
    server.close();
    rmSync(directory, { recursive: true });
  }
}

/** Says how to declare the errors that were not caught. */
function advice(crashes, report) {
  const lines = [...crashes].sort(([, a], [, b]) => b - a).slice(0, 3).map(([name, count]) => {
    const thrown = report.cases.filter(({ stderr = "" }) => stderr.startsWith(`${name}:`));
    const legal = thrown.filter(({ expect }) => expect === "decode").length;
    const means = 2 * legal > thrown.length ? "unsupported" : "malformed";
    return `${name} was thrown ${count} times and counts as a crash; if it means a file that is ${means}, pass { ${means}: ${name} }\n`;
  });
  return lines.join("");
}

function finished(child) {
  const output = { text: "", errors: "" };
  child.stdout.setEncoding("utf8").on("data", (text) => { output.text += text; });
  child.stderr.setEncoding("utf8").on("data", (text) => { output.errors += text; });
  return new Promise((resolve, reject) => child.on("error", reject).on("close", (status) => resolve({ status, ...output })));
}

/** Answers requests. A request is "NAME VIEW NBYTES", a line feed and the file. An answer is "WORD NBYTES", a line feed and bytes. */
function answerAll(socket, answer) {
  let waiting = Buffer.alloc(0);
  let last = Promise.resolve();
  socket.on("error", () => {});
  socket.on("data", (bytes) => {
    waiting = Buffer.concat([waiting, bytes]);
    for (;;) {
      const end = waiting.indexOf(10);
      if (end < 0) return;
      const [, view, length] = waiting.toString("latin1", 0, end).split(" ");
      const next = end + 1 + Number(length);
      if (waiting.length < next) return;
      const file = Uint8Array.from(waiting.subarray(end + 1, next));
      waiting = waiting.subarray(next);
      last = last.then(async () => {
        const [word, data] = await answer(view, file);
        socket.write(Buffer.concat([Buffer.from(`${word} ${data.length}\n`), data]));
      });
    }
  });
}

async function answer(decoders, request, file, { malformed, unsupported, crashes }) {
  const [view, light] = request.split(":");
  if (!decoders[view]) return ["unsupported", Buffer.alloc(0)];
  let image;
  try {
    image = await decoders[view](file, ...(light ? light.split(",").map(Number) : []));
  } catch (error) {
    const refused = refusal(error, { malformed, unsupported });
    const name = error?.constructor?.name ?? typeof error;
    if (!refused) crashes.set(name, (crashes.get(name) ?? 0) + 1);
    const word = { malformed: "reject", unsupported: "unsupported" }[refused] ?? "crash";
    return [word, Buffer.from(describeError(error, { isDeclared: refused !== null })).subarray(-4000)];
  }
  const { width, height, channels, samples } = image ?? {};
  const [type, wanted] = view === "coef" ? ["f32", [Float32Array, Float64Array]] : ["u8", [Uint8Array, Uint8ClampedArray]];
  if (!wanted.some((kind) => samples instanceof kind)) return ["error", Buffer.from(`the samples must be a ${wanted[0].name}`)];
  const values = view === "coef" ? Float32Array.from(samples) : samples;
  const line = Buffer.from(`PTM1 ${view} ${width} ${height} ${channels} ${type}\n`);
  return ["ok", Buffer.concat([line, Buffer.from(values.buffer, values.byteOffset, values.byteLength)])];
}
