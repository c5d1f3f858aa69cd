"""Says what a program takes files for: identify.py PROGRAM SIGNATURES FILE... prints a JSON list with one string per file.

SIGNATURES is the folder docs/identify. Programs whose name ends in +PTM use its signatures.
"""

import json
import os
import pathlib
import subprocess
import sys

BESIDE_PYTHON = pathlib.Path(sys.executable).parent


def run(*command, **environment):
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, env={**os.environ, **environment})
    return done.stdout.strip()


def file(signatures, path, more=()):
    return run("file", "--brief", *more, path)


def file_ptm(signatures, path):
    return file(signatures, path, ["-m", f"{signatures}/ptm.magic"])


def libmagic(signatures, path, magic_file=None):
    import pylibmagic  # noqa: F401 - makes its copy of libmagic known
    import magic
    return magic.Magic(magic_file=magic_file).from_file(path)


def libmagic_ptm(signatures, path):
    return libmagic(signatures, path, f"{signatures}/ptm.magic")


def fido(signatures, path, more=()):
    text = run(str(BESIDE_PYTHON / "fido"), "-q", *more, "-matchprintf", "%(info.puid)s by %(info.matchtype)s\n", "-nomatchprintf", "nothing\n", path)
    return " and ".join(sorted(set(text.split("\n"))))


def fido_ptm(signatures, path):
    return fido(signatures, path, ["-loadformats", f"{signatures}/ptm-fido.xml"])


def siegfried(signatures, path):
    import pygfried
    found = pygfried.identify(path)
    return found if isinstance(found, str) else str(found)


def puremagic(signatures, path):
    import puremagic
    found = puremagic.magic_file(path)
    return found[0].name if found else "nothing"


def filetype(signatures, path):
    import filetype
    found = filetype.guess(path)
    return found.mime if found else "nothing"


def magika(signatures, path):
    import magika
    global model
    if "model" not in globals():
        model = magika.Magika()
    return model.identify_path(pathlib.Path(path)).output.label


def pyav(signatures, path):
    import av
    try:
        with av.open(path) as film:
            frames = sum(1 for _ in film.decode(video=0))
            return f"film of {frames} frames, {film.streams.video[0].codec_context.name}"
    except Exception as problem:                        # errors of FFmpeg
        return f"error: {type(problem).__name__}"


def gio(signatures, path):
    return run("gio", "info", "-a", "standard::content-type", path, LC_ALL="C").split("content-type: ")[-1]


PROGRAMS = {"file": file, "file+PTM": file_ptm, "libmagic": libmagic, "libmagic+PTM": libmagic_ptm, "fido": fido, "fido+PTM": fido_ptm, "siegfried": siegfried,
            "puremagic": puremagic, "filetype": filetype, "magika": magika, "pyav": pyav, "gio": gio}

if __name__ == "__main__":
    identify = PROGRAMS[sys.argv[1]]
    print(json.dumps([identify(sys.argv[2], path) for path in sys.argv[3:]]))
