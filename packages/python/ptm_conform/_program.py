"""The program in the package, and its functions for single files."""

import json
import os
import shutil
import subprocess
import sysconfig
import tempfile


class Malformed(ValueError):
    """The file breaks a rule of the format. The message names the section and the byte."""


class Unsupported(NotImplementedError):
    """The file may be valid, but the decoder does not support it."""


def program():
    """Returns the path of `ptm-conform`: PTM_CONFORM_PROGRAM, else the installed program, else the one in PATH."""
    named = os.environ.get("PTM_CONFORM_PROGRAM")
    if named:
        return named
    name = "ptm-conform" + (sysconfig.get_config_var("EXE") or "")
    schemes = [sysconfig.get_default_scheme(), sysconfig.get_preferred_scheme("user")]
    for scheme in schemes:
        path = os.path.join(sysconfig.get_path("scripts", scheme), name)
        if os.path.isfile(path):
            return path
    found = shutil.which(name)
    if found is None:
        raise FileNotFoundError("the program ptm-conform is not installed")
    return found


def decode(file, view="raw"):
    """Decodes `file` (bytes, or a path) with the reference. Returns an array of shape (height, width, channels), top row first.

    `raw`: the stored values as uint8. `coef`: the final coefficients as float32. `rgb:LU,LV`: the image under this light
    as uint8. Raises Malformed or Unsupported.
    """
    import numpy

    if isinstance(file, (str, os.PathLike)):
        with open(file, "rb") as opened:
            file = opened.read()
    with tempfile.TemporaryDirectory() as directory:
        path = os.path.join(directory, "x.ptm")
        with open(path, "wb") as out:
            out.write(file)
        run = subprocess.run([program(), "reference", view, path], capture_output=True)
    if run.returncode != 0:
        says = run.stderr.decode(errors="replace").strip().replace(path + ": ", "")
        raise {65: Malformed, 69: Unsupported}.get(run.returncode, ValueError)(says)
    line, samples = run.stdout.split(b"\n", 1)
    _, _, width, height, channels, kind = line.split(b" ")
    dtype = {b"u8": "u1", b"f32": "<f4"}[kind]
    return numpy.frombuffer(samples, dtype).reshape(int(height), int(width), int(channels)).copy()


def inspect(path):
    """Returns every field of a file as dictionaries, like `ptm-conform inspect --json` (spec-cases/schema/inspect.schema.json)."""
    run = subprocess.run([program(), "inspect", "--json", path], capture_output=True)
    if run.returncode == 2:
        raise OSError(run.stderr.decode(errors="replace").strip())
    return json.loads(run.stdout)


def lint(path):
    """Returns the findings for a file, as dictionaries with code, severity, offset, clause, says, found and fix."""
    (row,) = lint_rows([path])
    if row["status"] == "unreadable":
        raise OSError(row["reason"])
    return row["findings"]


def lint_rows(paths, options=()):
    """Checks many files with one process. Returns a dictionary per file, in order, like `ptm-conform lint --format jsonl`.

    A row has the keys file, status (sound, damaged, foreign, not-judged or unreadable), errors, warnings, infos and findings, and,
    if they are known, format, width, height, bytes, sha256, modified and others (spec-cases/schema/lint.schema.json). `options` are
    further options of the command. Raises ValueError if they are wrong.
    """
    names = b"".join(os.fsencode(path) + b"\0" for path in paths)
    command = [program(), "lint", "--quiet", "--format", "jsonl", *options, "-0", "-"]
    run = subprocess.run(command, input=names, capture_output=True)
    if run.returncode == 2:
        raise ValueError(run.stderr.decode(errors="replace").strip())
    return [json.loads(line) for line in run.stdout.splitlines()]
