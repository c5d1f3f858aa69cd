// Every file of the suite with the answer of the program, for tests. The package does not contain this module.

import { spawn, execFileSync } from "node:child_process";
import { createHash } from "node:crypto";
import { once } from "node:events";
import { mkdtempSync, readFileSync, readdirSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { basename, join } from "node:path";

/** Describes the answer of `decode`: size and digest of the samples, or the kind of refusal. Also runs in a browser. */
export async function describeAnswer(decode, file) {
  try {
    const { width, height, channels, samples } = decode(file);
    const digest = new Uint8Array(await crypto.subtle.digest("SHA-256", samples));
    return `${width} ${height} ${channels} ${Array.from(digest, (byte) => byte.toString(16).padStart(2, "0")).join("")}`;
  } catch (error) {
    return error.constructor.name;
  }
}

/** Returns every case of the suite as { id, file, answer }. `answer` is that of the program, in the format of describeAnswer. */
export async function corpus(program) {
  const directory = mkdtempSync(join(tmpdir(), "ptm-"));
  try {
    execFileSync(program, ["--quiet", "generate", "--all", "--out", directory]);
    const paths = readdirSync(directory, { recursive: true }).filter((name) => name.endsWith(".ptm")).sort().map((name) => join(directory, name));
    const answers = await programAnswers(program, paths);
    return paths.map((path, i) => ({ id: basename(path, ".ptm"), file: readFileSync(path), answer: answers[i] }));
  } finally {
    rmSync(directory, { recursive: true });
  }
}

/** Returns the answers of the program. They are "SEQ ok NBYTES" and the bytes of a frame, or a line "SEQ WORD …". */
async function programAnswers(program, paths) {
  const child = spawn(program, ["reference", "serve"], { stdio: ["pipe", "pipe", "inherit"] });
  child.stdin.end(paths.map((path, i) => `${i} raw ${path}\n`).join(""));
  const chunks = [];
  child.stdout.on("data", (chunk) => chunks.push(chunk));
  await once(child, "close");
  let rest = Buffer.concat(chunks);
  const line = () => {
    const end = rest.indexOf(10), text = rest.toString("latin1", 0, end);
    rest = rest.subarray(end + 1);
    return text.split(" ");
  };
  return paths.map(() => {
    const [, word, length] = line();
    if (word !== "ok") return { reject: "Malformed", unsupported: "Unsupported" }[word];
    const after = rest.subarray(Number(length)), [, , width, height, channels] = line();
    const digest = createHash("sha256").update(rest.subarray(0, rest.length - after.length)).digest("hex");
    rest = after;
    return `${width} ${height} ${channels} ${digest}`;
  });
}
