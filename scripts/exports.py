#!/usr/bin/env python3
"""Measures which programs read what `ptm-conform export` and `render` write, and how programs identify PTM files. Prints the tables of
docs/exports.md in Markdown.

    cargo build
    scripts/exports.py [--program target/debug/ptm-conform] [--folder FOLDER] [--json FILE] [--docs docs/exports.md]

Installs the versions of scripts/exports.lock from PyPI and npm in a temporary folder, and skips what cannot be installed. Runs the snippets
of the document, too. --folder keeps the installed packages for the next run. Needs Python 3.9, and optionally node, file and gio.
"""

import datetime
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys

import measuring
from measuring import run, say, table

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent
PARTS = HERE / "exports"
SECONDS = 120

CHANNELS = {
    "LRGB": ["a0", "a1", "a2", "a3", "a4", "a5", "R", "G", "B"],
    "RGB": [f"{color}.a{i}" for color in ("red", "green", "blue") for i in range(6)],
    "LUM": ["a0", "a1", "a2", "a3", "a4", "a5", "Cr", "Cb"],
}

# library in the table, reader in read.py or read.mjs, package, environment
EXR = [
    ("OpenEXR, `separate_channels=True`", "openexr", "OpenEXR", "pypi"),
    ("OpenEXR, default", "openexr_merged", "OpenEXR", "pypi"),
    ("OpenImageIO", "openimageio", "OpenImageIO", "pypi"),
    ("pyexr", "pyexr", "pyexr", "pypi"),
    ("MinEXR", "minexr", "minexr", "pypi"),
    ("OpenCV 4, `OPENCV_IO_ENABLE_OPENEXR=1`", "opencv", "opencv-python-headless", "pypi-b"),
    ("OpenCV 5, `OPENCV_IO_ENABLE_OPENEXR=1`", "opencv", "opencv-python-headless", "pypi"),
    ("FFmpeg (PyAV)", "pyav", "av", "pypi-b"),
    ("imageio", "imageio", "imageio", "pypi"),
    ("imageio with PyAV", "imageio", "imageio", "pypi-b"),
    ("Pillow", "pillow", "Pillow", "pypi"),
    ("pyvips-binary", "pyvips", "pyvips-binary", "pypi"),
    ("imagecodecs", "imagecodecs", "imagecodecs", "pypi"),
    ("three, EXRLoader", "three", "three", "npm"),
    ("parse-exr", "parse-exr", "parse-exr", "npm"),
]
NPY = [("NumPy", "numpy_load", "numpy", "pypi"), ("npyjs", "npyjs", "npyjs", "npm")]
TIFF = [
    ("tifffile", "tifffile", "tifffile", "pypi"),
    ("OpenImageIO", "openimageio", "OpenImageIO", "pypi"),
    ("imageio (tifffile inside)", "imageio", "imageio", "pypi"),
    ("imagecodecs (tifffile inside)", "imagecodecs", "imagecodecs", "pypi"),
    ("pyvips", "pyvips", "pyvips-binary", "pypi"),
    ("Pillow", "pillow", "Pillow", "pypi"),
    ("OpenCV, `IMREAD_UNCHANGED`", "opencv", "opencv-python-headless", "pypi"),
]
IMAGES = [
    ("Pillow", "pillow", "Pillow", "pypi"),
    ("OpenCV, `IMREAD_UNCHANGED`", "opencv", "opencv-python-headless", "pypi"),
    ("imageio", "imageio", "imageio", "pypi"),
    ("pyvips", "pyvips", "pyvips-binary", "pypi"),
    ("imagecodecs", "imagecodecs", "imagecodecs", "pypi"),
    ("OpenImageIO", "openimageio", "OpenImageIO", "pypi"),
    ("tifffile", "tifffile", "tifffile", "pypi"),
    ("sharp", "sharp", "sharp", "npm"),
    ("pngjs", "pngjs", "pngjs", "npm"),
    ("fast-png", "fast-png", "fast-png", "npm"),
]
# program in the table, in identify.py or identify.mjs, package, environment, how to configure it
IDENTIFIERS = [
    ("file", "file", None, "pypi", ""),
    ("file with ptm.magic", "file+PTM", None, "pypi", "`file -m docs/identify/ptm.magic`"),
    ("libmagic (pylibmagic)", "libmagic", "pylibmagic", "pypi", ""),
    ("libmagic with ptm.magic", "libmagic+PTM", "pylibmagic", "pypi", "`magic.Magic(magic_file=\"docs/identify/ptm.magic\")`"),
    ("fido", "fido", "opf-fido", "pypi", ""),
    ("fido with ptm-fido.xml", "fido+PTM", "opf-fido", "pypi", "`fido -loadformats docs/identify/ptm-fido.xml`"),
    ("siegfried (pygfried)", "siegfried", "pygfried", "pypi", ""),
    ("Magika", "magika", "magika", "pypi", "exclude `.ptm`"),
    ("puremagic", "puremagic", "puremagic", "pypi", "exclude `.ptm`"),
    ("filetype", "filetype", "filetype", "pypi", ""),
    ("file-type", "file-type", "file-type", "npm", ""),
    ("magic-bytes.js", "magic-bytes.js", "magic-bytes.js", "npm", ""),
    ("FFmpeg (PyAV)", "pyav", "av", "pypi-b", "exclude `.ptm`"),
    ("GNOME (gio)", "gio", None, "pypi", ""),
    ("GNOME (gio) with ptm-mime.xml", "gio+PTM", None, "pypi", "`xdg-mime install --novendor docs/identify/ptm-mime.xml`"),
]
FORMATS = ["LRGB", "RGB", "LUM", "PTM_LUT", "PTM_C_LUT", "JPEG_LRGB", "JPEG_RGB", "JPEGLS_LRGB", "JPEGLS_RGB"]


