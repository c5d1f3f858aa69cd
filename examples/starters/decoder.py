"""A minimal PTM decoder for ptm-conform: python3 decoder.py VIEW FILE, or python3 decoder.py serve."""
import math, re, sys

CAPABILITIES = "protocol: 1\nname: my-decoder\nmodes: [one-shot, serve]\npipelined: true\n"
SCALE, BIAS = rb"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?", rb"[+-]?\d+"
SIZE = rb"(\d+)(?: +| ?\n)(\d+) ?\n"
NUMBERS = rb"(%b(?: +%b){5})(?: +| ?\n)(%b(?: +%b){5}) ?\n" % (SCALE, SCALE, BIAS, BIAS)
HEADER = re.compile(rb"PTM_1\.2 ?\n(PTM_FORMAT_\w+) ?\n" + SIZE + NUMBERS)


class Refusal(Exception):
    """The argument is the exit status: 65 for malformed files, 69 for unsupported files or views."""


def decode(view, file):
    """To do: return width, height, channels, "u8" or "f32", and the samples, texel by texel, top row first.

    This example decodes the stored values of PTM_FORMAT_LRGB: all polynomials, then all colors, bottom row first."""
    header = HEADER.match(file)
    if view != "raw" or header and header[1] != b"PTM_FORMAT_LRGB":
        raise Refusal(69)
    if not header or not all(map(math.isfinite, map(float, (header[4] + b" " + header[5]).split()))):
        raise Refusal(65)
    width, height, start = int(header[2]), int(header[3]), header.end()
    count = width * height
    if count == 0 or len(file) < start + 9 * count:
        raise Refusal(65)
    colors = start + 6 * count
    texels = [file[start + 6 * i : start + 6 * i + 6] + file[colors + 3 * i : colors + 3 * i + 3] for i in range(count)]
    rows = [b"".join(texels[y * width : (y + 1) * width]) for y in reversed(range(height))]
    return width, height, 9, "u8", b"".join(rows)


def frame(view, path):
    with open(path, "rb") as file:
        *shape, samples = decode(view, file.read())
    return ("PTM1 %s %d %d %d %s\n" % (view.split(":")[0], *shape)).encode() + samples


def answer(sequence, view, path):
    try:
        response = frame(view, path)
    except Refusal as refusal:
        return f"{sequence} {'reject 65' if refusal.args == (65,) else 'unsupported'}\n".encode()
    return f"{sequence} ok {len(response)}\n".encode() + response


try:
    if sys.argv[1] == "capabilities":
        print(CAPABILITIES, end="")
    elif sys.argv[1] == "serve":
        for request in sys.stdin:  # SEQ VIEW PATH
            sys.stdout.buffer.write(answer(*request.rstrip("\n").split(" ", 2)))
            sys.stdout.buffer.flush()
    else:
        sys.stdout.buffer.write(frame(sys.argv[1], sys.argv[2]))
except Refusal as refusal:
    sys.exit(refusal.args[0])
