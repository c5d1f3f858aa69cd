// Judges a JavaScript decoder with the cases as data, in Node, a browser or a worker. This module does no I/O.

/** The file breaks a rule of the format. */
export class Malformed extends Error {}
/** The file may be valid, but the decoder does not support it. */
export class Unsupported extends Error {}

/** Decodes base64. */
export function fromBase64(base64) {
  return Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));
}

/** Classes that say nothing about a file, because nearly every error belongs to them. */
const CATCH_ALL = [Error, Object];

/** Throws an error if a class of refusals would also catch accidental errors. */
export function rejectCatchAll(classes) {
  for (const [name, kind] of Object.entries(classes)) {
    if (CATCH_ALL.includes(kind)) {
      throw new TypeError(`${name}: ${kind.name} is the class of nearly every error, so an accidental error would count as a refusal; define a class of your own`);
    }
  }
}

/** Returns "malformed", "unsupported" or null. If an error belongs to both classes, the more specific one counts. */
export function refusal(error, { malformed, unsupported }) {
  const isMalformed = error instanceof malformed, isUnsupported = error instanceof unsupported;
  if (isMalformed && isUnsupported) return unsupported.prototype instanceof malformed ? "unsupported" : "malformed";
  return isMalformed ? "malformed" : isUnsupported ? "unsupported" : null;
}

/** Describes an error: its class, its message and the line that threw it. A class that is not built in may be a refusal. */
export function describeError(error, { isDeclared = true } = {}) {
  if (!(error instanceof Error)) return String(error);
  const name = error.constructor.name || error.name;
  const place = /\n\s+at .*?([^/\\(]+:\d+):\d+\)?/.exec(error.stack ?? "");
  const text = `${name}: ${error.message}` + (place ? ` (${place[1]})` : "");
  const isBuiltIn = globalThis[name] === error.constructor;
  return isDeclared || isBuiltIn ? text : `${text}\n${name} is declared neither as malformed nor as unsupported`;
}

/** Returns the result of the decoder for a file: an image, a refusal ("malformed" or "unsupported") with its message, or the error. */
async function observe(decode, file, { malformed, unsupported }) {
  try {
    const image = await decode(file);
    const fault = findFault(image);
    return fault ? { fault } : { image };
  } catch (error) {
    const refused = refusal(error, { malformed, unsupported });
    const why = describeError(error, { isDeclared: refused !== null });
    return refused ? { refused, why } : { fault: `crash: ${why}` };
  }
}

function findFault(image) {
  const { width, height, channels, samples } = image ?? {};
  if (![width, height, channels].every(Number.isInteger)) return "not an image: width, height and channels must be integers";
  if (!(samples instanceof Uint8Array || samples instanceof Uint8ClampedArray)) return "the samples must be a Uint8Array";
  const needed = width * height * channels;
  return samples.length === needed ? null : `${width} x ${height} x ${channels} need ${needed} samples, found ${samples.length}`;
}

/** Describes the first difference from the expected values. Returns null if there is none. */
function difference(raw, image) {
  for (const key of ["width", "height", "channels"]) {
    if (image[key] !== raw[key]) return `${key} ${image[key]}, expected ${raw[key]}`;
  }
  const right = fromBase64(raw.samples), slack = raw.slack ? fromBase64(raw.slack) : null;
  const wrong = (i) => {
    // The distance modulo 256, because predicted values wrap around.
    const apart = Math.abs(right[i] - image.samples[i]);
    return Math.min(apart, 256 - apart) > (slack ? slack[i] : 0) && apart > 0;
  };
  for (let i = 0; i < right.length; i++) {
    if (!wrong(i)) continue;
    const start = i - (i % raw.channels), texel = start / raw.channels;
    const values = (samples) => Array.from(samples.slice(start, start + raw.channels)).join(" ");
    const place = `(${texel % raw.width}, ${Math.floor(texel / raw.width)})`;
    return `texel ${place}, first in channel ${i % raw.channels}: expected ${values(right)}, received ${values(image.samples)}`;
  }
  return null;
}

/** Returns the verdict on a case. `seen` contains the answer of the decoder to every file. */
function judge(entry, seen) {
  const { image, refused, why, fault } = seen.get(entry.id);
  if (fault) return ["fail", fault];
  if (entry.twin && !seen.get(entry.twin)?.image) return ["inconclusive", "the valid twin was not decoded"];
  const wrong = image && entry.raw ? difference(entry.raw, image) : null;
  switch (entry.expect) {
    case "reject":
    case "refuse":
      if (image) return ["fail", "decoded a file that must be refused"];
      if (refused === "malformed" || entry.expect === "refuse") return ["pass", ""];
      return ["fail", `answered unsupported to a malformed file: ${why}`];
    case "robust":
      return ["pass", ""];
    case "lenient":
      return wrong ? ["fail", wrong] : ["pass", ""];
    case "spelling":
      if (refused) return ["not judged", "one of several spellings"];
      return wrong ? ["fail", wrong] : ["pass", ""];
    default:
      if (refused === "unsupported") return ["unsupported", ""];
      if (refused) return ["fail", `refused a legal file: ${why}`];
      if (wrong && entry.raw.shows) return ["not judged", `another reading of ${entry.raw.shows.join(", ")} may give this`];
      return wrong ? ["fail", wrong] : ["pass", ""];
  }
}

/**
 * Runs cases against `decode(file: Uint8Array) => { width, height, channels, samples: Uint8Array }`, which returns the
 * stored values, top row first, or a promise of them. `known` contains the ids of known failures: they do not make the run
 * fail, but a known failure that passes does.
 */
export async function run(cases, decode, { malformed = Malformed, unsupported = Unsupported, known = [] } = {}) {
  rejectCatchAll({ malformed, unsupported });
  const seen = new Map(), listed = new Set(known);
  for (const entry of cases) seen.set(entry.id, await observe(decode, fromBase64(entry.file), { malformed, unsupported }));
  const results = cases.map((entry) => {
    let [outcome, says] = judge(entry, seen);
    if (listed.has(entry.id) && outcome === "fail") outcome = "known failure";
    if (listed.has(entry.id) && outcome === "pass") [outcome, says] = ["fail", "it is listed as a known failure, but passes"];
    const { id, clauses, because } = entry;
    return { id, outcome, says, clauses, because };
  });
  if (![...seen.values()].some(({ image }) => image)) {
    const says = "the decoder decodes no file; if it throws classes of its own, pass them as malformed and unsupported";
    results.unshift({ id: "decodes-a-file", outcome: "fail", says, clauses: [], because: "A decoder decodes at least one file." });
  }
  const failures = results.filter(({ outcome }) => outcome === "fail");
  return { passed: failures.length === 0, results, failures };
}
