"""Common parts of the scripts that measure software and print the tables of a document: options, locked packages, results."""

import argparse
import collections
import contextlib
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent


def say(text):
    print(text, file=sys.stderr, flush=True)


def option_parser(description):
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=ROOT / "target/debug/ptm-conform", type=pathlib.Path)
    parser.add_argument("--json", type=pathlib.Path, help="also write the results, to compare two runs")
    parser.add_argument("--docs", type=pathlib.Path, help="replace the tables in this document")
    return parser


def parse(parser):
    """Returns the options. Their program is an absolute path."""
    options = parser.parse_args()
    options.program = options.program.resolve()
    if not options.program.exists():
        raise SystemExit(f"{options.program} does not exist: run cargo build, or name the program with --program")
    return options


@contextlib.contextmanager
def package_folder(folder, name):
    """Yields the folder for packages: the given one, which is kept, or a temporary one."""
    chosen = (folder or pathlib.Path(tempfile.mkdtemp(prefix=name + "-"))).resolve()
    chosen.mkdir(parents=True, exist_ok=True)
    try:
        yield chosen
    finally:
        if not folder:
            shutil.rmtree(chosen, ignore_errors=True)


def read_lock(path):
    """Returns {registry: {package: version}}."""
    lock = collections.defaultdict(dict)
    for line in path.read_text().splitlines():
        if line and not line.startswith("#"):
            registry, package, version = line.split()
            lock[registry][package] = version
    return lock


def run(command, **options):
    """Returns None, or the last line of the error."""
    try:
        done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=900, **options)
    except (OSError, subprocess.TimeoutExpired) as problem:
        return str(problem)
    lines = done.stdout.strip().splitlines()
    return None if done.returncode == 0 else (lines[-1] if lines else f"exit status {done.returncode}")


def table(head, rows):
    """Returns the lines of a Markdown table, and an empty line."""
    return ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)] + ["| " + " | ".join(map(str, row)) + " |" for row in rows] + [""]


def write_results(options, script, results, tables):
    """Prints the tables, writes the results as JSON, and replaces the tables between the marks of `script` in the document."""
    if options.json:
        options.json.write_text(json.dumps(results, indent=1, ensure_ascii=False) + "\n")
    print(tables)
    if options.docs:
        text = options.docs.read_text()
        begin, end = f"<!-- begin: {script} -->\n", f"<!-- end: {script} -->"
        options.docs.write_text(text.split(begin)[0] + begin + "\n" + tables + "\n" + end + text.split(end)[1])
