import type { Case, DecodedImage, Refusals } from "./index.js";
export { Malformed, Unsupported } from "./index.js";

/** Final coefficients as numbers, in the order of the samples of a DecodedImage. */
export interface Coefficients {
  width: number;
  height: number;
  channels: number;
  samples: Float32Array | Float64Array;
}

export interface Decoders {
  raw?: (file: Uint8Array) => DecodedImage | Promise<DecodedImage>;
  coef?: (file: Uint8Array) => Coefficients | Promise<Coefficients>;
  rgb?: (file: Uint8Array, lu: number, lv: number) => DecodedImage | Promise<DecodedImage>;
}

export interface Checked {
  /** The exit status of `ptm-conform check`: 0 passed, 1 failed, 3 not a decoder. */
  status: number;
  /** Its output: causes, examples and scores. */
  text: string;
  /** The report, in the format of spec-cases/schema/report.schema.json. */
  report: { verdict: string; diagnoses: object[]; cases: { id: string; outcome: string; says?: string }[] };
}

export function program(): string;
export function cases(): Case[];
export function check(functions: Decoders | NonNullable<Decoders["raw"]>, options?: Refusals & { options?: string[] }): Promise<Checked>;
