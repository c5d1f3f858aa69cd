#!/usr/bin/env bash
# finding: Of the compressions without loss that tifffile offers for floating-point coefficients, JPEG XR changes values a little, and LERC with a predictor destroys them; there is no error.
# software: numpy 2.4.6, tifffile 2026.3.3, imagecodecs 2026.3.6
# expected: the values that were written, or an error when writing.
# observed: exact without predictor: deflate, jpegxl, lzma, lzw, packbits, zlib, zstd
# observed: cannot use predictor with <COMPRESSION.JPEGXL: 50002>
# observed: exact with predictor: deflate, lzma, lzw, packbits, zlib, zstd
# observed: jpegxr: 8-bit samples exact: True; float32 exact: False, off by less than 0.01: True
# observed: lerc: float32 exact: True; with predictor exact: False, off by more than 1000: True
. "$(dirname "$0")/tools.sh"
python_packages numpy==2.4.6 tifffile==2026.3.3 imagecodecs==2026.3.6
cd "$work"
"$python" - <<'PYTHON' | confirm
import numpy, tifffile

y, x = numpy.mgrid[:64, :80]
coefficients = numpy.stack([100 * numpy.sin(x / 9 + i) * numpy.cos(y / 7) for i in range(9)])
floats, stored = coefficients.astype("f4"), (128 + coefficients).astype("u1")


def largest_error(values, compression, predictor=None):
    tifffile.imwrite("map.tif", values, photometric="minisblack", planarconfig="separate", compression=compression, predictor=predictor)
    return float(abs(tifffile.imread("map.tif").astype("f8") - values).max())


for predictor in (None, True):
    exact = []
    for name in ("deflate", "jpegxl", "lzma", "lzw", "packbits", "zlib", "zstd"):
        try:
            if largest_error(floats, name, predictor) == 0:
                exact.append(name)
        except ValueError as error:
            print(error)
    print(f"exact {'with' if predictor else 'without'} predictor: {', '.join(exact)}")
error = largest_error(floats, "jpegxr")
print(f"jpegxr: 8-bit samples exact: {largest_error(stored, 'jpegxr') == 0}; float32 exact: {error == 0}, off by less than 0.01: {error < 0.01}")
plain, error = largest_error(floats, "lerc"), largest_error(floats, "lerc", True)
print(f"lerc: float32 exact: {plain == 0}; with predictor exact: {error == 0}, off by more than 1000: {error > 1000}")
PYTHON
