#!/usr/bin/env bash
# finding: The Rust crate image writes TGA packets that extend over several rows; Pillow reads them if they list pixels, but not if they repeat one.
# software: image 0.25.10 (Rust), Pillow 13.0.0
# expected: packets that end with their row, as TGA 2.0 asks, or a reader that accepts longer ones.
# observed: 5 x 4 pixels of one color: packets of 20 pixels; Pillow: OSError: buffer overrun when reading image file
# observed: 5 x 4 different pixels: packets of 1, 19 pixels; Pillow: equal
# observed: without run lengths: Pillow: equal, equal
. "$(dirname "$0")/tools.sh"
python_packages Pillow==13.0.0
rust_program 'image = { version = "=0.25.10", default-features = false, features = ["tga"] }' <<'RUST'
use image::{codecs::tga::TgaEncoder, ExtendedColorType::Rgb8};
fn main() {
    let one: Vec<u8> = [172, 219, 158].repeat(20);
    let different: Vec<u8> = (0..60).map(|i| (i * 37 % 251) as u8).collect();
    for (name, pixels) in [("one", one), ("different", different)] {
        let mut runs = Vec::new();
        TgaEncoder::new(&mut runs).encode(&pixels, 5, 4, Rgb8).unwrap();
        let mut plain = Vec::new();
        TgaEncoder::new(&mut plain).disable_rle().encode(&pixels, 5, 4, Rgb8).unwrap();
        for (kind, file) in [("runs", runs), ("plain", plain), ("raw", pixels)] {
            std::fs::write(format!("{name}.{kind}"), file).unwrap();
        }
    }
}
RUST
(cd "$work/rust" && cargo run --quiet)
cd "$work/rust"
"$python" - <<'PYTHON' | confirm
from PIL import Image

def pillow(name, kind):
    try:
        image = Image.open(f"{name}.{kind}", formats=["TGA"]).convert("RGB")
        return "equal" if image.tobytes() == open(f"{name}.raw", "rb").read() else "different"
    except OSError as error:
        return f"{type(error).__name__}: {error}"

for name, title in (("one", "5 x 4 pixels of one color"), ("different", "5 x 4 different pixels")):
    data, at, lengths = open(f"{name}.runs", "rb").read(), 18, []
    while sum(lengths) < 20:
        lengths.append((data[at] & 127) + 1)
        at += 4 if data[at] & 128 else 1 + 3 * lengths[-1]
    print(f"{title}: packets of {', '.join(map(str, lengths))} pixels; Pillow: {pillow(name, 'runs')}")
print(f"without run lengths: Pillow: {pillow('one', 'plain')}, {pillow('different', 'plain')}")
PYTHON
