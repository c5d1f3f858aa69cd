#!/usr/bin/env bash
# finding: sharp(...).raw({depth: 'ushort'}) of a 16-bit PNG returns 16-bit samples that hold 8-bit values, unless toColourspace('rgb16') comes first.
# software: sharp 0.35.5, pngjs 7.0.0
# expected: the value 45569, which the file holds.
# observed: raw({depth: 'ushort'}): ushort, 178
# observed: toColourspace('rgb16').raw({depth: 'ushort'}): ushort, 45569
. "$(dirname "$0")/tools.sh"
node_packages sharp@0.35.5 pngjs@7.0.0
cd "$work/node"
cat > run.mjs <<'SCRIPT'
import { PNG } from 'pngjs'
import sharp from 'sharp'

const data = Buffer.alloc(4 * 4 * 6)
for (let at = 0; at < data.length; at += 2) data.writeUInt16LE(45569, at)
const png = PNG.sync.write({ width: 4, height: 4, data }, { bitDepth: 16, colorType: 2, inputColorType: 2, inputHasAlpha: false })
const show = async (name, image) => {
  const { data, info } = await image.toBuffer({ resolveWithObject: true })
  console.log(`${name}: ${info.depth}, ${data.readUInt16LE(0)}`)
}
await show("raw({depth: 'ushort'})", sharp(png).raw({ depth: 'ushort' }))
await show("toColourspace('rgb16').raw({depth: 'ushort'})", sharp(png).toColourspace('rgb16').raw({ depth: 'ushort' }))
SCRIPT
node run.mjs | confirm
