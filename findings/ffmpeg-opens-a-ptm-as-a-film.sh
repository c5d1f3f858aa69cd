#!/usr/bin/env bash
# finding: FFmpeg opens a JPEG-compressed PTM as a Motion-JPEG film of nine gray frames, one for each stored plane.
# software: numpy 2.4.6, Pillow 13.0.0, av 18.1.0 (FFmpeg)
# expected: an error, because FFmpeg has no reader for PTM.
# observed: mjpeg: 9 frames of 40 x 30
# observed: means of the frames: 20 40 60 80 100 120 140 160 180
. "$(dirname "$0")/tools.sh"
python_packages numpy==2.4.6 Pillow==13.0.0 av==18.1.0
cd "$work"
"$python" - <<'PYTHON' | confirm
import io
import av
from PIL import Image

streams = []
for plane in range(9):
    out = io.BytesIO()
    Image.new("L", (40, 30), 20 * (plane + 1)).save(out, "JPEG", quality=95)
    streams.append(out.getvalue())
lines = ["PTM_1.2", "PTM_FORMAT_JPEG_LRGB", "40", "30", "1 1 1 1 1 1", "0 0 0 0 0 0", "95", *["0 0 0 0 0 0 0 0 0"] * 3,
         "0 1 2 3 4 5 6 7 8", "-1 -1 -1 -1 -1 -1 -1 -1 -1", " ".join(str(len(stream)) for stream in streams), "0 0 0 0 0 0 0 0 0"]
open("coin.ptm", "wb").write("\n".join(lines).encode() + b"\n" + b"".join(streams))
film = av.open("coin.ptm")
frames = list(film.decode(video=0))
print(f"{film.streams.video[0].codec_context.name}: {len(frames)} frames of {frames[0].width} x {frames[0].height}")
print("means of the frames:", *[round(frame.to_ndarray(format="gray").mean()) for frame in frames])
PYTHON
