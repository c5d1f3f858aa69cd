#!/usr/bin/env python3
"""Generates JPEG streams of the coding processes that the reference does not support, for crates/ptm-generate/src/damage.rs.

    python3 scripts/odd_streams.py

The streams are progressive, arithmetic, and of 12 bits. Each has one component of 9x6 samples in two blocks, with all
coefficients 0. Prints the name, the stream in hexadecimal, and the image or the error of Pillow (libjpeg), if installed.
"""

import io

SIZE = (9, 6)
BLOCKS = 2


def segment(code, body):
    return bytes([0xFF, code]) + (len(body) + 2).to_bytes(2, "big") + body


def frame(code, bits):
    width, height = SIZE
    return segment(code, bytes([bits]) + height.to_bytes(2, "big") + width.to_bytes(2, "big") + b"\1\1\x11\0")


def huffman(table):
    """Returns a table with a single one-bit code 0: no DC difference, or the end of a block."""
    return segment(0xC4, bytes([table, 1]) + bytes(15) + b"\0")


def scan(first, last, data):
    return segment(0xDA, b"\1\1\0" + bytes([first, last, 0])) + data


def zeros(count):
    """Returns the given number of 0 bits, padded with 1 bits."""
    text = "0" * count
    text += "1" * (-count % 8)
    return int(text, 2).to_bytes(len(text) // 8, "big")


class Arithmetic:
    """The encoder of T.81 Annex D, with the states that these few decisions reach (Table D.3)."""

    STATES = {0: (0x5A1D, 1, 1, 1), 1: (0x2586, 14, 2, 0), 2: (0x1114, 16, 3, 0)}

    def __init__(self):
        self.a, self.c, self.ct = 0x10000, 0, 11
        self.byte, self.stack, self.out, self.contexts = None, 0, bytearray(), {}

    def code(self, context, decision):
        state, likely = self.contexts.get(context, (0, 0))
        qe, less, more, switch = self.STATES[state]
        self.a -= qe
        if decision == likely:
            if self.a >= 0x8000:
                return
            if self.a < qe:
                self.c, self.a = self.c + self.a, qe
            self.contexts[context] = more, likely
        else:
            if self.a >= qe:
                self.c, self.a = self.c + self.a, qe
            self.contexts[context] = less, likely ^ switch
        while self.a < 0x8000:
            self.a, self.c, self.ct = self.a << 1, self.c << 1, self.ct - 1
            if self.ct == 0:
                self.shift_out()
                self.ct = 8

    def shift_out(self):
        carried = self.c >> 19
        if carried == 0xFF:
            self.stack += 1
        else:
            if self.byte is not None:
                self.put(self.byte + (carried > 0xFF))
            for _ in range(self.stack):
                self.put(0 if carried > 0xFF else 0xFF)
            self.stack, self.byte = 0, carried & 0xFF
        self.c &= 0x7FFFF

    def put(self, byte):
        self.out.append(byte)
        if byte == 0xFF:
            self.out.append(0)

    def end(self):
        last = (self.c + self.a - 1) & 0xFFFF0000
        self.c = last + 0x8000 if last < self.c else last
        self.c <<= self.ct
        self.shift_out()
        self.c <<= 8
        self.shift_out()
        self.put(self.byte)
        return bytes(self.out).rstrip(b"\0")


def arithmetic():
    encoder = Arithmetic()
    for _ in range(BLOCKS):
        encoder.code("dc", 0)           # no difference
        encoder.code("ac", 1)           # the end of the block
    return frame(0xC9, 8) + scan(0, 63, encoder.end())


def progressive():
    return frame(0xC2, 8) + huffman(0) + scan(0, 0, zeros(BLOCKS)) + huffman(0x10) + scan(1, 63, zeros(BLOCKS))


def twelve_bits():
    return frame(0xC1, 12) + huffman(0) + huffman(0x10) + scan(0, 63, zeros(2 * BLOCKS))


def read(stream):
    try:
        from PIL import Image
        image = Image.open(io.BytesIO(stream))
        return "%s %dx%d %s" % (image.mode, *image.size, sorted(set(image.tobytes())))
    except Exception as what:                   # Pillow may raise any exception.
        return type(what).__name__


for make in progressive, arithmetic, twelve_bits:
    ones = segment(0xDB, b"\0" + b"\1" * 64)
    stream = b"\xFF\xD8" + ones + make() + b"\xFF\xD9"
    print(make.__name__, stream.hex(), "#", read(stream))
