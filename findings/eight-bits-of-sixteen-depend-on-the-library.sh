#!/usr/bin/env bash
# finding: Pillow and pngjs return different 8-bit values for the same 16-bit RGB PNG: one drops the low byte, the other rounds.
# software: numpy 2.4.6, imagecodecs 2026.3.6, Pillow 13.0.0, pngjs 7.0.0
# expected: 16-bit samples, an error, or at least the same 8-bit values everywhere.
# observed: Pillow: mode RGB, value >> 8 for 65536 of 65536 values
# observed: pngjs: round(value / 257) for 65536 of 65536 values
# observed: 16256 values differ
. "$(dirname "$0")/tools.sh"
python_packages numpy==2.4.6 imagecodecs==2026.3.6 Pillow==13.0.0
node_packages pngjs@7.0.0
cd "$work/node"
cat > run.cjs <<'SCRIPT'
const fs = require('fs')
const { data } = require('pngjs').PNG.sync.read(fs.readFileSync('all.png'))
fs.writeFileSync('pngjs.raw', Buffer.from(data.filter((_, at) => at % 4 === 0)))
SCRIPT
"$python" - <<'PYTHON' | confirm
import subprocess
import imagecodecs, numpy
from PIL import Image

values = numpy.arange(65536, dtype="u2").reshape(256, 256)
open("all.png", "wb").write(imagecodecs.png_encode(numpy.dstack([values] * 3)))
image = Image.open("all.png")
pillow = numpy.asarray(image)[..., 0].astype(int).ravel()
print(f"Pillow: mode {image.mode}, value >> 8 for {(pillow == numpy.arange(65536) >> 8).sum()} of 65536 values")
subprocess.run(["node", "run.cjs"], check=True)
pngjs = numpy.fromfile("pngjs.raw", "u1").astype(int)
print(f"pngjs: round(value / 257) for {(pngjs == (numpy.arange(65536) * 2 + 257) // 514).sum()} of 65536 values")
print((pillow != pngjs).sum(), "values differ")
PYTHON
