#!/usr/bin/env bash
# finding: Magika calls a JPEG-compressed PTM a JPEG image with high confidence, and puremagic calls every PTM an OS/2 pointer.
# software: numpy 2.4.6, Pillow 13.0.0, magika 1.0.3, puremagic 1.30
# expected: unknown, or the name of the format, whose files begin with "PTM_1.2".
# observed: magika, JPEG_LRGB: jpeg, score above 0.95: True
# observed: puremagic, JPEG_LRGB: OS/2 pointer
# observed: puremagic, LRGB: OS/2 pointer
. "$(dirname "$0")/tools.sh"
python_packages numpy==2.4.6 Pillow==13.0.0 magika==1.0.3 puremagic==1.30
cd "$work"
"$python" - 2> "$work/errors" <<'PYTHON' | confirm
import io
import random
import magika, puremagic
from PIL import Image

random.seed(1)
out = io.BytesIO()
Image.frombytes("L", (37, 29), bytes((x + y) % 256 for y in range(29) for x in range(37))).save(out, "JPEG")
stream = out.getvalue()
lines = ["PTM_1.2", "PTM_FORMAT_JPEG_LRGB", "37", "29", "1 1 1 1 1 1", "0 0 0 0 0 0", "75", *["0 0 0 0 0 0 0 0 0"] * 3,
         "0 1 2 3 4 5 6 7 8", "-1 -1 -1 -1 -1 -1 -1 -1 -1", " ".join([str(len(stream))] * 9), "0 0 0 0 0 0 0 0 0"]
compressed = "\n".join(lines).encode() + b"\n" + stream * 9
plain = b"PTM_1.2\nPTM_FORMAT_LRGB\n37\n29\n1 1 1 1 1 1\n0 0 0 0 0 0\n" + random.randbytes(37 * 29 * 9)
result = magika.Magika().identify_bytes(compressed)
print(f"magika, JPEG_LRGB: {result.output.label}, score above 0.95: {result.score > 0.95}")
for name, data in ("JPEG_LRGB", compressed), ("LRGB", plain):
    print(f"puremagic, {name}: {puremagic.magic_string(data)[0].name}")
PYTHON
