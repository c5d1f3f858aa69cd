// The cases as data, and a judge of a JavaScript decoder: in Node, in a browser, in a worker. Nothing here does any I/O.

/** The file breaks a rule of the format. */
export class Malformed extends Error {}
/** The file may be sound, but it is not read. */
export class Unsupported extends Error {}

/** The bytes that base64 stands for. */
export function bytesOf(base64) {
  return Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));
}

/** Returns the result of the decoder for a file: an image, "malformed", "unsupported", or the error. */
async function observe(decode, file, { malformed = Malformed, unsupported = Unsupported }) {
  try {
    const picture = await decode(file);
    const fault = faultOf(picture);
    return fault ? { fault } : { picture };
  } catch (error) {
    if (error instanceof malformed) return { refused: "malformed" };
    if (error instanceof unsupported) return { refused: "unsupported" };
    return { fault: `crash: ${error}` };
  }
}

function faultOf(picture) {
  const { width, height, channels, samples } = picture ?? {};
  if (![width, height, channels].every(Number.isInteger)) return "no picture: width, height and channels are integers";
  if (!(samples instanceof Uint8Array || samples instanceof Uint8ClampedArray)) return "its samples are no Uint8Array";
  const needed = width * height * channels;
  return samples.length === needed ? null : `${width} x ${height} x ${channels} need ${needed} samples, there are ${samples.length}`;
}

/** Where a picture is first wrong, in words; null where it is right. */
function difference(raw, picture) {
  for (const key of ["width", "height", "channels"]) {
    if (picture[key] !== raw[key]) return `${key} ${picture[key]}, expected ${raw[key]}`;
  }
  const right = bytesOf(raw.samples), slack = raw.slack ? bytesOf(raw.slack) : null;
  const wrong = (i) => {
    // Around the circle of 256 values, where inverse DCTs may differ.
    const apart = Math.abs(right[i] - picture.samples[i]);
    return Math.min(apart, 256 - apart) > (slack ? slack[i] : 0) && apart > 0;
  };
  for (let i = 0; i < right.length; i++) {
    if (!wrong(i)) continue;
    const start = i - (i % raw.channels), texel = start / raw.channels;
    const values = (samples) => Array.from(samples.slice(start, start + raw.channels)).join(" ");
    const place = `(${texel % raw.width}, ${Math.floor(texel / raw.width)})`;
    return `texel ${place}, first in channel ${i % raw.channels}: expected ${values(right)}, received ${values(picture.samples)}`;
  }
  return null;
}

/** The verdict on one case; `seen` knows what the decoder made of every file. */
function judge(entry, seen) {
  const { picture, refused, fault } = seen.get(entry.id);
  if (fault) return ["fail", fault];
  const twin = entry.twin && seen.get(entry.twin);
  if (twin && !twin.picture) return ["inconclusive", "the valid twin was not decoded"];
  const wrong = picture && entry.raw ? difference(entry.raw, picture) : null;
  switch (entry.expect) {
    case "reject":
    case "refuse":
      if (picture) return ["fail", "decoded a file that must be refused"];
      if (refused === "malformed" || entry.expect === "refuse") return ["pass", ""];
      return ["fail", "answers unsupported to a malformed file"];
    case "robust":
      return ["pass", ""];
    case "lenient":
      return wrong ? ["fail", wrong] : ["pass", ""];
    case "spelling":
      if (refused) return ["not judged", "one of several spellings"];
      return wrong ? ["fail", wrong] : ["pass", ""];
    default:
      if (refused === "unsupported") return ["unsupported", ""];
      if (refused) return ["fail", "refused a legal file"];
      if (wrong && entry.raw.shows) return ["not judged", `another reading of ${entry.raw.shows.join(", ")} may give this`];
      return wrong ? ["fail", wrong] : ["pass", ""];
  }
}

/**
 * Runs cases against `decode(file: Uint8Array) => { width, height, channels, samples: Uint8Array }`, the stored values, top
 * row first. It may return a promise.
 */
export async function run(cases, decode, options = {}) {
  const seen = new Map();
  for (const entry of cases) seen.set(entry.id, await observe(decode, bytesOf(entry.file), options));
  const results = cases.map((entry) => {
    const [outcome, says] = judge(entry, seen);
    const { id, clauses, because } = entry;
    return { id, outcome, says, clauses, because };
  });
  const failures = results.filter(({ outcome }) => outcome === "fail");
  return { passed: failures.length === 0 && [...seen.values()].some(({ picture }) => picture), results, failures };
}
