#!/usr/bin/env python3
"""External witnesses for the codecs: the results of libjpeg and CharLS for generated images.

    python3 scripts/codec_witnesses.py > tests/it/codec/witnesses.txt

Each recipe gives one line:

    codec kind width height parameters seed sha256-of-the-stream sha256-of-the-decoded-samples

For JPEG, the stream is the whole output of `cjpeg -dct int -grayscale`. For JPEG-LS, it is only the
entropy-coded scan, because the headers before it have several valid forms. The samples are the output
of `djpeg -dct int` and CharLS. tests/it/codec/witnesses.rs generates the same images.

Needs only cjpeg and djpeg (Debian: libjpeg-turbo-progs) and libcharls.so.2 (Debian: libcharls2).
All arithmetic uses integers, so every machine generates the same images.
"""

import ctypes
import hashlib
import subprocess
import sys

KINDS = ["noise", "gradient", "smooth", "checker", "flat", "residual", "wrapped", "dots", "walk"]

SIZES = [
    (1, 1), (1, 7), (7, 1), (1, 8), (8, 1), (1, 9), (9, 1), (1, 257), (257, 1), (7, 7), (8, 8), (9, 9), (7, 9),
    (9, 8), (2, 3), (16, 16), (17, 15), (24, 5), (5, 24), (33, 31), (64, 48), (63, 65), (128, 8), (100, 75),
    (257, 129),
]

# Only these sizes have JPEG-LS runs that are long enough to reach the end of the table of run lengths.
WIDE = [(40000, 4), (65535, 3)]


class Random:
    """A linear congruential generator. Each number is its upper 16 bits."""

    def __init__(self, seed):
        self.state = seed

    def next(self):
        self.state = (self.state * 1664525 + 1013904223) % 2**32
        return self.state >> 16


