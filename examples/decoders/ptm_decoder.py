#!/usr/bin/env python3
"""Reads a Polynomial Texture Map, version 1.2, in all nine formats, and answers in PTM-CP 1.

    ptm_decoder.py VIEW FILE       VIEW is raw, coef or rgb:LU,LV; one frame on standard output
    ptm_decoder.py capabilities    the capabilities of this decoder, in YAML
    ptm_decoder.py serve           requests "SEQ VIEW PATH" on standard input, one per line

Exit status: 0 decoded, 65 malformed, 69 unsupported (other views, other transforms).
The sections are in the order of the specification. If it leaves a question open, the name of
the ruling follows in brackets, as in [rows]. It needs Python 3.8 or later. The compressed formats
of 2.9 also need Pillow, and JPEG-LS needs pillow-jpls (pip install pillow pillow-jpls). Without
them, it exits with 69 for these formats.
"""

import array
import collections
import importlib.util
import io
import math
import os
import re
import sys

# A texel is a bytes object with its channels in the order of the specification:
#   RGB  (18)  red a0..a5, green a0..a5, blue a0..a5
#   LRGB (9)   a0..a5, R, G, B            also for the two LUT formats
#   LUM  (8)   a0..a5, Cr, Cb
# `texels` is ordered left to right, top row first. `matrix` is None except for LUM.
Ptm = collections.namedtuple("Ptm", "width height scale bias matrix texels")


class Malformed(Exception):
    """The file breaks a rule of the format."""


class Unsupported(Exception):
    """The file may be valid, but this decoder does not support it."""


def read_ptm(file):
    """Reads a file section by section."""
    source = Source(file)
    read_version(source)                                              # 2.1
    format = read_format(source)                                      # 2.2
    width, height = read_size(source)                                 # 2.3
    scale, bias = read_scale_and_bias(source)                         # 2.4
    entries = read_lookup_table(source, format)                       # 2.5
    matrix = read_color_matrix(source, format)                        # 2.6
    if format in COMPRESSED:                                          # 2.9
        stored = read_compressed(source, format, width, height)
    else:                                                             # 2.7 and 2.8
        stored = READ_TEXELS[format](source, width * height, entries)
    # [rows] The bottom row is stored first, in every format.
    texels = [texel for y in reversed(range(height)) for texel in stored[y * width:(y + 1) * width]]
    return Ptm(width, height, scale, bias, matrix, texels)            # [trailing]


# 1.0 Background: the polynomial, and the color under a light

def polynomial(a, lu, lv):
    """Returns one channel under the light (lu, lv), with +lu to the right and +lv up [light]."""
    return a[0] * lu * lu + a[1] * lv * lv + a[2] * lu * lv + a[3] * lu + a[4] * lv + a[5]


def texel_color(ptm, texel, lu, lv):
    """Returns red, green and blue as real numbers that are not clamped [color]."""
    values = final_coefficients(ptm, texel)
    luminance = polynomial(values[:6], lu, lv)
    if len(texel) == 18:
        return luminance, polynomial(values[6:12], lu, lv), polynomial(values[12:], lu, lv)
    if len(texel) == 9:
        return [luminance * channel / 255 for channel in texel[6:]]
    # [lum-vector, lum-major, lum-range] M * (Y, Cr, Cb, 1) with values in 0..255. The matrix is in
    # column-major order. Its last row (elements 3, 7, 11, 15) is not used [lum-last-row].
    m, y, cr, cb = ptm.matrix, luminance, texel[6], texel[7]
    return [m[row] * y + m[row + 4] * cr + m[row + 8] * cb + m[row + 12] for row in range(3)]


def color_byte(value):
    """Clamps, then rounds. In this order, NaN becomes 0."""
    return int(min(255.0, max(0.0, value)) + 0.5)


# 2.0 File format: header lines, then bytes

# [header-line-end, header-blanks] Words separated by spaces, with at most one space before the LF.
# Tabs, CRs, a space at the start of a line, and empty lines do not match.
LINE = re.compile(rb"[!-~]+(?: +[!-~]+)* ?")
NUMBER = re.compile(rb"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")     # [numbers]
INTEGER = re.compile(rb"[+-]?[0-9]{1,18}")
COUNT = re.compile(rb"\+?0*[1-9][0-9]{0,17}")                                      # [dimensions]


