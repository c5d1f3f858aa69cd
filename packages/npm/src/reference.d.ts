import type { Picture } from "./index.js";

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
  /** The stored values; throws Malformed or Unsupported where there is no map. */
  decode(file: Uint8Array): Picture;
  lint(file: Uint8Array): Finding[];
  /** As spec-cases/schema/inspect.schema.json describes it. */
  inspect(file: Uint8Array): object;
  /** Four channels: red, green, blue and 255. */
  relight(file: Uint8Array, lu: number, lv: number): Picture;
}

export function load(module: BufferSource | WebAssembly.Module): Promise<Reference>;
