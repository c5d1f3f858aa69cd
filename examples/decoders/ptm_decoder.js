#!/usr/bin/env node
"use strict";
// Reads an uncompressed Polynomial Texture Map, version 1.2, and answers in PTM-CP 1. Needs only Node 18 or later.
//
//     ptm_decoder.js VIEW FILE       VIEW is raw, coef or rgb:LU,LV; one frame on standard output
//     ptm_decoder.js serve           requests "SEQ VIEW PATH" on standard input, one per line
//
// Exit status: 0 decoded, 65 malformed, 69 unsupported (the compressed formats, other views). The sections are in the order
// of the specification. If it leaves a question open, the name of the ruling follows in brackets, as in [rows].

const fs = require("fs");

class Refusal extends Error {
  constructor(status, message) { super(message); this.status = status; }
}
const malformed = (reason) => { throw new Refusal(65, `malformed: ${reason}`); };
const unsupported = (reason) => { throw new Refusal(69, `unsupported: ${reason}`); };

// Reads a file section by section. Returns the samples of every texel, top row first.
function readPtm(file) {
  const source = new Source(file);
  if (source.token() !== "PTM_1.2") malformed("the first line is not PTM_1.2");             // 2.1
  source.lineEnd();
  const [, format] = /^PTM_FORMAT_(\w+)$/.exec(source.token()) || malformed("the name of the format is missing"); // 2.2
  if (/^JPEG(LS)?_L?RGB$/.test(format)) unsupported(format);
  const channels = new Map([["RGB", 18], ["LUM", 8], ["LRGB", 9], ["PTM_LUT", 9], ["PTM_C_LUT", 9]]).get(format);
  if (!channels) malformed(`unknown format ${format}`);
  source.lineEnd();
  const width = source.side();                                            // 2.3
  source.gapOrLineEnd();
  const height = source.side();
  source.lineEnd();
  const scale = source.numbers(6, () => source.gap());                    // 2.4
  source.gapOrLineEnd();
  const bias = source.numbers(6, () => source.gap());
  if (!bias.every(Number.isInteger)) malformed("a bias is not an integer");   // [odd-numbers]
  source.lineEnd();

  const count = width * height;
  let matrix = null, parts;
  if (format === "LUM") {                                                 // 2.6
    matrix = source.numbers(16, () => source.gapOrLineEnd());             // [lum-layout]
    source.lineEnd();
    parts = [source.blocks(count, 8)];                                    // 2.7.2
  } else if (format === "RGB") {                                          // 2.7.1 [blocks]
    parts = [source.blocks(count, 6), source.blocks(count, 6), source.blocks(count, 6)];
  } else if (format === "LRGB") {                                         // 2.7.3
    parts = [source.blocks(count, 6), source.blocks(count, 3)];
  } else {                                                                // 2.5
    const entries = source.entryCount();
    const table = source.blocks(entries, format === "PTM_LUT" ? 6 : 9);   // [lut-newline]
    const size = entries <= 256 ? 1 : 2;                                  // 2.8 [lut-width]
    const indices = source.blocks(count, size);
    const entryOf = (texel) => {
      const index = indices(texel).reduceRight((index, byte) => index * 256 + byte, 0);
      return index < entries ? table(index) : malformed(`index ${index} into ${entries} entries`); // [lut-range]
    };
    parts = format === "PTM_LUT" ? [entryOf, source.blocks(count, 3)] : [entryOf];
  }

  const samples = Buffer.alloc(count * channels);
  let at = 0;
  for (let y = height - 1; y >= 0; y--) {                                 // [rows] the bottom row is stored first
    for (let x = 0; x < width; x++) {
      for (const part of parts) for (const byte of part(y * width + x)) samples[at++] = byte;
    }
  }
  return { width, height, channels, scale, bias, matrix, samples };       // [trailing]
}

// Reads words, spaces and line ends of the header, then blocks of the payload.
class Source {
  constructor(file) { this.file = file; this.at = 0; }

  token() {
    let end = this.at;
    while (end < this.file.length && this.file[end] !== 0x20 && this.file[end] !== 0x0a) end++;
    if (end === this.at) malformed(`expected a word at byte ${this.at}`);
    return this.file.toString("latin1", this.at, this.at = end);
  }

  // Skips a line feed, with an optional space before it [header-line-end].
  skipLineEnd() {
    const space = this.file[this.at] === 0x20 ? 1 : 0;
    if (this.file[this.at + space] !== 0x0a) return false;
    this.at += space + 1;
    return true;
  }
  lineEnd() { this.skipLineEnd() || malformed(`expected the end of the line at byte ${this.at}`); }
  gap() {
    const from = this.at;
    while (this.file[this.at] === 0x20) this.at++;
    if (this.at === from) malformed(`expected a space at byte ${from}`);
  }
  gapOrLineEnd() { this.skipLineEnd() || this.gap(); }                    // [size-spelling]

