#!/usr/bin/env bash
# finding: jpeg-js decodes a JPEG of 12-bit samples without an error, into an image that has nothing to do with it.
# software: numpy 2.4.6, imagecodecs 2026.3.6, jpeg-js 0.4.4
# expected: an error, or the samples divided by 16: a ramp.
# observed: imagecodecs: uint16, first row 0 to 4000
# observed: jpeg-js: no error, first row is a ramp: false
. "$(dirname "$0")/tools.sh"
python_packages numpy==2.4.6 imagecodecs==2026.3.6
node_packages jpeg-js@0.4.4
cd "$work/node"
cat > run.cjs <<'SCRIPT'
const { width, data } = require('jpeg-js').decode(require('fs').readFileSync('ramp.jpg'))
const row = Array.from({ length: width }, (_, x) => data[4 * x])
console.log(`jpeg-js: no error, first row is a ramp: ${row.every((value, x) => Math.abs(value - 250 * x / (width - 1)) < 10)}`)
SCRIPT
{
    "$python" - <<'PYTHON'
import imagecodecs, numpy

ramp = numpy.tile(numpy.linspace(0, 4000, 64).astype("u2"), (16, 1))
stream = imagecodecs.jpeg_encode(ramp, level=95, bitspersample=12)
open("ramp.jpg", "wb").write(stream)
image = imagecodecs.jpeg_decode(stream)
print(f"imagecodecs: {image.dtype}, first row {round(int(image[0, 0]), -2)} to {round(int(image[0, -1]), -2)}")
PYTHON
    node run.cjs
} | confirm