# The packages


def install(folder, lock):
    """Installs the packages. Returns the installed packages of each environment."""
    installed = {}
    for name in "pypi", "pypi-b":
        python = folder / name / "bin/python"
        problem = None if python.exists() else run([sys.executable, "-m", "venv", folder / name])
        if problem:
            raise SystemExit(f"no virtual environment: {problem}")
        installed[name] = set()
        for package, version in lock[name].items():
            have = run([python, "-c", f"import importlib.metadata as m; assert m.version('{package}') == '{version}'"]) is None
            problem = None if have else run([python, "-m", "pip", "install", "-q", "--disable-pip-version-check", f"{package}=={version}"])
            say(f"{package} {version}: " + (f"skipped, pip says: {problem}" if problem else "installed"))
            if not problem:
                installed[name].add(package)
    installed["npm"] = set()
    if not shutil.which("npm"):
        say("npm is missing: the libraries in JavaScript are skipped")
        return installed
    (folder / "npm").mkdir(exist_ok=True)
    (folder / "npm/package.json").write_text("{}")
    command = ["npm", "install", "--fetch-retries=0", "--no-audit", "--no-fund", *[f"{package}@{version}" for package, version in lock["npm"].items()]]
    problem = run(command, cwd=folder / "npm")
    if problem:                                         # the second try trusts the certificates of the system
        problem = run(command, cwd=folder / "npm", env={**os.environ, "NODE_OPTIONS": "--use-openssl-ca"})
    say("npm: " + (f"skipped, npm says: {problem}" if problem else "installed"))
    installed["npm"] = set() if problem else set(lock["npm"])
    return installed


# The files


def make_map(format):
    """Returns a map of 37×29 texels whose planes differ in every value that matters."""
    state, channels = 1, len(CHANNELS[format])
    data = bytearray()
    for _ in range(37 * 29 * channels):
        state = (state * 1664525 + 1013904223) % 2**32
        data.append(state >> 24)
    lines = ["PTM_1.2", "PTM_FORMAT_" + format, "37", "29", "2 0.5 1.5 1 0.25 1", "128 100 127 131 90 0"]
    if format == "LUM":
        lines.append("1 1 1 0 0 -0.344 1.772 0 1.402 -0.714 0 0 -179.456 135.458 -226.816 0")
    return ("\n".join(lines) + "\n").encode() + bytes(data)