class Source:
    """The bytes of a file, and the current position."""

    def __init__(self, file):
        self.file = file
        self.at = 0

    def line(self):
        """Returns the words of the next header line."""
        end = self.file.find(b"\n", self.at)
        if end < 0:
            raise Malformed("the header ends without a newline")
        line = self.file[self.at:end]
        if not LINE.fullmatch(line):
            raise Malformed("header line with extra spaces or invalid bytes: %r" % line[:60])
        self.at = end + 1
        return line.split()

    def bytes(self, size):
        """Returns the next `size` bytes. This checks the size before any allocation."""
        if size > len(self.file) - self.at:
            raise Malformed("%d bytes needed, %d remain" % (size, len(self.file) - self.at))
        start, self.at = self.at, self.at + size
        return self.file[start:self.at]


def number(word):
    # float() alone would also accept nan, inf, underscores and non-ASCII digits.
    value = float(word) if NUMBER.fullmatch(word) else math.inf
    if math.isinf(value):
        raise Malformed("not a number: %r" % word[:60])
    return value


def whole_number(word):
    # [odd-numbers] "3.0" is a whole number, "1.5" is not. Any sign and size is valid.
    value = number(word)
    if value != math.floor(value):
        raise Malformed("not an integer: %r" % word[:60])
    return value


def integer(word):
    if not INTEGER.fullmatch(word):
        raise Malformed("not an integer: %r" % word[:60])
    return int(word)


def positive_integer(word):
    if not COUNT.fullmatch(word):
        raise Malformed("not a positive integer: %r" % word[:60])
    return int(word)


# 2.1 Header string

def read_version(source):
    words = source.line()
    if words != [b"PTM_1.2"]:                       # [version] PTM_1.1 has a different layout
        raise Malformed("the first line is not PTM_1.2")


# 2.2 Format string

def read_format(source):
    words = source.line()
    format = words[0] if len(words) == 1 else b""
    if format not in READ_TEXELS and format not in COMPRESSED:
        raise Malformed("unknown format %r" % format[:60])
    return format


# 2.3 Image size

def read_size(source):
    """Reads the width, then the height, on one line or two [size-spelling]."""
    words = source.line()
    if len(words) == 1:
        words = words + source.line()
    if len(words) != 2:
        raise Malformed("expected a width and a height")
    return positive_integer(words[0]), positive_integer(words[1])


# 2.4 Scale and bias

def read_scale_and_bias(source):
    """Reads six scales, then six biases, on one line or two [size-spelling]."""
    words = source.line()
    if len(words) == 6:
        words = words + source.line()
    if len(words) != 12:
        raise Malformed("expected six scales and six biases")
    return [number(word) for word in words[:6]], [whole_number(word) for word in words[6:]]


def final_coefficients(ptm, texel):
    """Returns all channels as numbers. The three channels of RGB share six scales and biases."""
    polynomials = 18 if len(texel) == 18 else 6     # the bytes after a5 are colors, as stored
    # [final-coefficient] Bias first, then scale, in real arithmetic.
    return [(raw - ptm.bias[i % 6]) * ptm.scale[i % 6] if i < polynomials else float(raw)
            for i, raw in enumerate(texel)]


# 2.5 Lookup table

ENTRY_SIZE = {
    b"PTM_FORMAT_PTM_LUT": 6,                       # a0..a5
    b"PTM_FORMAT_PTM_C_LUT": 9,                     # a0..a5, R, G, B
}


def read_lookup_table(source, format):
    """Returns the entries as bytes objects, or no entries for formats without a table."""
    if format not in ENTRY_SIZE:
        return []
    words = source.line()
    # [lut-count] "256 N_LUT_ENTRIES", "256" or "nentries 256". No table is empty [lut-range].
    if words[0] == b"nentries":
        words = words[1:]
    elif words[1:] == [b"N_LUT_ENTRIES"]:
        words = words[:1]
    if len(words) != 1:
        raise Malformed("not a number of entries: %r" % words[:2])
    count = positive_integer(words[0])
    # [lut-newline] The indices follow the last entry directly.
    return groups(source.bytes(count * ENTRY_SIZE[format]), ENTRY_SIZE[format])


