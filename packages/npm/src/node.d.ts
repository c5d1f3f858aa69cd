import type { Case, Picture, Refusals } from "./index.js";
export { Malformed, Unsupported } from "./index.js";

/** Coefficients as plain numbers, in the order of a Picture's samples. */
export interface Coefficients {
  width: number;
  height: number;
  channels: number;
  samples: Float32Array | Float64Array;
}

export interface Decoders {
  raw?: (file: Uint8Array) => Picture | Promise<Picture>;
  coef?: (file: Uint8Array) => Coefficients | Promise<Coefficients>;
  rgb?: (file: Uint8Array, lu: number, lv: number) => Picture | Promise<Picture>;
}

export interface Checked {
  /** The exit status of `ptm-conform check`: 0 passes, 1 fails, 3 is not a decoder. */
  status: number;
  /** What it prints: causes, examples, scores. */
  text: string;
  /** The report, as spec-cases/schema/report.schema.json describes it. */
  report: { verdict: string; diagnoses: object[]; cases: { id: string; outcome: string; says?: string }[] };
}

export function program(): string;
export function cases(): Case[];
export function check(functions: Decoders | NonNullable<Decoders["raw"]>, options?: Refusals & { options?: string[] }): Promise<Checked>;
