#!/usr/bin/env python3
"""Measures which JPEG and JPEG-LS libraries read the planes of a PTM right, and prints the tables of docs/codecs.md in Markdown.

    cargo build
    scripts/codecs.py [--program target/debug/ptm-conform] [--only WORD] [--no-check] [--json FILE] [--docs docs/codecs.md]

Installs the versions of scripts/codecs.lock from PyPI, npm and crates.io in a temporary folder, and skips what cannot be installed. The
libraries decode streams that this script makes, and then the planes of the suite, in examples/decoders/ptm_decoder.py with an exchanged
codec, through `check`. The expected samples of JPEG streams are those of `ptm-conform reference`; those of JPEG-LS streams follow from the
encoder in codecs/ls_encoder.py. --folder keeps the installed packages for the next run. Needs Python 3.9, and optionally node, cargo and java.
"""

import datetime
import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import threading

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent
PARTS = HERE / "codecs"
sys.path.insert(0, str(PARTS))
import ls_encoder
import measuring
from measuring import run, say
from worker import frame_header

ANSWER_SECONDS = 30

# name, library in the table, packages of the lock file (the first one gives the version), codec, kind of worker, what to set
DECODERS = [
    ("pillow", "Pillow", "Pillow", "jpeg", "python", "`Image.open(file, formats=[\"JPEG\"])`; require mode `L`"),
    ("opencv-unchanged", "OpenCV, `IMREAD_UNCHANGED`", "opencv-python-headless", "jpeg", "python", "this flag; a color stream is an array of three dimensions"),
    ("opencv-grayscale", "OpenCV, `IMREAD_GRAYSCALE`", "opencv-python-headless", "jpeg", "python", "use `IMREAD_UNCHANGED`"),
    ("pyav", "PyAV, codec `mjpeg`", "av", "jpeg", "python", "require the format `gray`; look at the frame header"),
    ("imagecodecs", "imagecodecs, `jpeg_decode`", "imagecodecs", "jpeg", "python", "require two dimensions"),
    ("simplejpeg", "simplejpeg, `GRAY`", "simplejpeg", "jpeg", "python", "`decode_jpeg_header` must say `Gray`"),
    ("simplejpeg-fastdct", "simplejpeg, `fastdct=True`", "simplejpeg", "jpeg", "python", "leave `fastdct` off"),
    ("pylibjpeg-libjpeg", "pylibjpeg-libjpeg", "pylibjpeg-libjpeg", "jpeg", "python", "look at the frame header"),
    ("gdcm", "GDCM", "python-gdcm", "jpeg", "python", "needs DICOM around the stream"),
    ("imageio", "imageio (Pillow inside)", "imageio", "jpeg", "python", "`imread(data, extension=\".jpg\")`; require two dimensions"),
    ("scikit-image", "scikit-image (imageio inside)", "scikit-image", "jpeg", "python", "require two dimensions"),
    ("pyvips", "pyvips", "pyvips-binary", "jpeg", "python", "`write_to_memory()`; require one band"),
    ("jpeglib-6b", "libjpeg 6b (jpeglib)", "jpeglib", "jpeg", "python", "`dct_method` other than `JDCT_IFAST`"),
    ("jpeglib-9f", "libjpeg 9f (jpeglib)", "jpeglib", "jpeg", "python", "same"),
    ("jpeglib-turbo", "libjpeg-turbo 2.1.0 (jpeglib)", "jpeglib", "jpeg", "python", "same"),
    ("jpeglib-mozjpeg", "mozjpeg 4.0.3 (jpeglib)", "jpeglib", "jpeg", "python", "same"),
    ("jpeg-js", "jpeg-js", "jpeg-js", "jpeg", "node", "take every fourth byte; look at the frame header"),
    ("sharp", "sharp, `.raw()`", "sharp", "jpeg", "node", "take every third byte (`info.channels`), or the next row"),
    ("sharp-b-w", "sharp, `.toColourspace('b-w').raw()`", "sharp", "jpeg", "node", "look at the frame header"),
    ("jsquash", "@jsquash/jpeg", "@jsquash/jpeg", "jpeg", "node", "take every fourth byte; look at the frame header"),
    ("libjpeg-turbo-js", "codec-libjpeg-turbo-8bit", "@cornerstonejs/codec-libjpeg-turbo-8bit", "jpeg", "node", "require `componentCount` 1"),
    ("zune-jpeg", "zune-jpeg, default", "zune-jpeg", "jpeg", "rust", "set the options of the next row"),
    ("zune-jpeg-luma", "zune-jpeg, `ColorSpace::Luma`, limits 65535", "zune-jpeg", "jpeg", "rust", "look at the frame header"),
    ("jpeg-decoder", "jpeg-decoder", "jpeg-decoder", "jpeg", "rust", "use zune-jpeg"),
    ("image", "image (zune-jpeg inside)", "image", "jpeg", "rust", "require `ColorType::L8`"),
    ("zenjpeg", "zenjpeg, `PixelFormat::Gray`, `auto_orient(false)`", "zenjpeg", "jpeg", "rust", "look at the frame header; overwrite the sampling factors with 1×1"),
    ("java-raster", "ImageIO of the JDK, `read().getRaster()`", None, "jpeg", "java", "require one band"),
    ("java-getrgb", "ImageIO of the JDK, `getRGB`", None, "jpeg", "java", "use `getRaster`"),
    ("ls-pillow-jpls", "pillow-jpls, `JplsImageFile`", "pillow-jpls", "jpegls", "python", "`pillow_jpls.JplsImageFile(file)`; require mode `L`; look for the end marker first"),
    ("ls-pillow-jpls-open", "pillow-jpls, `Image.open`", "pillow-jpls", "jpegls", "python", "use `JplsImageFile`"),
    ("ls-imagecodecs", "imagecodecs, `jpegls_decode`", "imagecodecs", "jpegls", "python", "look for the end marker first"),
    ("ls-pyjpegls", "pyjpegls, `decode`", "pyjpegls", "jpegls", "python", "look for the end marker first"),
    ("ls-charls-js", "codec-charls", "@cornerstonejs/codec-charls", "jpegls", "node", "require `componentCount` 1; look for the end marker first"),
    ("ls-cft-jpegls", "cft-jpegls", "cft-jpegls", "jpegls", "python", "convert from uint16; cut the stream after the end marker"),
    ("ls-pyav", "PyAV, codec `jpegls`", "av", "jpegls", "python", "look at the frame header; refuse precisions other than 8"),
    ("ls-pylibjpeg-libjpeg", "pylibjpeg-libjpeg", "pylibjpeg-libjpeg", "jpegls", "python", "avoid it"),
    ("ls-gdcm", "GDCM", "python-gdcm", "jpegls", "python", "needs DICOM around the stream"),
]