# 2.6 Color matrix

def read_color_matrix(source, format):
    """Reads sixteen numbers on one line [lum-layout]. Returns None for all formats except LUM."""
    if format != b"PTM_FORMAT_LUM":
        return None
    words = source.line()
    if len(words) != 16:
        raise Malformed("the color matrix is not 16 numbers on one line")
    return [number(word) for word in words]


# 2.7 Uncompressed data per texel, in stored order

def groups(data, size):
    return [data[i:i + size] for i in range(0, len(data), size)]


def read_rgb(source, count, entries):
    """2.7.1: three blocks for red, green and blue, each with six coefficients per texel [blocks]."""
    blocks = source.bytes(count * 18)
    red, green, blue = [groups(block, 6) for block in groups(blocks, count * 6)]
    return [r + g + b for r, g, b in zip(red, green, blue)]


def read_lum(source, count, entries):
    """2.7.2: eight bytes per texel: a0..a5, Cr, Cb."""
    return groups(source.bytes(count * 8), 8)


def read_lrgb(source, count, entries):
    """2.7.3: a block with six coefficients per texel, then a block with R, G, B per texel [blocks]."""
    luminance = groups(source.bytes(count * 6), 6)
    color = groups(source.bytes(count * 3), 3)
    return [a + rgb for a, rgb in zip(luminance, color)]


# 2.8 Lookup table indices

def read_c_lut(source, count, entries):
    """2.8.2: only indices. The entry is the whole texel."""
    width = 1 if len(entries) <= 256 else 2         # [lut-width, lut-huge] by the number of entries
    stored = groups(source.bytes(count * width), width)
    indices = [int.from_bytes(index, "little") for index in stored]
    if max(indices) >= len(entries):                # [lut-range]
        raise Malformed("index %d into %d entries" % (max(indices), len(entries)))
    return [entries[index] for index in indices]


def read_lut(source, count, entries):
    """2.8.1: all indices, then R, G, B per texel."""
    luminance = read_c_lut(source, count, entries)
    color = groups(source.bytes(count * 3), 3)
    return [a + rgb for a, rgb in zip(luminance, color)]


READ_TEXELS = {
    b"PTM_FORMAT_RGB": read_rgb,
    b"PTM_FORMAT_LUM": read_lum,
    b"PTM_FORMAT_LRGB": read_lrgb,
    b"PTM_FORMAT_PTM_LUT": read_lut,
    b"PTM_FORMAT_PTM_C_LUT": read_c_lut,
}


# 2.9 Compressed data: a parameter, lists with one number per plane, then the planes

# The numbers of one plane, in the order of the lists. `rank` is its number in 2.9.4.
Plane = collections.namedtuple("Plane", "transform mx my rank reference size side_size")

INVERSION, MOTION = 1, 2                            # 2.9.2


def read_compressed(source, format, width, height):
    """Returns the texels in stored order. A plane has one coefficient or color of every texel."""
    count, decode = COMPRESSED[format]
    planes = read_lists(source, count)                                # 2.9.1 to 2.9.7
    # [planes-stored] The streams are in the order of the planes, each followed by its side information.
    streams = [(source.bytes(plane.size), source.bytes(plane.side_size)) for plane in planes]
    samples = [decode(stream, width, height) for stream, side in streams]
    # [order] The order consists of ranks. Equal ranks and gaps are allowed [ranks].
    for i in sorted(range(count), key=lambda i: planes[i].rank):
        samples[i] = reconstruct(planes, samples, i, width, height)
        correct(samples[i], streams[i][1])          # before it predicts another plane
    return [bytes(texel) for texel in zip(*samples)]