  number() {                                                              // [numbers]
    const word = this.token();
    const value = /^[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?$/.test(word) ? Number(word) : NaN;
    return Number.isFinite(value) ? value : malformed(`${word} is not a number`);
  }
  numbers(count, between) {
    return Array.from({ length: count }, (_, i) => { if (i > 0) between(); return this.number(); });
  }
  integer() {
    const word = this.token();
    return /^\+?\d+$/.test(word) && Number(word) < 2 ** 32 ? Number(word) : malformed(`${word} is not a valid integer`);
  }
  side() { return this.integer() || malformed("the width or height is 0"); }             // [dimensions]

  entryCount() {                                                          // [lut-count], all three spellings
    const first = this.file.toString("latin1", this.at, this.at + 9) === "nentries ";
    if (first) { this.token(); this.gap(); }
    const count = this.integer();
    if (!this.skipLineEnd()) {
      this.gap();
      if (first || this.token() !== "N_LUT_ENTRIES") malformed("expected N_LUT_ENTRIES after the number of entries");
      this.lineEnd();
    }
    return count;
  }

  // Reads `count` groups of `size` bytes. Returns a function that maps the index of a group to its bytes.
  blocks(count, size) {
    const from = this.at;
    if (count * size > this.file.length - from) malformed("the file is too short"); // [payload-end]
    this.at += count * size;
    return (i) => this.file.subarray(from + i * size, from + (i + 1) * size);
  }
}

// 2.4 and 1.0: final values and the colors under a light.
function finalValues(ptm) {
  const polynomials = ptm.channels === 18 ? 18 : 6;
  return Float64Array.from(ptm.samples, (raw, i) => {
    const channel = i % ptm.channels;
    return channel < polynomials ? (raw - ptm.bias[channel % 6]) * ptm.scale[channel % 6] : raw; // [final-coefficient]
  });
}

function litImage(ptm, lu, lv) {
  const values = finalValues(ptm);
  const powers = [lu * lu, lv * lv, lu * lv, lu, lv, 1];                  // [light] +lu right, +lv up
  const colors = Buffer.alloc(values.length / ptm.channels * 3);
  for (let texel = 0; texel < colors.length / 3; texel++) {
    const channel = (i) => values[texel * ptm.channels + i];
    const polynomial = (from) => powers.reduce((sum, power, i) => sum + power * channel(from + i), 0);
    const color = (c) => {
      if (ptm.channels === 18) return polynomial(6 * c);
      if (ptm.channels === 9) return polynomial(0) * channel(6 + c) / 255;                       // [color]
      const input = [polynomial(0), channel(6), channel(7), 1];                                  // [lum-vector]
      return input.reduce((sum, value, column) => sum + ptm.matrix[4 * column + c] * value, 0);  // [lum-major]
    };
    for (let c = 0; c < 3; c++) colors[3 * texel + c] = Math.round(Math.min(255, Math.max(0, color(c))));
  }
  return colors;
}

function frame(view, path) {
  const light = /^rgb:([^,]+),([^,]+)$/.exec(view);
  if (!light && view !== "raw" && view !== "coef") unsupported(`the view ${view}`);
  const ptm = readPtm(fs.readFileSync(path));
  const line = (name, channels, type) => Buffer.from(`PTM1 ${name} ${ptm.width} ${ptm.height} ${channels} ${type}\n`);
  if (view === "raw") return [line("raw", ptm.channels, "u8"), ptm.samples];
  if (light) return [line("rgb", 3, "u8"), litImage(ptm, Number(light[1]), Number(light[2]))];
  const values = finalValues(ptm), bytes = Buffer.alloc(4 * values.length);
  values.forEach((value, i) => bytes.writeFloatLE(Math.fround(value), 4 * i));
  return [line("coef", ptm.channels, "f32"), bytes];
}

const CAPABILITIES = `protocol: 1
name: ptm-decoder-javascript
version: "1.0"
views: [raw, coef, rgb]
formats: [PTM_FORMAT_RGB, PTM_FORMAT_LUM, PTM_FORMAT_LRGB, PTM_FORMAT_PTM_LUT, PTM_FORMAT_PTM_C_LUT]
modes: [one-shot, serve]
pipelined: true
`;

// Answers requests "SEQ VIEW PATH" on standard input, one per line.
function serve() {
  require("readline").createInterface({ input: process.stdin }).on("line", (request) => {
    const [, sequence, view, path] = /^(\S+) (\S+) (.*)$/.exec(request);
    let answer;
    try {
      const parts = frame(view, path);
      const size = parts.reduce((sum, part) => sum + part.length, 0);
      answer = [Buffer.from(`${sequence} ok ${size}\n`), ...parts];
    } catch (error) {
      if (!(error instanceof Refusal)) throw error;
      answer = [Buffer.from(`${sequence} ${error.status === 65 ? "reject 65" : "unsupported"}\n`)];
    }
    process.stdout.write(Buffer.concat(answer));
  });
}

function main([view, path]) {
  if (view === "capabilities") return process.stdout.write(CAPABILITIES);
  if (view === "serve") return serve();
  if (path === undefined) unsupported("usage: ptm_decoder.js VIEW FILE");
  // Do not call process.exit, which would lose the bytes that a pipe has not accepted yet.
  for (const part of frame(view, path)) process.stdout.write(part);
}

try {
  main(process.argv.slice(2));
} catch (error) {
  if (!(error instanceof Refusal)) throw error;
  console.error(error.message);
  process.exitCode = error.status;
}
