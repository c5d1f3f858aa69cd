// The reference decoder as WebAssembly: in Node, in a browser, in a worker.
//
//     const reference = await load(await (await fetch(new URL("reference.wasm", import.meta.url))).arrayBuffer());

import { Malformed, Unsupported } from "./index.mjs";

/** Starts the reference: `module` is the bytes of reference.wasm, or a WebAssembly.Module. */
export async function load(module) {
  const compiled = module instanceof WebAssembly.Module ? module : await WebAssembly.compile(module);
  const wasm = (await WebAssembly.instantiate(compiled, {})).exports;

  /** Reads a file; what is said of it. */
  const open = (file) => {
    // First the call, which may let the memory grow and leave an older buffer empty.
    const place = wasm.reserve(file.length);
    new Uint8Array(wasm.memory.buffer, place, file.length).set(file);
    wasm.open();
    return JSON.parse(new TextDecoder().decode(new Uint8Array(wasm.memory.buffer, wasm.report(), wasm.report_length())));
  };
  const map = (file) => {
    const { map, refused } = open(file);
    if (map) return map;
    throw new (refused.kind === "malformed" ? Malformed : Unsupported)(refused.says);
  };
  const bytes = (pointer, length) => new Uint8Array(wasm.memory.buffer, pointer, length).slice();

  return {
    /** The stored values. */
    decode(file) {
      const { width, height, channels } = map(file);
      return { width, height, channels, samples: bytes(wasm.samples(), width * height * channels) };
    },
    /** What is wrong with a file, as `ptm-conform lint --json` says it. */
    lint: (file) => open(file).lint,
    /** Every field, as `ptm-conform inspect --json` says it. */
    inspect: (file) => open(file).inspect,
    /** The image under a light, +lu to the right, +lv up, as red, green, blue and 255. */
    relight(file, lu, lv) {
      const { width, height } = map(file);
      return { width, height, channels: 4, samples: bytes(wasm.relight(lu, lv), width * height * 4) };
    },
  };
}