def make_files(program, folder, python):
    """Writes maps, and what the program exports and renders. Returns a function that finds a file."""
    files = folder / "files"
    shutil.rmtree(files, ignore_errors=True)
    files.mkdir(parents=True)
    for format in CHANNELS:
        path = files / f"{format}.ptm"
        path.write_bytes(make_map(format))
        for suffix, options in (".exr", []), (".raw.npy", []), (".npy", ["--final"]), (".png", []):
            subprocess.run([program, "--quiet", "export", path, *options, "-o", f"{files}/{format}{suffix}"], check=True)
    for suffix in "png", "tiff", "bmp", "webp":
        subprocess.run([program, "--quiet", "render", files / "LRGB.ptm", "--light", "0.3,0.2", "-o", f"{files}/image.{suffix}"], check=True)
    make = f"""
import numpy, tifffile, subprocess
for format in {list(CHANNELS)!r}:
    values = numpy.load(format + ".npy")
    tifffile.imwrite(format + ".tif", values, photometric="minisblack", planarconfig="contig")
    tifffile.imwrite(format + ".planar.tif", numpy.ascontiguousarray(numpy.moveaxis(values, 2, 0)), photometric="minisblack", planarconfig="separate")
    raw = numpy.load(format + ".raw.npy")
    numpy.save(format + ".stacked.npy", numpy.moveaxis(raw, 2, 0).reshape(-1, raw.shape[1], 1))
frame = subprocess.run([{str(program)!r}, "reference", "rgb:0.3,0.2", "LRGB.ptm"], stdout=subprocess.PIPE, check=True).stdout
numpy.save("image.npy", numpy.frombuffer(frame[frame.index(b"\\n") + 1:], "u1").reshape(29, 37, 3))
"""
    subprocess.run([python, "-c", make], cwd=files, check=True)
    return files


# The verdicts


def describe_names(found):
    """Joins names; a0 a1 a2 a3 a4 a5 becomes a0…a5."""
    parts, at = [], 0
    while at < len(found):
        end = at
        while found[at].endswith("a0") and end + 1 < len(found) and found[end + 1] == found[at][:-1] + str(end + 1 - at):
            end += 1
        parts += [f"{found[at]}…{found[end]}"] if end > at + 1 else found[at:end + 1]
        at = end + 1
    return " ".join(parts)


def verdict(answer, names):
    if "missing" in answer:
        return "not installed"
    if "error" in answer:
        text = re.sub(r"^(\w+Error|Error): |\[Errno \d+\] | b?[`']FILE[`'].*|: header=.*|: '.*|/\S+/", "", answer["error"]).replace("|", "/").strip()
        return text if text.startswith("returns") else "error: " + text
    if "shape" in answer:
        return "**wrong**: " + answer["shape"]
    planes = answer["planes"]
    constant = [plane for plane in planes if plane.startswith("all ")]
    found = [plane.split(", ")[0] for plane in planes if plane.split(", ")[0] in names]
    lost = [name for name in names if name not in found]
    if not found:
        return f"**{len(planes)} planes, {constant[0]}**" if len(constant) == len(planes) else f"**wrong values in {len(planes)} planes, without an error**"
    order = list(dict.fromkeys(found))
    parts = ["equal" if len(names) == 1 else f"all {len(names)}" if not lost else f"{len(order)} of {len(names)}"]
    if order != names:
        parts.append("order " + describe_names(order))
    if len(order) < len(found):
        parts.append(f"{len(found)} equal channels" if len(order) == 1 else "some twice")
    parts += sorted({part for plane in planes for part in plane.split(", ")[1:]})
    parts += [f"and a plane of {plane[4:]}" for plane in constant]
    parts += ["wrong values in the others"] if "other values" in planes else []
    return ", ".join(parts) + (f"; **{describe_names(lost)} lost without an error**" if lost else "")