# name, encoder in the table, package, codec, kind of worker
ENCODERS = [
    ("pillow", "Pillow", "Pillow", "jpeg", "python"),
    ("opencv-grayscale", "OpenCV", "opencv-python-headless", "jpeg", "python"),
    ("imagecodecs", "imagecodecs", "imagecodecs", "jpeg", "python"),
    ("simplejpeg", "simplejpeg, `Gray`", "simplejpeg", "jpeg", "python"),
    ("imageio", "imageio", "imageio", "jpeg", "python"),
    ("pyvips", "pyvips", "pyvips-binary", "jpeg", "python"),
    ("jpeglib-6b", "libjpeg 6b (jpeglib)", "jpeglib", "jpeg", "python"),
    ("jpeglib-9f", "libjpeg 9f (jpeglib)", "jpeglib", "jpeg", "python"),
    ("jpeglib-mozjpeg", "mozjpeg 4.0.3 (jpeglib)", "jpeglib", "jpeg", "python"),
    ("pyav", "PyAV, `mjpeg` with `yuvj444p`", "av", "jpeg", "python"),
    ("sharp", "sharp, raw input of one channel", "sharp", "jpeg", "node"),
    ("sharp-b-w", "sharp, `.toColourspace('b-w')`", "sharp", "jpeg", "node"),
    ("jpeg-js", "jpeg-js", "jpeg-js", "jpeg", "node"),
    ("jsquash", "@jsquash/jpeg", "@jsquash/jpeg", "jpeg", "node"),
    ("image", "image, `ExtendedColorType::L8`", "image", "jpeg", "rust"),
    ("jpeg-encoder", "jpeg-encoder, `ColorType::Luma`", "jpeg-encoder", "jpeg", "rust"),
    ("zenjpeg", "zenjpeg, `grayscale`, `progressive(false)`", "zenjpeg", "jpeg", "rust"),
    ("mozjpeg-rs", "mozjpeg-rs, `baseline_optimized`, `encode_gray`", "mozjpeg-rs", "jpeg", "rust"),
    ("java-raster", "ImageIO of the JDK, `TYPE_BYTE_GRAY`", None, "jpeg", "java"),
    ("ls-pillow-jpls", "pillow-jpls", "pillow-jpls", "jpegls", "python"),
    ("ls-imagecodecs", "imagecodecs", "imagecodecs", "jpegls", "python"),
    ("ls-pyjpegls", "pyjpegls", "pyjpegls", "jpegls", "python"),
    ("ls-pyav", "PyAV", "av", "jpegls", "python"),
    ("ls-charls-js", "codec-charls", "@cornerstonejs/codec-charls", "jpegls", "node"),
]

SIZES = [(1, 1), (1, 7), (9, 1), (8, 8), (17, 9), (64, 48)]
KINDS = ["smooth", "noise", "cells", "residuals", "wrapped residuals"]
QUALITIES = [20, 30, 50, 75, 90, 95, 100]


# The planes