def read_lists(source, count):
    """2.9.1 to 2.9.7: returns the planes. Line breaks between the numbers do not matter [list-lines]."""
    words = []
    while len(words) < 1 + 7 * count:
        words += source.line()
    if len(words) > 1 + 7 * count:
        raise Malformed("%d numbers too many" % (len(words) - 1 - 7 * count))
    number(words[0])                                # 2.9.1: not needed for decoding [plane-odd]
    numbers = [integer(word) for word in words[1:]]
    # 2.9.3 consists of two lists: x of all planes, then y of all planes.
    planes = [Plane(*plane) for plane in zip(*groups(numbers, count))]
    for plane in planes:
        if plane.transform & ~(INVERSION | MOTION):
            raise Unsupported("transform %d" % plane.transform)       # [transforms]
        if plane.size < 0 or plane.side_size < 0:
            raise Malformed("a size below zero")
        if plane.reference >= count:
            raise Malformed("reference %d of %d planes" % (plane.reference, count))
        if plane.reference >= 0 and planes[plane.reference].rank >= plane.rank:
            raise Malformed("a plane of rank %d is predicted from a plane that is not decoded before it" % plane.rank)
    return planes


# 2.9.2, 2.9.3, 2.9.5: prediction

def reconstruct(planes, samples, i, width, height):
    """Returns plane i before its corrections. The stream of a predicted plane contains residuals."""
    plane = planes[i]
    if plane.reference < 0:                         # [prediction] Intra: no transform and no motion.
        return bytearray(samples[i])
    predictor = bytes(samples[plane.reference])
    if plane.transform & INVERSION:                 # [motion-inversion] Inversion first, then motion.
        predictor = bytes(255 - value for value in predictor)
    if plane.transform & MOTION:
        predictor = moved(predictor, width, height, plane.mx, plane.my)
    # [prediction, jpeg-ls-offset] Modulo 256, for both codecs.
    return bytearray((r + p - 128) % 256 for r, p in zip(samples[i], predictor))


