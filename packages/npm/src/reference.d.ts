import type { DecodedImage } from "./index.js";

export interface Finding {
  code: string;
  severity: "error" | "warning" | "info";
  clause: string;
  says: string;
  offset?: number;
  found?: string;
  fix?: string;
}

export interface Reference {
  /** Returns the stored values. Throws Malformed or Unsupported if the file cannot be decoded. */
  decode(file: Uint8Array): DecodedImage;
  lint(file: Uint8Array): Finding[];
  /** Returns a value in the format of spec-cases/schema/inspect.schema.json. */
  inspect(file: Uint8Array): object;
  /** Returns an image with four channels: red, green, blue and 255. */
  relight(file: Uint8Array, lu: number, lv: number): DecodedImage;
}

export function load(module: BufferSource | WebAssembly.Module): Promise<Reference>;
