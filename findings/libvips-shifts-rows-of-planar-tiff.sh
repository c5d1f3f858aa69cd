#!/usr/bin/env bash
# finding: libvips reads a TIFF of five separate planes (PlanarConfiguration 2, MinIsBlack) wrongly from the second row on, without an error.
# software: numpy 2.4.6, tifffile 2026.3.3, pyvips 3.2.0, pyvips-binary 8.18.7
# expected: every texel of the last row holds its own five values, as tifffile reads them.
# observed: tifffile, first row: 10 20 30 40 50; last row: 10 20 30 40 50
# observed: libvips, first row: 10 20 30 40 50; last row: 43 53 14 24 34
. "$(dirname "$0")/tools.sh"
python_packages numpy==2.4.6 tifffile==2026.3.3 pyvips==3.2.0 pyvips-binary==8.18.7
cd "$work"
"$python" - <<'PYTHON' | confirm
import numpy, pyvips, tifffile

planes = numpy.zeros((5, 4, 6), "u1")
planes[:] = 10 * numpy.arange(1, 6)[:, None, None] + numpy.arange(6)
tifffile.imwrite("planes.tif", planes, photometric="minisblack", planarconfig="separate")
for name, image in ("tifffile", numpy.moveaxis(tifffile.imread("planes.tif"), 0, 2)), ("libvips", pyvips.Image.new_from_file("planes.tif").numpy()):
    print(name + ", first row: " + " ".join(map(str, image[0, 0])) + "; last row: " + " ".join(map(str, image[3, 0])))
PYTHON
