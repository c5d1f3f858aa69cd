#!/usr/bin/env bash
# finding: sharp accepts coefficients in a Float32Array and returns floats, but takes them for 16-bit samples: 0 for all below 0, no fractions, and 8 bits unless toColourspace('grey16') is called.
# software: sharp 0.35.5
# expected: the same values, because the input and the output are floats.
# observed: coefficients: -300 -0.5 0.25 127.5 255 256 1000 70000
# observed: raw({depth: 'float'}): 0 0 0 0 0 1 3 255
# observed: toColourspace('b-w'), raw: 0 0 0 0 1 1 4 255
# observed: toColourspace('grey16'), raw: 0 0 0 127 255 256 1000 65535
# observed: tiff(), a file of uchar: 0 0 0 0 0 1 3 255
. "$(dirname "$0")/tools.sh"
node_packages sharp@0.35.5
cd "$work/node"
cat > floats.mjs <<'NODE'
import sharp from 'sharp';

const coefficients = Float32Array.of(-300, -0.5, 0.25, 127.5, 255, 256, 1000, 70000);
const width = coefficients.length;
const image = () => sharp(coefficients, { raw: { width, height: 1, channels: 1 } });

// Returns the first channel of an image, as floats.
async function floats(image) {
  const { data, info } = await image.raw({ depth: 'float' }).toBuffer({ resolveWithObject: true });
  const all = new Float32Array(data.buffer, data.byteOffset, data.length / 4);
  return all.filter((_, i) => i % info.channels === 0).join(' ');
}

const file = await image().tiff({ compression: 'none' }).toBuffer();
const { depth } = await sharp(file).metadata();
for (const [name, values] of [
  ['coefficients', coefficients.join(' ')],
  ["raw({depth: 'float'})", await floats(image())],
  ["toColourspace('b-w'), raw", await floats(image().toColourspace('b-w'))],
  ["toColourspace('grey16'), raw", await floats(image().toColourspace('grey16'))],
  [`tiff(), a file of ${depth}`, await floats(sharp(file))],
]) console.log(`${name}: ${values}`);
NODE
node floats.mjs | confirm
