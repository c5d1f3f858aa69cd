/** A decoded file: the samples of each texel, top row first. */
export interface DecodedImage {
  width: number;
  height: number;
  /** 18 for RGB, 9 for LRGB and the table formats, 8 for LUM. */
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
  /** The id of the valid file that differs from this one in a single edit. */
  twin?: string;
  /** The file, in base64. */
  file: string;
  /** The expected values. Samples and slack (the tolerance of each sample) are in base64. */
  raw?: { width: number; height: number; channels: number; samples: string; slack?: string; shows?: string[] };
}

export interface Result {
  id: string;
  outcome: "pass" | "fail" | "known failure" | "unsupported" | "inconclusive" | "not judged";
  says: string;
  clauses: string[];
  because: string;
}

export interface Results {
  /** True if no case failed and at least one file was decoded. */
  passed: boolean;
  results: Result[];
  failures: Result[];
}

type Thrown = new (...args: never[]) => Error;

export interface Refusals {
  /** The error that the decoder throws for a malformed file. The default is Malformed. */
  malformed?: Thrown;
  /** The error that the decoder throws for an unsupported file. The default is Unsupported. */
  unsupported?: Thrown;
}

export interface RunOptions extends Refusals {
  /** The ids of known failures. They do not make the run fail, but a known failure that passes does. */
  known?: Iterable<string>;
}

export class Malformed extends Error {}
export class Unsupported extends Error {}
export function fromBase64(base64: string): Uint8Array;
export function run(cases: Case[], decode: (file: Uint8Array) => DecodedImage | Promise<DecodedImage>, options?: RunOptions): Promise<Results>;
