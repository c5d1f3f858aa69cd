#!/usr/bin/env python3
"""Builds a wheel from a compiled program. Needs only the standard library.

    build_wheel.py PROGRAM OUT_DIRECTORY --platform TAG [--version X.Y.Z]

maturin would compile the program a second time. This script uses the file that the release workflow has built, stripped,
tested and attested, so the archive, the wheel and the container image contain the same program. TAG is the platform, such
as manylinux2014_x86_64.musllinux_1_1_x86_64 for a static program on Linux, macosx_11_0_arm64 or win_amd64. The same
program always gives the same wheel, byte for byte.
"""

import argparse
import base64
import hashlib
import json
import os
import re
import zipfile

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.join(HERE, "..", "..")
NAME = "ptm_conform"

METADATA = """\
Metadata-Version: 2.1
Name: ptm-conform
Version: {version}
Summary: Conformance suite and reference decoder for HP Labs' Polynomial Texture Map format (PTM 1.2)
License: MIT OR Apache-2.0
Project-URL: Source, https://github.com/ptm-conform/ptm-conform
Keywords: ptm,rti,conformance,texture,decoder
Classifier: Framework :: Pytest
Classifier: Topic :: Multimedia :: Graphics
Classifier: Topic :: Software Development :: Testing
Requires-Python: >=3.10
Requires-Dist: numpy
Description-Content-Type: text/markdown

"""

WHEEL = """\
Wheel-Version: 1.0
Generator: build_wheel.py
Root-Is-Purelib: false
"""

ENTRY_POINTS = """\
[pytest11]
ptm_conform = ptm_conform.pytest_plugin
"""


def read(*path):
    with open(os.path.join(*path), "rb") as file:
        return file.read()


def crate_version():
    return re.search(r'(?m)^version = "(.*)"', read(ROOT, "Cargo.toml").decode()).group(1)


def files(program, version, tags):
    """Returns the files of the wheel by name, except RECORD."""
    info = "%s-%s.dist-info" % (NAME, version)
    package = os.path.join(HERE, NAME)
    found = {"%s/%s" % (NAME, name): read(package, name) for name in sorted(os.listdir(package)) if name.endswith(".py")}
    init = NAME + "/__init__.py"
    found[init] = found[init].replace(b"@VERSION@", version.encode())
    ids = re.findall(r"(?m)^- id: (\S+)$", read(ROOT, "corpus", "MANIFEST.yaml").decode())
    found[NAME + "/cases.json"] = json.dumps(ids).encode()
    suffix = ".exe" if program.endswith(".exe") else ""
    found["%s-%s.data/scripts/ptm-conform%s" % (NAME, version, suffix)] = read(program)
    found[info + "/METADATA"] = METADATA.format(version=version).encode() + read(HERE, "README.md")
    found[info + "/WHEEL"] = (WHEEL + "".join("Tag: py3-none-%s\n" % tag for tag in tags)).encode()
    found[info + "/entry_points.txt"] = ENTRY_POINTS.encode()
    for license in ("LICENSE-APACHE", "LICENSE-MIT"):
        found["%s/%s" % (info, license)] = read(ROOT, license)
    return info, found


def build(program, directory, platform, version):
    """Writes the wheel and returns its path."""
    info, found = files(program, version, platform.split("."))
    record = ""
    for name, data in found.items():
        digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
        record += "%s,sha256=%s,%d\n" % (name, digest, len(data))
    found[info + "/RECORD"] = (record + info + "/RECORD,,\n").encode()
    os.makedirs(directory, exist_ok=True)
    path = os.path.join(directory, "%s-%s-py3-none-%s.whl" % (NAME, version, platform))
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as wheel:
        for name, data in found.items():
            entry = zipfile.ZipInfo(name, (2001, 11, 1, 0, 0, 0))
            entry.external_attr = (0o100755 if "/scripts/" in name else 0o100644) << 16
            entry.compress_type = zipfile.ZIP_DEFLATED
            wheel.writestr(entry, data)
    return path


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("directory")
    parser.add_argument("--platform", required=True)
    parser.add_argument("--version", default=crate_version())
    arguments = parser.parse_args()
    print(build(arguments.program, arguments.directory, arguments.platform, arguments.version))
