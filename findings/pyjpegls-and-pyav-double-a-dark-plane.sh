#!/usr/bin/env bash
# finding: A plane below 128 that pyjpegls writes comes back doubled from PyAV, because one writes 7 bits and the other scales 7 bits to 8.
# software: numpy 2.4.6, pyjpegls 1.5.1, av 18.1.0, imagecodecs 2026.3.6
# expected: JPEG-LS without loss returns the samples that went in.
# observed: pyjpegls writes precision 7
# observed: imagecodecs: 0 1 2 60 126 127
# observed: PyAV: 0 2 4 120 252 254
. "$(dirname "$0")/tools.sh"
python_packages numpy==2.4.6 pyjpegls==1.5.1 av==18.1.0 imagecodecs==2026.3.6
"$python" - <<'PYTHON' | confirm
import av, imagecodecs, jpeg_ls, numpy

plane = (numpy.arange(32 * 24) % 128).astype("u1").reshape(24, 32)
stream = bytes(jpeg_ls.encode(plane))
print("pyjpegls writes precision", stream[stream.index(b"\xff\xf7") + 4])
codec = av.CodecContext.create("jpegls", "r")
frame = (codec.decode(av.Packet(stream)) + codec.decode(None))[0]
shown = [0, 1, 2, 60, 126, 127]
print("imagecodecs:", *imagecodecs.jpegls_decode(stream).ravel()[shown])
print("PyAV:", *frame.to_ndarray(format="gray").ravel()[shown])
PYTHON
