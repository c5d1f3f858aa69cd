// Builds the npm package: node build.mjs PROGRAM OUT [--module MODULE] [--platform OS-CPU]
//
// PROGRAM is ptm-conform, which generates the cases. MODULE is the compiled packages/wasm; without it, the package has no
// reference decoder, and does not export it. With --platform, such as linux-x64, OUT is instead the package that contains PROGRAM for this platform.
// npm installs the one for the machine, and `check` in Node uses it.

import { execFileSync } from "node:child_process";
import { chmodSync, copyFileSync, cpSync, mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { basename, dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

const here = dirname(fileURLToPath(import.meta.url));
const root = join(here, "..", "..");
const [program, out, option, argument] = process.argv.slice(2);
if (!out || (option && !["--module", "--platform"].includes(option)) || (option && !argument)) {
  console.error("usage: node build.mjs PROGRAM OUT [--module MODULE | --platform OS-CPU]");
  process.exit(2);
}
const version = /^version = "(.*)"$/m.exec(readFileSync(join(root, "Cargo.toml"), "utf8"))[1];
const platforms = ["linux-x64", "linux-arm64", "darwin-x64", "darwin-arm64"];
const common = {
  version,
  license: "MIT OR Apache-2.0",
  repository: { type: "git", url: "git+https://github.com/ptm-conform/ptm-conform.git" },
};

/** Returns the samples of a NumPy file of bytes, in base64. */
function samples(path) {
  const file = readFileSync(path);
  return file.subarray(10 + file.readUInt16LE(8)).toString("base64");
}

/** Returns every case whose file has at most 64 KiB, with the stored values if there are expected ones. */
function cases(directory) {
  const manifest = JSON.parse(readFileSync(join(directory, "MANIFEST.json"), "utf8"));
  return manifest.cases.map((entry) => {
    const { id, format, expect, because, clauses, ruling, twin_of: twin } = entry;
    const answer = (entry.expected ?? []).find(({ view, encoding }) => view === "raw" && encoding === "npy");
    return {
      id, format, expect, because, clauses, ruling, twin,
      file: readFileSync(join(directory, entry.file)).toString("base64"),
      raw: answer && {
        width: answer.shape[1], height: answer.shape[0], channels: answer.shape[2],
        samples: samples(join(directory, answer.file)),
        slack: answer.slack && samples(join(directory, answer.slack)),
        shows: answer.shows,
      },
    };
  });
}

function write(name, value) {
  writeFileSync(join(out, name), JSON.stringify(value, null, name === "package.json" ? 2 : 0) + "\n");
}

mkdirSync(out, { recursive: true });
for (const name of ["LICENSE-APACHE", "LICENSE-MIT"]) copyFileSync(join(root, name), join(out, name));
if (option === "--platform") {
  const [os, cpu] = argument.split("-");
  mkdirSync(join(out, "bin"), { recursive: true });
  copyFileSync(program, join(out, "bin", basename(program)));
  chmodSync(join(out, "bin", basename(program)), 0o755);
  write("package.json", {
    name: `@ptm-conform/${argument}`, description: `The program ptm-conform for ${argument}`, ...common, os: [os], cpu: [cpu],
  });
} else {
  const scratch = mkdtempSync(join(tmpdir(), "ptm-"));
  try {
    execFileSync(program, ["--quiet", "generate", "--profile", "standard", "--out", join(scratch, "corpus")]);
    write("cases.json", cases(join(scratch, "corpus")));
  } finally {
    rmSync(scratch, { recursive: true });
  }
  cpSync(join(here, "src"), out, { recursive: true });
  if (option === "--module") copyFileSync(argument, join(out, "reference.wasm"));
  copyFileSync(join(here, "README.md"), join(out, "README.md"));
  write("package.json", {
    name: "ptm-conform",
    description: "Conformance suite for decoders for Polynomial Texture Maps (PTM 1.2)",
    ...common,
    type: "module",
    exports: {
      ".": { types: "./index.d.ts", default: "./index.mjs" },
      "./node": { types: "./node.d.ts", default: "./node.mjs" },
      ...(option === "--module" && {
        "./reference": { types: "./reference.d.ts", default: "./reference.mjs" },
        "./reference.wasm": "./reference.wasm",
      }),
      "./cases.json": "./cases.json",
    },
    bin: { "ptm-conform": "bin.mjs" },
    files: ["*.mjs", "*.d.ts", "cases.json", "reference.wasm", "LICENSE-*", "!corpus.mjs", "!test.mjs"],
    engines: { node: ">=18" },
    keywords: ["ptm", "rti", "conformance", "texture", "decoder"],
    optionalDependencies: Object.fromEntries(platforms.map((platform) => [`@ptm-conform/${platform}`, version])),
  });
}
