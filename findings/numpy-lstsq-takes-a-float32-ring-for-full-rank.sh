#!/usr/bin/env bash
# finding: numpy.linalg.lstsq takes 24 lights on a ring in float32 for rank 6 where the rank is 5, and returns coefficients above 10,000 for images of 0 to 255.
# software: numpy 2.4.6, scipy 1.17.1
# expected: rank 5 and small coefficients of minimum norm, as scipy and numpy in float64 return; lu² + lv² is constant on a ring.
# observed: numpy float64: rank 5, coefficients above 10000: False
# observed: numpy float32: rank 6, coefficients above 10000: True
# observed: scipy float32: rank 5, coefficients above 10000: False
# observed: numpy.linalg.matrix_rank float32: 5
. "$(dirname "$0")/tools.sh"
python_packages numpy==2.4.6 scipy==1.17.1
"$python" - <<'PYTHON' | confirm
import math
import numpy, scipy.linalg

angles = [math.radians(15 * i) for i in range(24)]
radius = math.cos(math.radians(45))
lights = [(radius * math.cos(a), radius * math.sin(a)) for a in angles]
matrix = numpy.array([(u * u, v * v, u * v, u, v, 1) for u, v in lights])
values = numpy.array([128 + 80 * u + 30 * v + (7 * i % 5) for i, (u, v) in enumerate(lights)])
for name, kind, solve in ("numpy", "float64", numpy.linalg.lstsq), ("numpy", "float32", numpy.linalg.lstsq), ("scipy", "float32", scipy.linalg.lstsq):
    options = {"rcond": None} if name == "numpy" else {}
    coefficients, _, rank, _ = solve(matrix.astype(kind), values.astype(kind), **options)
    print(f"{name} {kind}: rank {rank}, coefficients above 10000: {bool(abs(coefficients).max() > 10000)}")
print("numpy.linalg.matrix_rank float32:", numpy.linalg.matrix_rank(matrix.astype("float32")))
PYTHON
