#!/usr/bin/env python3
"""A PTM writer in plain Python for the three uncompressed formats and the two formats with a table.

    ptm_writer.py write REQUEST OUT

REQUEST is a JSON file. OUT is the PTM file to write. See docs/writers.md. Exit status: 0 written, 65 no file can contain
these values, 69 unsupported format (the compressed ones). It needs only Python 3.

    ptm-conform check-writer -- python3 examples/writers/ptm_writer.py
"""

import ast
import json
import struct
import sys

EXIT_IMPOSSIBLE, EXIT_UNSUPPORTED = 65, 69


class Impossible(Exception):
    """No PTM file can contain these values."""


def read_array(path):
    """Returns the shape and the bytes of a NumPy file of unsigned bytes."""
    with open(path, "rb") as file:
        data = file.read()
    if data[:6] != b"\x93NUMPY":
        raise Impossible("the planes are not a NumPy file")
    length, start = (struct.unpack("<H", data[8:10])[0], 10) if data[6] == 1 else (struct.unpack("<I", data[8:12])[0], 12)
    header = ast.literal_eval(data[start:start + length].decode("latin-1"))
    if header["descr"] not in ("|u1", "u1") or header["fortran_order"]:
        raise Impossible("the planes are not unsigned bytes in C order")
    return header["shape"], data[start + length:]


def number(value):
    """Formats a number with all digits, and without an exponent if possible."""
    return repr(int(value)) if value == int(value) and abs(value) < 1e15 else repr(value)


def line(numbers):
    return " ".join(number(value) for value in numbers) + "\n"


def header(request):
    """2.1 to 2.4: version, format, size, scales, biases."""
    return (
        "PTM_1.2\n"
        + request["format"] + "\n"
        + "%d\n%d\n" % (request["width"], request["height"])
        + line(request["scale"])
        + line(request["bias"])
    )


def rows_from_the_bottom(request, values, channels):
    """Returns the texels in stored order: bottom row first (2.7.1)."""
    row = request["width"] * channels
    rows = [values[start:start + row] for start in range(0, len(values), row)]
    return b"".join(reversed(rows))


def block(texels, channels, first, count):
    """Returns a block with some channels of every texel."""
    return b"".join(texels[i + first:i + first + count] for i in range(0, len(texels), channels))


def write_rgb(request, texels):
    """2.7.1: three blocks for red, green and blue."""
    return header(request), block(texels, 18, 0, 6) + block(texels, 18, 6, 6) + block(texels, 18, 12, 6)


def write_lrgb(request, texels):
    """2.7.3: a block of coefficients, then a block of colors."""
    return header(request), block(texels, 9, 0, 6) + block(texels, 9, 6, 3)


def write_lum(request, texels):
    """2.6 and 2.7.2: the matrix on one line, then eight bytes per texel."""
    return header(request) + line(request["matrix"]), texels


def table_of(texels, first, count):
    """Returns the distinct entries in stored order, and the index of each texel."""
    table, indices = {}, []
    for i in range(0, len(texels), 9):
        entry = texels[i + first:i + first + count]
        indices.append(table.setdefault(entry, len(table)))
    return list(table), indices


def index_bytes(indices, entries):
    """2.8.1: one byte per index for up to 256 entries, else two bytes, low byte first."""
    wide = entries > 256
    return b"".join(index.to_bytes(2 if wide else 1, "little") for index in indices)


def write_table(request, texels, entry_size):
    """2.5 and 2.8: the count, the table, the indices, and the colors if the table has none."""
    table, indices = table_of(texels, 0, entry_size)
    if len(table) > 65536:
        raise Impossible("%d distinct entries do not fit in a table of at most 65536" % len(table))
    text = header(request) + "%d N_LUT_ENTRIES\n" % len(table)
    payload = b"".join(table) + index_bytes(indices, len(table))
    if entry_size == 6:
        payload += block(texels, 9, 6, 3)
    return text, payload


WRITERS = {
    "PTM_FORMAT_RGB": (18, write_rgb),
    "PTM_FORMAT_LRGB": (9, write_lrgb),
    "PTM_FORMAT_LUM": (8, write_lum),
    "PTM_FORMAT_PTM_LUT": (9, lambda request, texels: write_table(request, texels, 6)),
    "PTM_FORMAT_PTM_C_LUT": (9, lambda request, texels: write_table(request, texels, 9)),
}


def write(request_path, out_path):
    with open(request_path) as file:
        request = json.load(file)
    if request["format"] not in WRITERS or "planes" not in request:
        return EXIT_UNSUPPORTED
    channels, writer = WRITERS[request["format"]]
    shape, values = read_array(request["planes"])
    if tuple(shape) != (request["height"], request["width"], channels):
        raise Impossible("the planes have shape %r" % (shape,))
    text, payload = writer(request, rows_from_the_bottom(request, values, channels))
    with open(out_path, "wb") as file:
        file.write(text.encode("ascii") + payload)
    return 0


def main():
    if len(sys.argv) != 4 or sys.argv[1] != "write":
        print(__doc__, file=sys.stderr)
        return 2
    try:
        return write(sys.argv[2], sys.argv[3])
    except Impossible as reason:
        print(reason, file=sys.stderr)
        return EXIT_IMPOSSIBLE


if __name__ == "__main__":
    sys.exit(main())
