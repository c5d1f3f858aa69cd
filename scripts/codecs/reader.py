"""The Python example with another codec for its planes: reader.py EXAMPLE KIND HEADER WORKER… -- capabilities | serve | VIEW FILE

KIND is jpeg or jpegls. HEADER is `as-is`, or `header` to look at the frame header before the library decodes the stream. WORKER… is the
command of a worker (see worker.py). Several equal channels count as one; unequal ones are refused.
"""

import importlib.util
import pathlib
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from worker import frame_header

example, kind, header = sys.argv[1:4]
split = sys.argv.index("--")
command, arguments = sys.argv[4:split], sys.argv[split + 1:]

spec = importlib.util.spec_from_file_location("ptm_decoder", example)
decoder = importlib.util.module_from_spec(spec)
spec.loader.exec_module(decoder)
worker = None


def ask(stream):
    global worker
    if worker is None or worker.poll() is not None:
        worker = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
    worker.stdin.write(b"decode %d\n" % len(stream) + stream)
    worker.stdin.flush()
    words = worker.stdout.readline().split()
    if not words:
        raise SystemExit("the library ended the process")
    if words[0] != b"ok":
        raise decoder.Malformed("stream: %s" % b" ".join(words[1:]).decode())
    width, height, channels, size = [int(word) for word in words[1:]]
    return width, height, channels, worker.stdout.read(size)


def decode(stream, width, height):
    if kind == "jpegls" and b"\xff\xd9" not in stream:
        raise decoder.Malformed("JPEG-LS stream without an end")
    if header == "header":
        found = frame_header(stream)
        marker = [0xF7] if kind == "jpegls" else [0xC0, 0xC1]
        if stream[:2] != b"\xff\xd8" or found is None or found[0] not in marker or found[1:] != (8, height, width, 1):
            raise decoder.Malformed("not one component of 8 bits and the size of the map")
    found_width, found_height, channels, samples = ask(stream)
    if (found_width, found_height) != (width, height) or channels == 2:
        raise decoder.Malformed("stream of %d×%d, %d channels" % (found_width, found_height, channels))
    first = samples[::channels]
    if channels > 1 and (samples[1::channels] != first or samples[2::channels] != first):
        raise decoder.Malformed("stream of a color image")
    return first


def unsupported(stream, width, height):
    raise decoder.Unsupported("the other codec")


is_read = {format: (b"JPEGLS" in format) == (kind == "jpegls") for format in decoder.COMPRESSED}
for format, (count, _) in list(decoder.COMPRESSED.items()):
    decoder.COMPRESSED[format] = count, decode if is_read[format] else unsupported
formats = [format.decode() for format in [*decoder.READ_TEXELS, *decoder.COMPRESSED] if is_read.get(format, True)]
decoder.capabilities = lambda: decoder.CAPABILITIES % ", ".join(formats)
decoder.main(arguments)
