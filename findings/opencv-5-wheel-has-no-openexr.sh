#!/usr/bin/env bash
# finding: cv2.imread of the OpenCV 5 wheel returns None for an OpenEXR file that the wheel of 4.12 reads.
# software: OpenEXR 3.5.3; opencv-python-headless 4.12.0.88 with numpy 2.2.6, and 5.0.0.93 with numpy 2.4.6
# expected: the image in both, with OPENCV_IO_ENABLE_OPENEXR=1.
# observed: 4.12.0: (8, 8, 3)
# observed: 5.0.0: None
. "$(dirname "$0")/tools.sh"
export OPENCV_IO_ENABLE_OPENEXR=1
cd "$work"
cat > run.py <<'PYTHON'
import cv2, numpy, OpenEXR

channels = {name: numpy.full((8, 8), 0.5, "f4") for name in "RGB"}
OpenEXR.File({"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}, channels).write("plain.exr")
image = cv2.imread("plain.exr", cv2.IMREAD_UNCHANGED)
print(cv2.__version__.split("-")[0] + ":", None if image is None else image.shape)
PYTHON
python_packages numpy==2.2.6 OpenEXR==3.5.3 opencv-python-headless==4.12.0.88
"$python" run.py > lines 2> errors
"$python" -m pip install -q numpy==2.4.6 opencv-python-headless==5.0.0.93 > "$work/log" 2>&1 || missing "pip cannot install OpenCV 5"
"$python" run.py >> lines 2>> errors
confirm < lines
