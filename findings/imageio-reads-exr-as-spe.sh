#!/usr/bin/env bash
# finding: imageio without an OpenEXR plugin reads an OpenEXR file as a film of one-pixel frames in the format SPE.
# software: numpy 2.4.6, Pillow 13.0.0, imageio 2.38.1, OpenEXR 3.5.3
# expected: an error, because no installed plugin reads OpenEXR.
# observed: written: 200 x 200
# observed: imageio returns float32 of shape (24744, 1, 1)
. "$(dirname "$0")/tools.sh"
python_packages numpy==2.4.6 Pillow==13.0.0 imageio==2.38.1 OpenEXR==3.5.3
cd "$work"
"$python" -W ignore - <<'PYTHON' | confirm
import imageio.v3, numpy, OpenEXR

gradient = numpy.dstack([numpy.tile(numpy.linspace(0, 1, 200, dtype="f4"), (200, 1))] * 3)
header = {"compression": OpenEXR.NO_COMPRESSION, "type": OpenEXR.scanlineimage}
OpenEXR.File(header, {"RGB": gradient}).write("gradient.exr")
print("written: 200 x 200")
image = imageio.v3.imread("gradient.exr")
print("imageio returns", image.dtype, "of shape", image.shape)
PYTHON