def moved(plane, width, height, mx, my):
    """Returns a plane with the value of `plane` at (x + mx/2, y + my/2) for each (x, y) [motion-sign].
    y counts rows in stored order [motion-vertical]."""
    left, right = neighbors(width, mx)
    upper, lower = neighbors(height, my)
    rows = groups(plane, width)
    result = bytearray()
    for above, below in zip(upper, lower):
        a, b = rows[above], rows[below]
        # [motion-half] The mean of four texels, rounded once. If mx or my is even, two or all four
        # of them are the same texel, so this is the mean of two texels, or the texel itself.
        result += bytes((a[l] + a[r] + b[l] + b[r] + 2) // 4 for l, r in zip(left, right))
    return bytes(result)


def neighbors(size, half_steps):
    """Returns, for each position, the positions on both sides of the point to which the vector leads."""
    # [motion-border] Positions outside the plane are clamped to its edge.
    inside = lambda position: min(max(position, 0), size - 1)
    lower, upper = half_steps // 2, (half_steps + 1) // 2
    return [inside(i + lower) for i in range(size)], [inside(i + upper) for i in range(size)]


# 2.9.8: the streams of the planes, and their side information

def decode_jpeg(stream, width, height):
    try:
        from PIL import Image
    except ImportError:
        raise Unsupported("JPEG: Pillow is not installed")
    return decode_stream(lambda file: Image.open(file, formats=["JPEG"]), stream, width, height)


def decode_jpeg_ls(stream, width, height):
    try:
        import pillow_jpls
    except ImportError:
        raise Unsupported("JPEG-LS: pillow-jpls is not installed")
    if b"\xff\xd9" not in stream:                   # [plane-damage] CharLS is very slow if the end is missing.
        raise Malformed("JPEG-LS stream without an end")
    # Image.open recognizes JPEG-LS only if the frame header comes first.
    return decode_stream(pillow_jpls.JplsImageFile, stream, width, height)


def decode_stream(open_image, stream, width, height):
    """Returns the samples of a stream with one component of 8 bits and the size of the map [plane-stream]."""
    try:
        image = open_image(io.BytesIO(stream))
        found = image.mode, image.size
        samples = image.tobytes() if found == ("L", (width, height)) else b""
    except Exception as what:                       # [plane-damage] Codecs raise any exception.
        raise Malformed("stream: %s" % what)
    if len(samples) != width * height:
        raise Malformed("stream of %r, not %r" % (found, ("L", (width, height))))
    return samples


def correct(plane, side):
    """Applies side information: records with a position, high byte first, and its value."""
    if len(side) % 5 != 0:                          # [side-malformed]
        raise Malformed("%d bytes of side information" % len(side))
    # [side-lossless, side-twice] Records apply for any parameter. The last one for a position wins.
    for record in groups(side, 5):
        # [side-information] Positions count texels along the rows in stored order.
        position = int.from_bytes(record[:4], "big")
        if position >= len(plane):
            raise Malformed("side information at %d of %d texels" % (position, len(plane)))
        plane[position] = record[4]


COMPRESSED = {
    b"PTM_FORMAT_JPEG_RGB": (18, decode_jpeg),
    b"PTM_FORMAT_JPEG_LRGB": (9, decode_jpeg),
    b"PTM_FORMAT_JPEGLS_RGB": (18, decode_jpeg_ls),
    b"PTM_FORMAT_JPEGLS_LRGB": (9, decode_jpeg_ls),
}


# The protocol: one header line, then the samples of each texel, top row first

CAPABILITIES = """\
protocol: 1
name: ptm-decoder-python
version: "1.0"
views: [raw, coef, rgb]
formats: [%s]
modes: [one-shot, serve]
pipelined: true
reject_exit: 65
"""


def capabilities():
    """Returns the capabilities. They include a compressed format if its codec is installed."""
    def is_supported(format):
        codecs = ["PIL", "pillow_jpls"] if b"JPEGLS" in format else ["PIL"]
        return format in READ_TEXELS or all(map(importlib.util.find_spec, codecs))
    formats = filter(is_supported, [*READ_TEXELS, *COMPRESSED])
    return CAPABILITIES % ", ".join(format.decode() for format in formats)


def parse_view(view):
    """Returns the name of a view and its light, if it has one."""
    name, _, light = view.partition(b":")
    words = light.split(b",")
    if view in (b"raw", b"coef"):
        return name, []
    if name == b"rgb" and len(words) == 2 and all(NUMBER.fullmatch(word) for word in words):
        return name, [float(word) for word in words]
    raise Unsupported("view")


def frame(view, path):
    view, light = parse_view(view)
    with open(path, "rb") as file:
        ptm = read_ptm(file.read())
    kind = "u8"
    if view == b"raw":
        samples = b"".join(ptm.texels)
    elif view == b"coef":
        values = array.array("f")
        for texel in ptm.texels:
            values.extend(final_coefficients(ptm, texel))
        if sys.byteorder == "big":
            values.byteswap()
        kind, samples = "f32", values.tobytes()
    else:
        colors = [texel_color(ptm, texel, *light) for texel in ptm.texels]
        samples = bytes(color_byte(channel) for color in colors for channel in color)
    channels = 3 if view == b"rgb" else len(ptm.texels[0])
    line = "PTM1 %s %d %d %d %s\n" % (view.decode(), ptm.width, ptm.height, channels, kind)
    return line.encode() + samples


def serve(requests, answers):
    for request in requests:
        sequence, view, path = request.rstrip(b"\n").split(b" ", 2)
        try:
            answer = frame(view, path)
            answers.write(b"%s ok %d\n" % (sequence, len(answer)) + answer)
        except Malformed:
            answers.write(sequence + b" reject 65\n")
        except Unsupported as what:
            answers.write(sequence + b" unsupported " + os.fsencode(str(what)) + b"\n")
        answers.flush()


def main(arguments):
    if arguments == ["capabilities"]:
        print(capabilities(), end="")
    elif arguments == ["serve"]:
        serve(sys.stdin.buffer, sys.stdout.buffer)
    elif len(arguments) == 2:
        try:
            sys.stdout.buffer.write(frame(os.fsencode(arguments[0]), arguments[1]))
        except (Malformed, Unsupported) as what:
            print("%s: %s" % (type(what).__name__.lower(), what), file=sys.stderr)
            sys.exit(65 if isinstance(what, Malformed) else 69)
    else:
        print(__doc__, file=sys.stderr)
        sys.exit(64)


if __name__ == "__main__":
    main(sys.argv[1:])
