/** A decoded file: the stored values, texel after texel, top row first. */
export interface Picture {
  width: number;
  height: number;
  /** 18 for RGB, 9 for LRGB and the tables, 8 for LUM. */
  channels: number;
  samples: Uint8Array | Uint8ClampedArray;
}

/** A case of cases.json. */
export interface Case {
  id: string;
  format: string;
  expect: "decode" | "reject" | "refuse" | "lenient" | "robust" | "spelling";
  because: string;
  clauses: string[];
  ruling?: string;
  /** The valid file from which this one is one edit away. */
  twin?: string;
  /** The file, in base64. */
  file: string;
  /** The right answer; slack and samples in base64. */
  raw?: { width: number; height: number; channels: number; samples: string; slack?: string; shows?: string[] };
}

export interface Result {
  id: string;
  outcome: "pass" | "fail" | "unsupported" | "inconclusive" | "not judged";
  says: string;
  clauses: string[];
  because: string;
}

export interface Results {
  /** Whether no case failed and at least one file was decoded. */
  passed: boolean;
  results: Result[];
  failures: Result[];
}

type Thrown = new (...args: never[]) => Error;

export interface Refusals {
  /** What the decoder throws for a malformed file; Malformed by default. */
  malformed?: Thrown;
  /** What it throws for a kind of file that it does not read; Unsupported by default. */
  unsupported?: Thrown;
}

export class Malformed extends Error {}
export class Unsupported extends Error {}
export function bytesOf(base64: string): Uint8Array;
export function run(cases: Case[], decode: (file: Uint8Array) => Picture | Promise<Picture>, options?: Refusals): Promise<Results>;
