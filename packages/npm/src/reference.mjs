// The reference decoder as WebAssembly, in Node, a browser or a worker.
//
//     const reference = await load(await (await fetch(new URL("reference.wasm", import.meta.url))).arrayBuffer());

import { Malformed, Unsupported } from "./index.mjs";

/** Loads the reference decoder. `module` is the bytes of reference.wasm, or a WebAssembly.Module. */
export async function load(module) {
  const compiled = module instanceof WebAssembly.Module ? module : await WebAssembly.compile(module);
  const wasm = (await WebAssembly.instantiate(compiled, {})).exports;

  /** Opens a file and returns the report on it. With `examine`, the report also contains fields and findings. */
  const open = (file, { examine = false } = {}) => {
    // Get the buffer after the call, which may grow the memory and detach an older buffer.
    const place = wasm.reserve(file.length);
    new Uint8Array(wasm.memory.buffer, place, file.length).set(file);
    wasm.open();
    if (examine) wasm.examine();
    return JSON.parse(new TextDecoder().decode(new Uint8Array(wasm.memory.buffer, wasm.report(), wasm.report_length())));
  };
  const map = (file) => {
    const { map, refused } = open(file);
    if (map) return map;
    throw new (refused.kind === "malformed" ? Malformed : Unsupported)(refused.says);
  };
  const bytes = (pointer, length) => new Uint8Array(wasm.memory.buffer, pointer, length).slice();

  return {
    /** Returns the stored values. */
    decode(file) {
      const { width, height, channels } = map(file);
      return { width, height, channels, samples: bytes(wasm.samples(), width * height * channels) };
    },
    /** Returns the findings, like `ptm-conform lint --json`. */
    lint: (file) => open(file, { examine: true }).lint,
    /** Returns every field, like `ptm-conform inspect --json`. */
    inspect: (file) => open(file, { examine: true }).inspect,
    /** Returns the image under a light, with +lu to the right and +lv up, as red, green, blue and 255. */
    relight(file, lu, lv) {
      const { width, height } = map(file);
      return { width, height, channels: 4, samples: bytes(wasm.relight(lu, lv), width * height * 4) };
    },
  };
}
