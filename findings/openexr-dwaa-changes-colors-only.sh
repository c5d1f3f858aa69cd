#!/usr/bin/env bash
# finding: The lossy OpenEXR compressions DWAA, DWAB and LJ2K change the channels R, G and B of a map with floating-point values, and keep a0 to a5 to the bit.
# software: numpy 2.4.6, OpenEXR 3.5.3
# expected: all nine channels changed, or none; B44A, which is lossy, too, changes none because it compresses half floats only.
# observed: DWAA: a0 a1 a2 a3 a4 a5 equal; B G R changed
# observed: DWAB: a0 a1 a2 a3 a4 a5 equal; B G R changed
# observed: LJ2K: a0 a1 a2 a3 a4 a5 equal; B G R changed
# observed: B44A: B G R a0 a1 a2 a3 a4 a5 equal
# observed: DWAA, the same values named red.a0 and so on: all equal
. "$(dirname "$0")/tools.sh"
python_packages numpy==2.4.6 OpenEXR==3.5.3
cd "$work"
"$python" - <<'PYTHON' | confirm
import numpy, OpenEXR

NAMES = ["a0", "a1", "a2", "a3", "a4", "a5", "R", "G", "B"]
random = numpy.random.default_rng(1)
y, x = numpy.mgrid[:256, :256]
plane = lambda i: (128 + 100 * numpy.sin(x / (9 + i)) * numpy.cos(y / 7) + random.normal(size=x.shape)).astype("f4")
planes = [plane(i) for i in range(9)]


def equal_and_changed(compression, names):
    written = dict(zip(names, planes))
    OpenEXR.File({"compression": compression, "type": OpenEXR.scanlineimage}, dict(written)).write("map.exr")
    read = OpenEXR.File("map.exr", separate_channels=True).channels()
    is_equal = lambda name: numpy.array_equal(read[name].pixels, written[name])
    names = sorted(names)
    return [name for name in names if is_equal(name)], [name for name in names if not is_equal(name)]


for name in ["DWAA", "DWAB", "LJ2K", "B44A"]:
    equal, changed = equal_and_changed(getattr(OpenEXR, name + "_COMPRESSION"), NAMES)
    print(f"{name}: {' '.join(equal)} equal" + (f"; {' '.join(changed)} changed" if changed else ""))
equal, changed = equal_and_changed(OpenEXR.DWAA_COMPRESSION, [f"{color}.a{i}" for color in ("red", "green", "blue") for i in range(3)])
print(f"DWAA, the same values named red.a0 and so on: {'all equal' if not changed else 'changed'}")
PYTHON