def paint(kind, width, height, seed=1):
    state, samples = seed, bytearray()
    for i in range(width * height):
        x, y = i % width, i // width
        state = (state * 1664525 + 1013904223) % 2**32
        noise = state >> 24
        if kind == "smooth":
            value = (x * 3 + y * 2 + (x * y >> 5)) % 200 + 28
        elif kind == "noise":
            value = noise
        elif kind == "cells":
            value = (x // 3 + y // 5) % 2 * 255
        else:
            residual = (noise % 9 + (noise >> 4) % 9) - 8 + (x % 16 == 15) * 20
            value = (128 + residual) if kind == "residuals" else residual
        samples.append(value % 256)
    return bytes(samples)


def segments(stream):
    """Splits a JPEG stream into (marker, segment with its marker) and the rest from the first SOS on."""
    found, at = [], 2
    while stream[at + 1] != 0xDA:
        length = 2 + int.from_bytes(stream[at + 2:at + 4], "big")
        found.append((stream[at + 1], stream[at:at + length]))
        at += length
    return found, stream[at:]


def join(found, rest, fill=b""):
    return b"\xff\xd8" + b"".join(fill + segment for _, segment in found) + fill + rest


def replace(segment, at, value):
    return segment[:at] + bytes([value]) + segment[at + 1:]


def map_segments(stream, marker, change):
    found, rest = segments(stream)
    return join([(code, change(segment) if code == marker else segment) for code, segment in found], rest)


def with_component(stream, number):
    stream = map_segments(stream, 0xC0, lambda frame: replace(frame, 10, number))
    found, rest = segments(stream)
    return join(found, replace(rest, 5, number))


def with_sampling(stream, horizontal, vertical):
    return map_segments(stream, 0xC0, lambda frame: replace(frame, 11, horizontal << 4 | vertical))


def with_wide_tables(stream, frame_marker):
    def widen(segment):
        return ls_encoder.segment(0xDB, bytes([0x10 | segment[4]]) + b"".join(bytes([0, step]) for step in segment[5:]))
    stream = map_segments(stream, 0xDB, widen)
    return map_segments(stream, 0xC0, lambda frame: replace(frame, 1, frame_marker))


def with_table_numbers(stream):
    """Gives the quantization table number 3 and the Huffman tables number 1."""
    stream = map_segments(stream, 0xDB, lambda table: replace(table, 4, 3))
    stream = map_segments(stream, 0xC0, lambda frame: replace(frame, 12, 3))
    stream = map_segments(stream, 0xC4, lambda table: replace(table, 4, table[4] | 1))
    found, rest = segments(stream)
    return join(found, replace(rest, 6, 0x11))


def with_joined_tables(stream):
    found, rest = segments(stream)
    tables = b"".join(segment[4:] for code, segment in found if code == 0xC4)
    kept = [(code, segment) for code, segment in found if code != 0xC4]
    return join(kept + [(0xC4, ls_encoder.segment(0xC4, tables))], rest)


def with_tables_after_the_frame(stream):
    found, rest = segments(stream)
    return join(sorted(found, key=lambda pair: pair[0] == 0xDB), rest)


def with_number_of_lines(stream):
    _, _, height, _, _ = frame_header(stream)
    stream = map_segments(stream, 0xC0, lambda frame: frame[:5] + b"\0\0" + frame[7:])
    return stream[:-2] + ls_encoder.segment(0xDC, height.to_bytes(2, "big")) + stream[-2:]


def without_jfif(stream):
    found, rest = segments(stream)
    return join([(code, segment) for code, segment in found if code != 0xE0], rest)


def with_segment(stream, segment):
    found, rest = segments(stream)
    return join(found[:1] + [(segment[1], segment)] + found[1:], rest)


EXIF = b"Exif\0\0II*\0\x08\0\0\0\1\0\x12\1\3\0\1\0\0\0\6\0\0\0\0\0\0\0"

JPEG_VARIANTS = {
    "no JFIF": without_jfif,
    "component number 0": lambda stream: with_component(stream, 0),
    "component number 82": lambda stream: with_component(stream, 82),
    "component number 255": lambda stream: with_component(stream, 255),
    "sampling 2×2": lambda stream: with_sampling(stream, 2, 2),
    "sampling 3×2": lambda stream: with_sampling(stream, 3, 2),
    "sampling 4×4": lambda stream: with_sampling(stream, 4, 4),
    "16-bit tables in SOF0": lambda stream: with_wide_tables(stream, 0xC0),
    "16-bit tables in SOF1": lambda stream: with_wide_tables(stream, 0xC1),
    "table numbers 3/1/1": with_table_numbers,
    "Huffman tables in one segment": with_joined_tables,
    "DQT after the frame header": with_tables_after_the_frame,
    "fill bytes": lambda stream: join(*segments(stream), fill=b"\xff\xff"),
    "EXIF orientation 6": lambda stream: with_segment(stream, ls_encoder.segment(0xE1, EXIF)),
    "comment": lambda stream: with_segment(stream, ls_encoder.segment(0xFE, b"a comment")),
    "DNL": with_number_of_lines,
}


def ptm(width, height, stream, codec):
    """Returns a PTM with nine equal planes."""
    def line(value):
        return " ".join([str(value)] * 9) + "\n"
    name = "JPEGLS_LRGB" if codec == "jpegls" else "JPEG_LRGB"
    header = (f"PTM_1.2\nPTM_FORMAT_{name}\n{width}\n{height}\n1 1 1 1 1 1\n0 0 0 0 0 0\n0\n" + line(0) * 3
              + "0 1 2 3 4 5 6 7 8\n" + line(-1) + line(len(stream)) + line(0))
    return header.encode() + stream * 9


class Reference:
    """`ptm-conform reference serve`."""

    def __init__(self, program, folder):
        self.file = folder / "reference.ptm"
        self.process = subprocess.Popen([program, "reference", "serve"], stdin=subprocess.PIPE, stdout=subprocess.PIPE)

    def decode(self, width, height, stream, codec):
        """Returns the samples of a plane, or None if the reference refuses it."""
        self.file.write_bytes(ptm(width, height, stream, codec))
        self.process.stdin.write(b"1 raw %s\n" % os.fsencode(self.file))
        self.process.stdin.flush()
        words = self.process.stdout.readline().split()
        if words[1] != b"ok":
            return None
        frame = self.process.stdout.read(int(words[2])).split(b"\n", 1)[1]
        rows = [frame[y * width * 9:(y + 1) * width * 9:9] for y in range(height)]
        return b"".join(reversed(rows))


def jpeg_streams(encoder, restart_encoder, reference):
    """Returns (group, width, height, stream, samples). The group of ordinary planes is None."""
    result = []
    for width, height in SIZES:
        for kind in KINDS:
            for quality in QUALITIES:
                stream = encoder.encode(paint(kind, width, height), width, height, quality)
                result.append((None, width, height, stream, reference.decode(width, height, stream, "jpeg")))
    for kind in "smooth", "noise", "cells":
        for width, height in (17, 9), (64, 48):
            stream = encoder.encode(paint(kind, width, height), width, height, 75)
            samples = reference.decode(width, height, stream, "jpeg")
            for name, change in JPEG_VARIANTS.items():
                changed = change(stream)
                if name not in ("DNL", "sampling 3×2") and reference.decode(width, height, changed, "jpeg") != samples:
                    raise SystemExit(f"the reference does not decode the variant {name!r} as the plain stream")
                result.append((name, width, height, changed, samples))
            stream = restart_encoder.encode(paint(kind, width, height), width, height, 75)
            result.append(("restart intervals", width, height, stream, reference.decode(width, height, stream, "jpeg")))
    if any(samples is None for *_, samples in result):
        raise SystemExit("the reference refuses a stream of Pillow")
    return result


def spiff_header(width, height):
    """Returns the header and the end of its directory, which contains a second SOI (T.84 Annex F)."""
    size = height.to_bytes(4, "big") + width.to_bytes(4, "big")
    header = ls_encoder.segment(0xE8, b"SPIFF\0\2\0\0\1" + size + b"\x08\x08\6\1" + bytes([0, 0, 0, 96] * 2))
    return header + ls_encoder.segment(0xE8, b"\0\0\0\1\xff\xd8")


def jpeg_ls_variants():
    """Yields (name, arguments of ls_encoder.encode, largest sample)."""
    yield "near 1", dict(near=1), 255
    yield "near 2", dict(near=2), 255
    yield "near 3", dict(near=3), 255
    yield "near 10", dict(near=10), 255
    yield "presets as by default", dict(presets=(255, 3, 7, 21, 64)), 255
    yield "presets with other thresholds", dict(presets=(255, 9, 9, 30, 64)), 255
    yield "presets with RESET 3", dict(presets=(255, 3, 7, 21, 3)), 255
    yield "presets with RESET 31", dict(presets=(255, 3, 7, 21, 31)), 255
    yield "presets with RESET 255", dict(presets=(255, 3, 7, 21, 255)), 255
    yield "presets all zero", dict(presets=(0, 0, 0, 0, 0)), 255
    yield "presets with zeros and other thresholds", dict(presets=(0, 9, 9, 30, 0)), 255
    yield "presets with zeros and RESET 31", dict(presets=(0, 0, 0, 0, 31)), 255
    yield "presets with MAXVAL and thresholds 0", dict(presets=(255, 0, 0, 0, 31)), 255
    yield "presets before the frame header", dict(presets=(255, 9, 9, 30, 64)), 255
    yield "MAXVAL 127", dict(presets=(127, 2, 3, 11, 64)), 127
    yield "MAXVAL 200", dict(presets=(200, 3, 7, 21, 64)), 200
    yield "precision 7", dict(bits=7), 127
    yield "precision 5", dict(bits=5), 31
    yield "precision 2", dict(bits=2), 3
    yield "SPIFF header", dict(), 255
    yield "comment and APP9", dict(between=ls_encoder.segment(0xFE, b"text") + ls_encoder.segment(0xE9, b"data")), 255
    yield "component number 0", dict(component=0), 255
    yield "component number 255", dict(component=255), 255
    yield "fill bytes", dict(fill=b"\xff\xff"), 255
    yield "a zero after the end", dict(after=b"\0"), 255
    yield "DNL", dict(dnl=True), 255


def jpeg_ls_streams(reference):
    result = []
    for width, height in SIZES:
        for kind in KINDS:
            stream, samples = ls_encoder.encode(paint(kind, width, height), width, height)
            if reference.decode(width, height, stream, "jpegls") != samples:
                raise SystemExit("the reference does not decode a stream of codecs/ls_encoder.py as encoded")
            result.append((None, width, height, stream, samples))
    for name, arguments, largest in jpeg_ls_variants():
        for kind in "smooth", "noise", "cells":
            for width, height in (17, 9), (33, 24):
                plane = bytes(sample % (largest + 1) for sample in paint(kind, width, height))
                stream, samples = ls_encoder.encode(plane, width, height, **arguments)
                if name == "SPIFF header":
                    stream = stream[:2] + spiff_header(width, height) + stream[2:]
                if name == "presets before the frame header":
                    at = stream.index(b"\xff\xf8")
                    stream = stream[:2] + stream[at:at + 15] + stream[2:at] + stream[at + 15:]
                found = reference.decode(width, height, stream, "jpegls")
                if found not in (None, samples):
                    raise SystemExit(f"the reference does not decode the variant {name!r} as encoded")
                result.append((name, width, height, stream, samples))
    return result


# The libraries


class Worker:
    """A library behind the protocol of codecs/worker.py. It is started again after it ended or hung."""

    def __init__(self, command):
        self.command, self.process = command, None

    def request(self, line, body):
        if self.process is None or self.process.poll() is not None:
            self.process = subprocess.Popen(self.command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
        process = self.process
        timer = threading.Timer(ANSWER_SECONDS, process.kill)
        timer.start()
        try:
            process.stdin.write(line + body)
            process.stdin.flush()
            words = process.stdout.readline().split()
            if words and words[0] == b"ok":
                answer = process.stdout.read(int(words[4]))
                if len(answer) == int(words[4]):
                    return (*map(int, words[1:4]), answer)
        except BrokenPipeError:
            words = []
        finally:
            timer.cancel()
        if words:
            return b" ".join(words[1:]).decode()
        status = process.wait()
        hung = status == -signal.SIGKILL
        return "no answer in %d s" % ANSWER_SECONDS if hung else "the process ended with status %d" % status

    def decode(self, stream):
        return self.request(b"decode %d\n" % len(stream), stream)

    def try_encode(self, samples, width, height, quality):
        return self.request(b"encode %d %d %d %d\n" % (width, height, quality, len(samples)), samples)

    def encode(self, *arguments):
        answer = self.try_encode(*arguments)
        if isinstance(answer, str):
            raise SystemExit(answer)
        return answer[3]

    def close(self):
        if self.process is not None and self.process.poll() is None:
            self.process.stdin.close()
            try:
                self.process.wait(10)
            except subprocess.TimeoutExpired:
                self.process.kill()


def install(folder, lock, kinds):
    """Installs the packages. Returns the commands of the workers by kind, and the packages that are there."""
    commands, installed = {}, set()
    python = folder / "venv/bin/python"
    problem = None if python.exists() else run([sys.executable, "-m", "venv", folder / "venv"])
    if problem:
        raise SystemExit(f"no virtual environment: {problem}")
    commands["python"] = [python, PARTS / "worker.py"]
    for package, version in lock["pypi"].items():
        have = run([python, "-c", f"import importlib.metadata as m; assert m.version('{package}') == '{version}'"]) is None
        problem = None if have else run([python, "-m", "pip", "install", "-q", f"{package}=={version}"])
        say(f"{package} {version}: " + (f"skipped, pip says: {problem}" if problem else "installed"))
        if not problem:
            installed.add(package)
    if "node" in kinds and shutil.which("npm"):
        (folder / "node").mkdir(exist_ok=True)
        (folder / "node/package.json").write_text("{}")
        wanted = [f"{package}@{version}" for package, version in lock["npm"].items()]
        command = ["npm", "install", "--fetch-retries=0", "--no-audit", "--no-fund", *wanted]
        problem = run(command, cwd=folder / "node")
        if problem:                                 # the second try trusts the certificates of the system
            problem = run(command, cwd=folder / "node", env={**os.environ, "NODE_OPTIONS": "--use-openssl-ca"})
        say("npm: " + (f"skipped, npm says: {problem}" if problem else "installed"))
        if not problem:
            installed.update(lock["npm"])
            commands["node"] = ["node", PARTS / "worker.mjs", folder / "node"]
    elif "node" in kinds:
        say("npm is missing: the libraries in JavaScript are skipped")
    if "rust" in kinds and shutil.which("cargo"):
        project = folder / "rust"
        (project / "src").mkdir(parents=True, exist_ok=True)
        shutil.copy(PARTS / "worker.rs", project / "src/main.rs")
        features = {"jpeg-decoder": ", default-features = false", "image": ", default-features = false, features = [\"jpeg\"]"}
        needed = "".join(f"{package} = {{ version = \"={version}\"{features.get(package, '')} }}\n" for package, version in lock["cargo"].items())
        (project / "Cargo.toml").write_text("[package]\nname = \"worker\"\nversion = \"0.0.0\"\nedition = \"2021\"\n[workspace]\n"
                                            "[profile.dev]\nopt-level = 1\n[dependencies]\n" + needed)
        problem = run(["cargo", "build", "--quiet", "--target-dir", project / "target"], cwd=project)
        say("cargo: " + (f"skipped, cargo says: {problem}" if problem else "built"))
        if not problem:
            installed.update(lock["cargo"])
            commands["rust"] = [project / "target/debug/worker"]
    elif "rust" in kinds:
        say("cargo is missing: the libraries in Rust are skipped")
    if "java" in kinds and shutil.which("javac"):
        problem = run(["javac", "-d", folder / "java", PARTS / "Worker.java"])
        say("javac: " + (f"skipped: {problem}" if problem else "built"))
        if not problem:
            commands["java"] = ["java", "-XX:+UseSerialGC", "-cp", folder / "java", "Worker"]
    elif "java" in kinds:
        say("javac is missing: ImageIO is skipped")
    return commands, installed


def java_version():
    text = subprocess.run(["java", "-version"], stderr=subprocess.PIPE, text=True).stderr
    return re.search(r'"(.*?)"', text)[1]


# The measurements


def compare(worker, streams):
    """Returns the result of a decoder on the streams."""
    exact = total = wrong = count = most = 0
    channels, variants = set(), {}
    for group, width, height, stream, samples in streams:
        answer = worker.decode(stream)
        verdict, difference = "refused", None
        if not isinstance(answer, str):
            found_width, found_height, found_channels, found = answer
            first = found[::found_channels]
            if (found_width, found_height) != (width, height):
                verdict = f"{found_width}×{found_height} instead of {width}×{height}"
            elif any(found[at::found_channels] != first for at in range(1, min(found_channels, 3))):
                verdict = "not gray"
            else:
                differences = [abs(a - b) for a, b in zip(first, samples)]
                difference = max(differences)
                verdict = "exact" if difference == 0 else "within 1" if difference == 1 else "wrong"
                channels.add(found_channels)
        if group is None:
            total += 1
            if difference is not None:
                exact += difference == 0
                most = max(most, difference)
                wrong += sum(d > 0 for d in differences)
                count += len(samples)
            else:
                variants.setdefault(f"{width}×{height}", []).append(verdict)
        else:
            variants.setdefault(group, []).append(verdict)
    return {"exact": exact, "planes": total, "largest": most, "share": round(100 * wrong / max(count, 1), 2),
            "channels": sorted(channels), "variants": variants}


def describe_variants(result, lossless):
    """Returns the legal variants that are refused, and those decoded wrongly."""
    refused, wrong = [], []
    right = ["exact"] if lossless else ["exact", "within 1"]
    if all(any(verdict not in (*right, "refused") for verdict in verdicts) for name, verdicts in result["variants"].items() if name != "DNL"):
        return ", ".join(name for name, verdicts in result["variants"].items() if set(verdicts) == {"refused"}) or "–", "all"
    for name, verdicts in result["variants"].items():
        bad = [verdict for verdict in verdicts if verdict not in right]
        part = "" if len(bad) == len(verdicts) else f" ({len(bad)} of {len(verdicts)})"
        if bad and all(verdict == "refused" for verdict in bad):
            refused.append(name + part)
        elif bad:
            wrong.append(name + part)
    return ", ".join(refused) or "–", ", ".join(wrong) or "–"


def check(program, python, name, codec, header, command, folder):
    """Runs the example with this codec through `check`. Returns the number of failures and their causes."""
    empty = folder / "check"                        # `check` takes a word as a path if there is a file of that name
    shutil.rmtree(empty, ignore_errors=True)
    empty.mkdir()
    report = empty / "check.json"
    reader = [python, PARTS / "reader.py", ROOT / "examples/decoders/ptm_decoder.py", codec, header, *command, name, "--"]
    subprocess.run([program, "check", "-q", "--clause", "2.9", "--serve", "--report", empty / "check.yaml", "--json", report, "--", *reader],
                   stdout=subprocess.DEVNULL, cwd=empty)
    report = json.loads(report.read_text())
    failures = sum(case["outcome"] not in ("pass", "inconclusive", "unsupported", "not judged", "not asked") for case in report["cases"])
    causes = [(len(cause.get("explains", [])), cause["effect"]) for cause in report.get("diagnoses", [])]
    return {"failures": failures, "inconclusive": sum(case["outcome"] == "inconclusive" for case in report["cases"]), "causes": causes}


# The encoders

LUMINANCE = [16, 11, 10, 16, 24, 40, 51, 61, 12, 12, 14, 19, 26, 58, 60, 55, 14, 13, 16, 24, 40, 57, 69, 56, 14, 17, 22, 29, 51, 87, 80, 62,
             18, 22, 37, 56, 68, 109, 103, 77, 24, 35, 55, 64, 81, 104, 113, 92, 49, 64, 78, 87, 103, 121, 120, 101, 72, 92, 95, 98, 112, 100, 103, 99]
ZIGZAG = sorted(range(64), key=lambda i: (i // 8 + i % 8, (i // 8 if (i // 8 + i % 8) % 2 else i % 8)))


def ijg_table(quality, most):
    """Returns the table of T.81 K.1 scaled by the formula of IJG, in zigzag order."""
    scale = 5000 // quality if quality < 50 else 200 - 2 * quality
    return [min(max((LUMINANCE[i] * scale + 50) // 100, 1), most) for i in ZIGZAG]


def describe_jpeg(stream, quality):
    found, _ = segments(stream)
    tables, applications = {}, []
    frame = "?"
    for code, segment in found:
        body = segment[4:]
        if code == 0xDB:
            while body:
                wide, number = body[0] >> 4, body[0] & 15
                steps = body[1:65] if not wide else [256 * body[1 + 2 * i] + body[2 + 2 * i] for i in range(64)]
                tables[number] = bool(wide), list(steps)
                body = body[1 + 64 * (1 + wide):]
        elif code in (0xC0, 0xC1, 0xC2):
            frame = f"SOF{code - 0xC0}"
            components = [body[6 + 3 * i:9 + 3 * i] for i in range(body[5])]
        elif 0xE0 <= code <= 0xEF:
            applications.append({0xE0: "JFIF", 0xE1: "Exif", 0xEE: "Adobe", 0xE2: "ICC"}.get(code, "APP%d" % (code - 0xE0)) + f" {len(segment)}")
        elif code == 0xFE:
            applications.append("COM")
    used = tables[components[0][2]]
    relation = "IJG" if used[1] in (ijg_table(quality, 255), ijg_table(quality, 32767)) else "other"
    return {"components": len(components), "frame": frame, "sampling": " ".join(f"{c[1] >> 4}×{c[1] & 15}" for c in components),
            "restart": any(code == 0xDD for code, _ in found), "wide": used[0], "table": relation, "segments": ", ".join(applications) or "none"}


def describe_jpeg_ls(stream):
    found, rest = segments(stream)
    precision = next(segment[4] for code, segment in found if code == 0xF7)
    length = int.from_bytes(rest[2:4], "big")
    return {"precision": precision, "near": rest[2 + length - 3], "presets": any(code == 0xF8 for code, _ in found),
            "segments": "SPIFF" if b"SPIFF\0" in stream[:40] else ", ".join("APP%d" % (code - 0xE0) for code, _ in found if 0xE0 <= code <= 0xEF) or "none", "even": len(stream) % 2 == 0}


def spread(values):
    """Joins the distinct values in the order of their first appearance."""
    return ", ".join(dict.fromkeys(str(value) for value in values))


def measure_encoder(worker, codec):
    seen, errors = [], []
    for kind in "smooth", "noise", "cells":
        for width, height in SIZES:
            for quality in (20, 75, 90, 100) if codec == "jpeg" else (0,):
                answer = worker.try_encode(paint(kind, width, height), width, height, quality)
                if isinstance(answer, str):
                    errors.append(f"{width}×{height} {kind}")
                else:
                    seen.append((quality, describe_jpeg(answer[3], quality) if codec == "jpeg" else describe_jpeg_ls(answer[3])))
    failed = list(dict.fromkeys(errors))
    if not seen:
        return {"failed": failed}
    if codec == "jpegls":
        summary = {key: spread(sorted({values[key] for _, values in seen})) for key in ("precision", "near", "presets", "segments", "even")}
        return {**summary, "failed": failed}
    summary = {key: spread(values[key] for _, values in seen) for key in ("components", "frame", "sampling", "segments")}
    summary["restart"] = any(values["restart"] for _, values in seen)
    summary["wide"] = any(values["wide"] for _, values in seen)
    tables = {quality: spread(values["table"] for at, values in seen if at == quality) for quality, _ in seen}
    summary["table"] = "IJG" if set(tables.values()) == {"IJG"} else "other" if "IJG" not in tables.values() else \
        "IJG at " + ", ".join(str(quality) for quality, table in tables.items() if table == "IJG") + ", else other"
    return {**summary, "failed": failed}


# The tables


def yes(flag):
    return "yes" if flag else "no"


def check_cell(result):
    if result is None:
        return "not run"
    if not result["failures"]:
        return "0"
    return f"{result['failures']}: " + "; ".join(f"{effect} ({count})" for count, effect in result["causes"])


def markdown(results, recorded, date):
    lines = []
    for codec, title in ("jpeg", "JPEG decoders"), ("jpegls", "JPEG-LS decoders"):
        lines += [f"### {title}", "", "| library | version, date | exact planes | largest difference | samples that differ | channels for gray "
                  "| legal variants refused | legal variants decoded wrongly | what to set |", "|---|---|---|---|---|---|---|---|---|"]
        for row in results["decoders"]:
            if row["codec"] == codec:
                measured = row["streams"]
                refused, wrong = describe_variants(measured, codec == "jpegls")
                lines.append(f"| {row['library']} | {row['version']}, {date} | {measured['exact']} of {measured['planes']} | {measured['largest']} "
                             f"| {measured['share']:g} % | {spread(measured['channels'])} | {refused} | {wrong} | {row['set']} |")
        lines += [f"| {' | '.join(cells)} |" for cells in recorded[codec]] + [""]
    lines += ["### Failures of `check`", "", "| library | version | as the library answers | with the frame header checked first |", "|---|---|---|---|"]
    for row in results["decoders"]:
        if row.get("check"):
            codec = "JPEG-LS" if row["codec"] == "jpegls" else "JPEG"
            cells = [check_cell(row["check"].get(header)) for header in ("as-is", "header")]
            lines.append(f"| {codec}: {row['library']} | {row['version']} | {' | '.join(cells)} |")
    lines += ["", "### JPEG encoders in their default call", "", "| encoder | version, date | components | frame | sampling | 16-bit table "
              "| DRI | other segments (bytes) | table for a quality | fails |", "|---|---|---|---|---|---|---|---|---|---|"]
    for row in results["encoders"]:
        values = row["result"]
        if row["codec"] == "jpeg" and "frame" in values:
            lines.append(f"| {row['library']} | {row['version']}, {date} | {values['components']} | {values['frame']} | {values['sampling']} "
                         f"| {yes(values['wide'])} | {yes(values['restart'])} | {values['segments']} | {values['table']} | {', '.join(values['failed']) or '–'} |")
    lines += [f"| {' | '.join(cells)} |" for cells in recorded["jpeg encoders"]]
    lines += ["", "### JPEG-LS encoders in their default call", "", "| encoder | version, date | precision | NEAR | LSE | SPIFF or APPn | even length | fails |",
              "|---|---|---|---|---|---|---|---|"]
    for row in results["encoders"]:
        values = row["result"]
        if row["codec"] == "jpegls" and "near" in values:
            lines.append(f"| {row['library']} | {row['version']}, {date} | {values['precision']} | {values['near']} | {values['presets'].replace('True', 'yes').replace('False', 'no')} "
                         f"| {values['segments']} | {values['even'].replace('False, True', 'by chance')} | {', '.join(values['failed']) or '–'} |")
    return "\n".join(lines) + "\n"


def main():
    parser = measuring.option_parser(__doc__)
    parser.add_argument("--only", help="run only the libraries whose name contains this word")
    parser.add_argument("--no-check", action="store_true", help="do not run `check`")
    parser.add_argument("--folder", type=pathlib.Path, help="install the packages here and keep them")
    options = measuring.parse(parser)
    with measuring.package_folder(options.folder, "codecs") as folder:
        measure_all(options, folder)


def measure_all(options, folder):
    program = options.program
    lock = measuring.read_lock(HERE / "codecs.lock")
    versions = {**lock["pypi"], **lock["npm"], **lock["cargo"]}
    chosen = [row for row in DECODERS if not options.only or options.only in row[0]]
    chosen_encoders = [row for row in ENCODERS if not options.only or options.only in row[0]]
    commands, installed = install(folder, lock, {row[4] for row in chosen + chosen_encoders})
    python = commands["python"][0]

    def available(package, kind):
        return kind in commands and (package is None or package in installed)

    def version(package):
        return versions[package] if package else java_version()

    reference = Reference(program, folder)
    encoder, restart = [Worker([*commands["python"], name]) for name in ("pillow", "pillow-restart")]
    streams = {"jpeg": jpeg_streams(encoder, restart, reference), "jpegls": jpeg_ls_streams(reference)}
    say(f"{len(streams['jpeg'])} JPEG streams, {len(streams['jpegls'])} JPEG-LS streams")
    results = {"decoders": [], "encoders": []}
    for name, library, package, codec, kind, setting in chosen:
        if not available(package, kind):
            say(f"{library}: skipped, because it is not installed")
            continue
        worker = Worker([*commands[kind], name])
        row = {"name": name, "library": library, "version": version(package), "codec": codec, "set": setting}
        row["streams"] = compare(worker, streams[codec])
        worker.close()
        say(f"{library}: {row['streams']['exact']} of {row['streams']['planes']} planes exact, largest difference {row['streams']['largest']}")
        if not options.no_check:
            row["check"] = {}
            for header in "as-is", "header":
                row["check"][header] = check(program, python, name, codec, header, commands[kind], folder)
                say(f"{library}, check, {header}: {check_cell(row['check'][header])}")
        results["decoders"].append(row)
    for name, library, package, codec, kind in chosen_encoders:
        if available(package, kind):
            worker = Worker([*commands[kind], name])
            results["encoders"].append({"library": library, "version": version(package), "codec": codec, "result": measure_encoder(worker, codec)})
            worker.close()
            say(f"encoder {library}: {results['encoders'][-1]['result']}")
    recorded = json.loads((PARTS / "recorded.json").read_text())
    measuring.write_results(options, "scripts/codecs.py", results, markdown(results, recorded, datetime.date.today().isoformat()))


if __name__ == "__main__":
    main()
