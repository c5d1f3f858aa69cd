#!/usr/bin/env bash
# finding: zenjpeg puts the blocks of a gray JPEG in wrong places, without an error, if its component has a vertical sampling factor of 2.
# software: zenjpeg 0.8.4 (Rust), zune-jpeg 0.5.15 (Rust), Pillow 13.0.0 (libjpeg-turbo)
# expected: the same samples for all factors, because a scan of one component has its blocks row by row (ITU-T T.81, A.2.2).
# observed: factors 1 x 1: Pillow 0, zune-jpeg 0, zenjpeg 0 wrong samples of 960
# observed: factors 2 x 1: Pillow 0, zune-jpeg 0, zenjpeg 0 wrong samples of 960
# observed: factors 1 x 2: Pillow 0, zune-jpeg 0, zenjpeg 512 wrong samples of 960
# observed: factors 2 x 2: Pillow 0, zune-jpeg 0, zenjpeg 448 wrong samples of 960
. "$(dirname "$0")/tools.sh"
python_packages Pillow==13.0.0
rust_program 'zenjpeg = "=0.8.4"' 'enough = "=0.4.5"' 'zune-jpeg = "=0.5.15"' 'zune-core = "=0.5.3"' <<'RUST'
use zenjpeg::decoder::{Decoder, PixelFormat};
use zune_core::{bytestream::ZCursor, colorspace::ColorSpace, options::DecoderOptions};
use zune_jpeg::JpegDecoder;

fn main() {
    for name in std::env::args().skip(1) {
        let stream = std::fs::read(&name).unwrap();
        let image = Decoder::new().output_format(PixelFormat::Gray).decode(&stream, enough::Unstoppable).unwrap();
        std::fs::write(format!("{name}.zenjpeg"), image.pixels_u8().unwrap()).unwrap();
        let gray = DecoderOptions::default().jpeg_set_out_colorspace(ColorSpace::Luma);
        let plane = JpegDecoder::new_with_options(ZCursor::new(&stream), gray).decode().unwrap();
        std::fs::write(format!("{name}.zune-jpeg"), plane).unwrap();
    }
}
RUST
cd "$work/rust"
"$python" - <<'PYTHON'
import io
from PIL import Image

# One gray level for each block of 8 x 8, so that every decoder returns it exactly.
samples = bytes(30 * (x // 8) + 10 * (y // 8) + 40 for y in range(24) for x in range(40))
open("samples", "wb").write(samples)
out = io.BytesIO()
Image.frombytes("L", (40, 24), samples).save(out, "JPEG", quality=100)
stream = bytearray(out.getvalue())
factors = stream.index(b"\xff\xc0") + 11
for name in ("11", "21", "12", "22"):
    stream[factors] = int(name, 16)
    open(name, "wb").write(stream)
PYTHON
cargo run --quiet -- 11 21 12 22
"$python" - <<'PYTHON' | confirm
from PIL import Image

right = open("samples", "rb").read()
for name in ("11", "21", "12", "22"):
    planes = [("Pillow", Image.open(name).tobytes())]
    planes += [(library, open(f"{name}.{library}", "rb").read()) for library in ("zune-jpeg", "zenjpeg")]
    counts = [f"{library} {sum(a != b for a, b in zip(plane, right))}" for library, plane in planes]
    print(f"factors {name[0]} x {name[1]}: {', '.join(counts)} wrong samples of {len(right)}")
PYTHON
