#!/usr/bin/env python3
"""A PTM decoder whose JPEG planes are decoded by nvJPEG, in torchvision. It answers PTM-CP 1.

    nvjpeg_planes.py VIEW FILE | serve | capabilities

Needs torch with CUDA, torchvision and an NVIDIA GPU; ends with status 77 if one is missing. nvJPEG decodes color streams, sampling factors
above 1, and 16-bit quantization tables without an error, but not as gray planes or not correctly. So the headers are read first.
"""

import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "decoders"))
import ptm_decoder


def missing():
    """Returns what is missing, or None."""
    try:
        import torch
        import torchvision
    except ImportError as what:
        return f"{what.name} is not installed"
    return None if torch.cuda.is_available() else "torch finds no CUDA device"


def check_headers(stream, width, height):
    """Raises an error for streams that nvJPEG would decode to something else than a plane of the map."""
    at = 2
    while at + 4 <= len(stream) and stream[at] == 0xFF and stream[at + 1] != 0xDA:
        marker, length = stream[at + 1], int.from_bytes(stream[at + 2:at + 4], "big")
        body = stream[at + 4:at + 2 + length]
        if marker == 0xFF:
            at += 1                                    # a fill byte
            continue
        if marker == 0xDB and body and body[0] >> 4:
            raise ptm_decoder.Unsupported("16-bit quantization tables")
        if marker in (0xC0, 0xC1):
            if body[:6] != bytes([8]) + height.to_bytes(2, "big") + width.to_bytes(2, "big") + bytes([1]):
                raise ptm_decoder.Malformed("not one component of 8 bits and the size of the map")
            if body[7:8] != b"\x11":
                raise ptm_decoder.Unsupported("sampling factors above 1")
            return
        at += 2 + length
    raise ptm_decoder.Malformed("no sequential frame")


def decode(stream, width, height):
    import torch
    from torchvision.io import ImageReadMode, decode_jpeg

    check_headers(stream, width, height)
    try:
        data = torch.frombuffer(bytearray(stream), dtype=torch.uint8)
        plane = decode_jpeg(data, mode=ImageReadMode.GRAY, device="cuda").cpu()
    except RuntimeError as what:
        raise ptm_decoder.Malformed(f"stream: {what}") from None
    if tuple(plane.shape) != (1, height, width):
        raise ptm_decoder.Malformed(f"stream of {tuple(plane.shape)}")
    return plane.numpy().tobytes()


def main(arguments):
    what = missing()
    if what:
        print("skipped:", what, file=sys.stderr)
        sys.exit(77)
    for format in b"PTM_FORMAT_JPEG_RGB", b"PTM_FORMAT_JPEG_LRGB":
        ptm_decoder.COMPRESSED[format] = ptm_decoder.COMPRESSED[format][0], decode
    ptm_decoder.main(arguments)


if __name__ == "__main__":
    main(sys.argv[1:])