class Machine:
    """The environments with the libraries."""

    def __init__(self, folder, lock, installed):
        self.folder, self.lock, self.installed = folder, lock, installed

    def python(self, environment="pypi"):
        return self.folder / environment / "bin/python"

    def version(self, package, environment):
        return self.lock[environment][package]

    def read(self, reader, environment, path, expected, names):
        """Returns what read.py says about one file."""
        arguments = [reader, path]
        if environment == "npm":
            out = self.folder / "node.json"
            problem = run(["node", PARTS / "read.mjs", self.folder / "npm", reader, path, out])
            if problem:
                return {"error": problem}
            arguments, environment = ["node", out], "pypi"
        command = [self.python(environment), PARTS / "read.py", *arguments, expected, ",".join(names)]
        try:
            done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, timeout=SECONDS)
        except subprocess.TimeoutExpired:
            return {"error": f"no answer in {SECONDS} s"}
        return json.loads(done.stdout.splitlines()[-1]) if done.returncode == 0 else {"error": f"the process ended with status {done.returncode}"}

    def identify(self, program, environment, paths):
        signatures = ROOT / "docs/identify"
        variables = dict(os.environ)
        if program == "gio+PTM":
            variables["XDG_DATA_HOME"] = str(self.folder / "share")
            packages = self.folder / "share/mime/packages"
            packages.mkdir(parents=True, exist_ok=True)
            shutil.copy(signatures / "ptm-mime.xml", packages)
            if run(["update-mime-database", self.folder / "share/mime"]):
                return None
            program = "gio"
        if environment == "npm":
            command = ["node", PARTS / "identify.mjs", self.folder / "npm", program, *paths]
        else:
            command = [self.python(environment), PARTS / "identify.py", program, signatures, *paths]
        done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, timeout=900, env=variables)
        if done.returncode:
            say(f"{program}: skipped: {(done.stderr.strip().splitlines() or ['?'])[-1]}")
            return None
        return json.loads(done.stdout.splitlines()[-1])


def measure_readers(machine, files, rows, columns):
    """Measures each library of `rows` for each (suffix, expected, names) of `columns`."""
    results = []
    for library, reader, package, environment in rows:
        if package not in machine.installed[environment]:
            say(f"{library}: skipped, because it is not installed")
            continue
        cells = [verdict(machine.read(reader, environment, files / name, files / expected, names), names) for name, expected, names in columns]
        results.append({"library": library, "version": machine.version(package, environment), "cells": cells})
        say(f"{library}: {cells}")
    return results


def program_version(program):
    command = {"file": ["file", "--version"], "gio": ["dpkg-query", "-W", "-f", "${Version}", "shared-mime-info"]}[program]
    text = subprocess.run(command, stdout=subprocess.PIPE, text=True).stdout
    return re.search(r"\d+\.\d+", text)[0]


def measure_identifiers(machine, program, folder):
    """Identifies a map in each format, and an LRGB map with a space after the version."""
    corpus = folder / "identify"
    shutil.rmtree(corpus, ignore_errors=True)
    corpus.mkdir()
    paths = []
    for format in FORMATS:
        paths.append(corpus / f"{format}.ptm")
        plain = make_map(format if format in CHANNELS else "RGB" if format.endswith("RGB") and not format.endswith("LRGB") else "LRGB")
        paths[-1].write_bytes(plain)
        if format not in CHANNELS:
            source = corpus / "plain.ptm"
            source.write_bytes(plain)
            subprocess.run([program, "--quiet", "convert", source, "--to", format, *(["--quality", "75"] if "JPEG_" in format else []), "-o", paths[-1]], check=True)
    paths.append(corpus / "space.ptm")
    paths[-1].write_bytes(make_map("LRGB").replace(b"PTM_1.2\n", b"PTM_1.2 \n", 1))
    results = []
    for name, identifier, package, environment, setting in IDENTIFIERS:
        command = identifier.split("+")[0]
        if package and package not in machine.installed[environment] or package is None and not shutil.which(command):
            say(f"{name}: skipped, because it is not installed")
            continue
        found = machine.identify(identifier, environment, paths)
        if found is None:
            continue
        version = machine.version(package, environment) if package else program_version(command)
        results.append({"program": name, "version": version, "found": found, "set": setting})
        say(f"{name}: {found}")
    return results


def run_snippets(machine, files, document):
    """Runs the snippets of the document. Each one must assign the coefficient a5 of an LRGB map to `a5`."""
    text = document.read_text() if document.exists() else ""
    folder = files / "snippets"
    folder.mkdir()
    for suffix in "exr", "npy", "tif":
        shutil.copy(files / f"LRGB.{suffix}", folder / f"coin.{suffix}")
    results = {}
    for name, block in re.findall(r"<!-- snippet: (\S+) -->\n\n((?:    .*\n|\n)+)", text):
        code = "\n".join(line[4:] for line in block.splitlines())
        check = f"\nimport numpy\nassert numpy.array_equal(a5, numpy.load({str(files / 'LRGB.npy')!r})[..., 5])"
        problem = run([machine.python(), "-c", code + check], cwd=folder)
        results[name] = "right" if problem is None else f"wrong: {problem}"
        say(f"snippet {name}: {results[name]}")
    return results


