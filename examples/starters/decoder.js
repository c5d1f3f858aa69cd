// A minimal PTM decoder for ptm-conform: node decoder.js VIEW FILE, or node decoder.js serve.
"use strict";
const fs = require("fs");

const CAPABILITIES = "protocol: 1\nname: my-decoder\nmodes: [one-shot, serve]\npipelined: true\n";
const six = (number) => `(${number}(?: +${number}){5})`, BREAK = "(?: +| ?\\n)";
const NUMBERS = six("[+-]?(?:\\d+\\.?\\d*|\\.\\d+)(?:[eE][+-]?\\d+)?") + BREAK + six("[+-]?\\d+") + " ?\\n";
const HEADER = new RegExp(`^PTM_1\\.2 ?\\n(PTM_FORMAT_\\w+) ?\\n(\\d+)${BREAK}(\\d+) ?\\n${NUMBERS}`);

// Exit status 65: the file is malformed. 69: the kind of file or the view is not supported.
class Refusal extends Error {
  constructor(status) {
    super(`exit status ${status}`);
    this.status = status;
  }
}

// To do: return width, height, channels, "u8" or "f32", and the samples, texel by texel, top row first.
// This example decodes the stored values of PTM_FORMAT_LRGB: all polynomials, then all colors, bottom row first.
function decode(view, file) {
  const header = HEADER.exec(file.toString("latin1"));
  if (view !== "raw" || (header && header[1] !== "PTM_FORMAT_LRGB")) throw new Refusal(69);
  if (!header || !`${header[4]} ${header[5]}`.split(/ +/).map(Number).every(Number.isFinite)) throw new Refusal(65);
  const [width, height, start] = [Number(header[2]), Number(header[3]), header[0].length];
  const count = width * height;
  if (count === 0 || file.length < start + 9 * count) throw new Refusal(65);
  const samples = Buffer.alloc(9 * count);
  for (let i = 0; i < count; i++) {
    const to = 9 * ((height - 1 - Math.floor(i / width)) * width + (i % width));
    file.copy(samples, to, start + 6 * i, start + 6 * i + 6);
    file.copy(samples, to + 6, start + 6 * count + 3 * i, start + 6 * count + 3 * i + 3);
  }
  return [width, height, 9, "u8", samples];
}

function frame(view, path) {
  const [width, height, channels, type, samples] = decode(view, fs.readFileSync(path));
  return Buffer.concat([Buffer.from(`PTM1 ${view.split(":")[0]} ${width} ${height} ${channels} ${type}\n`), samples]);
}

// Answers a request "SEQ VIEW PATH".
function answer(request) {
  const [, sequence, view, path] = /^(\S+) (\S+) (.*)$/.exec(request);
  try {
    const response = frame(view, path);
    return Buffer.concat([Buffer.from(`${sequence} ok ${response.length}\n`), response]);
  } catch (error) {
    if (!(error instanceof Refusal)) throw error;
    return Buffer.from(`${sequence} ${error.status === 65 ? "reject 65" : "unsupported"}\n`);
  }
}

const [command, path] = process.argv.slice(2);
try {
  if (command === "capabilities") process.stdout.write(CAPABILITIES);
  else if (command !== "serve") process.stdout.write(frame(command, path));
  else require("readline").createInterface({ input: process.stdin }).on("line", (line) => process.stdout.write(answer(line)));
} catch (error) {
  process.exitCode = error instanceof Refusal ? error.status : 1;
}
