#!/usr/bin/env bash
# finding: cv2.solve with DECOMP_QR returns True and NaN for lights on a line, where DECOMP_SVD returns a solution.
# software: numpy 2.4.6, opencv-python-headless 5.0.0.93
# expected: False, or a solution; the return value says whether the system was solved.
# observed: DECOMP_SVD: True, finite: True
# observed: DECOMP_QR: True, finite: False
. "$(dirname "$0")/tools.sh"
python_packages numpy==2.4.6 opencv-python-headless==5.0.0.93
"$python" - <<'PYTHON' | confirm
import cv2, numpy

line = [i / 10 - 0.5 for i in range(11)]
matrix = numpy.array([(u * u, 0, 0, u, 0, 1) for u in line])
values = numpy.array([[100 + 50 * u] for u in line])
for name in "DECOMP_SVD", "DECOMP_QR":
    solved, coefficients = cv2.solve(matrix, values, flags=getattr(cv2, name))
    print(f"{name}: {solved}, finite: {bool(numpy.isfinite(coefficients).all())}")
PYTHON