def paint(kind, width, height, seed):
    random = Random(seed)
    p, q, s = random.next(), random.next(), random.next()
    samples = bytearray(width * height)
    for i in range(width * height):
        x, y, r = i % width, i // width, random.next()
        if kind == "noise":
            value = r >> 8
        elif kind == "gradient":
            value = (x * (p % 7) + y * (q % 5) + s) % 256
        elif kind == "smooth":
            value = (x * (p >> 8) // width + y * (q >> 8) // height) // 2 + r % 4
        elif kind == "checker":
            value = (x // (1 + p % 9) + y // (1 + p % 9)) % 2 * 255
        elif kind == "flat":
            value = p >> 8
        elif kind == "residual":
            value = 113 + r % 16 + (r >> 8) % 16
        elif kind == "wrapped":
            value = (r % 16 + 248) % 256
        elif kind == "dots":
            value = r >> 8 if r % 37 == 0 else p >> 8
        elif kind == "walk":
            left = samples[i - 1] if x > 0 else 128
            above = samples[i - width] if y > 0 else left
            value = min(max((left + above) // 2 + r % 32 - 15, 0), 255)
        samples[i] = value
    return bytes(samples)


def run(command, data):
    return subprocess.run(command, input=data, stdout=subprocess.PIPE, check=True).stdout


def jpeg(samples, width, height, parameters):
    """Encodes and decodes a JPEG. Examples of parameters: q75,optimised,restart=5,sampling=2x2 and q20,extended."""
    command = ["cjpeg", "-dct", "int", "-grayscale"]
    if "extended" not in parameters:
        command.append("-baseline")
    for parameter in parameters:
        name, _, value = parameter.partition("=")
        if name.startswith("q"):
            command += ["-quality", name[1:]]
        elif name == "optimised":
            command.append("-optimize")
        elif name == "restart":
            command += ["-restart", value + "B"]
        elif name == "sampling":
            command += ["-sample", value]
    stream = run(command, b"P5 %d %d 255\n" % (width, height) + samples)
    decoded = run(["djpeg", "-dct", "int", "-pnm", "-grayscale"], stream)
    return stream, decoded[-width * height:]


class FrameInfo(ctypes.Structure):
    _fields_ = [("width", ctypes.c_uint32), ("height", ctypes.c_uint32),
                ("bits_per_sample", ctypes.c_int32), ("component_count", ctypes.c_int32)]


class PresetParameters(ctypes.Structure):
    _fields_ = [(name, ctypes.c_int32) for name in ("maxval", "t1", "t2", "t3", "reset")]


def charls():
    library = ctypes.CDLL("libcharls.so.2")
    library.charls_jpegls_encoder_create.restype = ctypes.c_void_p
    library.charls_jpegls_decoder_create.restype = ctypes.c_void_p
    library.charls_get_version_string.restype = ctypes.c_char_p
    return library


def check(status):
    if status != 0:
        raise RuntimeError(f"CharLS returned {status}")


def scan_of(stream):
    """Returns the bytes between the scan header and EOI."""
    at = 2
    while True:
        code, length = stream[at + 1], int.from_bytes(stream[at + 2:at + 4], "big")
        at += 2 + length
        if code == 0xDA:
            break
    end = len(stream) - 2
    assert stream[end:] == b"\xff\xd9"
    return stream[at:end]


def jpeg_ls(library, samples, width, height, parameters):
    """Encodes and decodes a JPEG-LS image. Examples of parameters: near=3, near=0,presets=255:9:9:9:31 and near=0,bits=5.

    CharLS ignores a MAXVAL that is smaller than the precision allows. Therefore, bits=5 means samples
    of five bits, which have the same scan as samples of eight bits with MAXVAL 31.
    """
    size, p = ctypes.c_size_t, ctypes.c_void_p
    encoder = p(library.charls_jpegls_encoder_create())
    frame = FrameInfo(width, height, bits_of(parameters), 1)
    check(library.charls_jpegls_encoder_set_frame_info(encoder, ctypes.byref(frame)))
    for parameter in parameters:
        name, _, value = parameter.partition("=")
        if name == "near":
            check(library.charls_jpegls_encoder_set_near_lossless(encoder, int(value)))
        elif name == "presets":
            presets = PresetParameters(*map(int, value.split(":")))
            check(library.charls_jpegls_encoder_set_preset_coding_parameters(encoder, ctypes.byref(presets)))
    room = ctypes.create_string_buffer(4 * width * height + 4096)
    check(library.charls_jpegls_encoder_set_destination_buffer(encoder, room, size(len(room))))
    check(library.charls_jpegls_encoder_encode_from_buffer(encoder, samples, size(len(samples)), 0))
    written = size()
    check(library.charls_jpegls_encoder_get_bytes_written(encoder, ctypes.byref(written)))
    library.charls_jpegls_encoder_destroy(encoder)
    stream = room.raw[:written.value]

    decoder = p(library.charls_jpegls_decoder_create())
    check(library.charls_jpegls_decoder_set_source_buffer(decoder, stream, size(len(stream))))
    check(library.charls_jpegls_decoder_read_header(decoder))
    decoded = ctypes.create_string_buffer(width * height)
    check(library.charls_jpegls_decoder_decode_to_buffer(decoder, decoded, size(width * height), 0))
    library.charls_jpegls_decoder_destroy(decoder)
    return scan_of(stream), decoded.raw


def bits_of(parameters):
    return next((int(parameter[5:]) for parameter in parameters if parameter.startswith("bits=")), 8)


def jpeg_parameters(random):
    quality = 1 + random.next() % 100
    # Choose qualities near a change of the table precision, and the two extremes, more often than by chance.
    if random.next() % 4 == 0:
        quality = [1, 20, 22, 23, 24, 25, 49, 50, 51, 75, 90, 95, 98, 99, 100][random.next() % 15]
    parameters = [f"q{quality}"]
    choice = random.next() % 10
    if choice == 0:
        parameters.append("optimised")
    elif choice == 1:
        parameters.append(f"restart={1 + random.next() % 20}")
    elif choice == 2:
        parameters.append(f"sampling={1 + random.next() % 4}x{1 + random.next() % 4}")
    elif choice == 3:
        parameters.append("extended")
    elif choice == 4:
        parameters += ["optimised", f"restart={1 + random.next() % 20}"]
    return parameters


def jpeg_ls_parameters(random):
    near = 0 if random.next() % 2 else random.next() % 11
    choice = random.next() % 8
    if choice == 2:
        bits = 2 + random.next() % 6
        return [f"near={min(near, (2**bits - 1) // 2)}", f"bits={bits}"]
    parameters = [f"near={near}"]
    if choice < 2:
        t1 = near + 1 + random.next() % 20
        t2 = t1 + random.next() % 30
        t3 = t2 + random.next() % 100
        reset = 3 + random.next() % 253
        parameters.append(f"presets=255:{t1}:{t2}:{t3}:{reset}")
    return parameters


def main():
    library = charls()
    version = run(["cjpeg", "-version"], b"") or subprocess.run(
        ["cjpeg", "-version"], stdin=subprocess.DEVNULL, stderr=subprocess.PIPE, check=False).stderr
    print("# Made by scripts/codec_witnesses.py with", version.decode().splitlines()[0], end=" ")
    print("and CharLS", library.charls_get_version_string().decode() + ".")
    print("# codec kind width height parameters seed sha256-of-the-stream sha256-of-the-decoded-samples")

    random = Random(2001)
    for codec, rounds in (("jpeg", 3), ("jpeg-ls", 8)):
        recipes = [(kind, size) for size in SIZES for kind in KINDS] * rounds
        if codec == "jpeg-ls":
            recipes += [("flat", size) for size in WIDE] * 4
        for number, (kind, (width, height)) in enumerate(recipes):
            seed = random.next() << 16 | random.next()
            samples = paint(kind, width, height, seed)
            if codec == "jpeg":
                parameters = jpeg_parameters(random)
                stream, decoded = jpeg(samples, width, height, parameters)
            else:
                parameters = jpeg_ls_parameters(random)
                samples = bytes(sample >> 8 - bits_of(parameters) for sample in samples)
                stream, decoded = jpeg_ls(library, samples, width, height, parameters)
            digests = [hashlib.sha256(data).hexdigest() for data in (stream, decoded)]
            print(codec, kind, width, height, ",".join(parameters), seed, *digests)
            if number % 100 == 0:
                print(codec, number, file=sys.stderr)


if __name__ == "__main__":
    main()
