#!/usr/bin/env python3
"""Writes findings/README.md from the heads of the scripts. --check only compares, and exits with 1 if the file is out of date."""

import pathlib
import re
import sys

HERE = pathlib.Path(__file__).resolve().parent
HEAD = """# Findings

Surprises about real software that a program for PTM files may meet, and that are no fault of this project. Each script installs pinned public
packages in a temporary folder, runs them on valid input, and exits with 0 if they behave as stated, 1 if not, and 77 if something
is missing. [CONTRIBUTING.md](../CONTRIBUTING.md#add-a-finding) describes the form. `findings/index.py` generates this file.

More surprises are in the tables of [docs/codecs.md](../docs/codecs.md) (libraries for planes), [docs/exports.md](../docs/exports.md) (readers of
exported files, and programs that identify files) and [docs/gpu.md](../docs/gpu.md) (renderers).
"""


def entry(path):
    fields = re.findall(r"^# (finding|software|expected|observed): (.*)$", path.read_text(), re.MULTILINE)
    values = {name: [text for key, text in fields if key == name] for name in ("finding", "software", "expected", "observed")}
    counts = [len(values[name]) for name in ("finding", "software", "expected")]
    if counts != [1, 1, 1] or not values["observed"]:
        raise SystemExit(f"{path.name}: expected one line each of finding, software and expected, and lines of observed")
    observed = "".join(f"    {line}\n" for line in values["observed"])
    return (f"\n## {values['finding'][0]}\n\n[{path.name}]({path.name}): {values['software'][0]}\n\n"
            f"Expected: {values['expected'][0]}\n\nObserved:\n\n{observed}")


def main(arguments):
    scripts = sorted(path for path in HERE.glob("*.sh") if path.name != "tools.sh")
    text = HEAD + "".join(map(entry, scripts))
    target = HERE / "README.md"
    if arguments == ["--check"]:
        sys.exit(0 if target.exists() and target.read_text() == text else "findings/README.md is out of date: run findings/index.py")
    target.write_text(text)


if __name__ == "__main__":
    main(sys.argv[1:])