# The tables


def group(found):
    """Describes what a program says about the nine formats: one answer, or each answer with its formats."""
    answers = {}
    for format, answer in zip(FORMATS, found):
        generic = re.sub(r"(?<=, )[A-Z_]+$", "…", answer)        # the name of the format in ptm.magic
        answers.setdefault(generic, []).append(format)
    if len(answers) == 1:
        return next(iter(answers))
    return "; ".join(f"{answer} ({', '.join(formats)})" for answer, formats in answers.items())


def markdown(results, recorded, date):
    lines = []
    titles = {
        "exr": ("### OpenEXR from `export`", ["LRGB", "RGB", "LUM"]),
        "npy": ("### NPY from `export`", ["LRGB, stored bytes", "RGB, stored bytes", "LRGB, `--final`", "RGB, `--final`"]),
        "tiff": ("### Float TIFF, written by tifffile from NPY", ["LRGB, contiguous", "RGB, contiguous", "LRGB, planar", "RGB, planar"]),
        "images": ("### Images from `render`, and stacked planes from `export`", ["PNG", "TIFF", "BMP", "WebP", "stacked PNG of LRGB"]),
    }
    for key, (title, columns) in titles.items():
        rows = [[row["library"], f"{row['version']}, {date}", *row["cells"]] for row in results[key]]
        lines += [title, "", *table(["library", "version, date", *columns], rows + recorded[key])]
    rows = [[row["program"], f"{row['version']}, {date}", group(row["found"]), re.sub(r"(?<=, )[A-Z_]+$", "…", row["found"][-1]), row["set"] or "–"]
            for row in results["identify"]]
    lines += ["### Identification of PTM files", "",
              *table(["program", "version, date", "the nine formats", "LRGB with a space after `PTM_1.2`", "how to configure it"], rows + recorded["identify"])]
    return "\n".join(lines)


def main():
    parser = measuring.option_parser(__doc__)
    parser.add_argument("--folder", type=pathlib.Path, help="install the packages here and keep them")
    options = measuring.parse(parser)
    with measuring.package_folder(options.folder, "exports") as folder:
        measure_all(options, folder)


def measure_all(options, folder):
    program = options.program
    lock = measuring.read_lock(HERE / "exports.lock")
    machine = Machine(folder, lock, install(folder, lock))
    files = make_files(program, folder, machine.python())
    rgb, lrgb = CHANNELS["RGB"], CHANNELS["LRGB"]
    image = ["R", "G", "B"]
    results = {
        "exr": measure_readers(machine, files, EXR, [(f"{format}.exr", f"{format}.npy", names) for format, names in CHANNELS.items()]),
        "npy": measure_readers(machine, files, NPY, [("LRGB.raw.npy", "LRGB.raw.npy", lrgb), ("RGB.raw.npy", "RGB.raw.npy", rgb),
                                                     ("LRGB.npy", "LRGB.npy", lrgb), ("RGB.npy", "RGB.npy", rgb)]),
        "tiff": measure_readers(machine, files, TIFF, [("LRGB.tif", "LRGB.npy", lrgb), ("RGB.tif", "RGB.npy", rgb),
                                                       ("LRGB.planar.tif", "LRGB.npy", lrgb), ("RGB.planar.tif", "RGB.npy", rgb)]),
        "images": measure_readers(machine, files, IMAGES, [*[(f"image.{suffix}", "image.npy", image) for suffix in ("png", "tiff", "bmp", "webp")],
                                                           ("LRGB.png", "LRGB.stacked.npy", ["planes"])]),
        "identify": measure_identifiers(machine, program, folder),
        "snippets": run_snippets(machine, files, options.docs or ROOT / "docs/exports.md"),
    }
    recorded = json.loads((PARTS / "recorded.json").read_text())
    measuring.write_results(options, "scripts/exports.py", results, markdown(results, recorded, datetime.date.today().isoformat()))
    if any(result != "right" for result in results["snippets"].values()):
        sys.exit("a snippet of the document is wrong")


if __name__ == "__main__":
    main()
