#!/usr/bin/env python3
"""Measures the suite by mistakes that know nothing of PTM: mutants of the example decoders.

    python3 scripts/mutate_examples.py PROGRAM OUT.yaml [--language c|js|py] [--count N] [--seed S] [--jobs N]

PROGRAM is ptm-conform. Each mutant is an example decoder with one edit by an operator of the kind that mutation testing
uses for any program: a constant off by one, another comparison or operator, a negation lost, exchanged arguments, a
statement dropped, another type or width, an early return, a loop one short. A mutant that
does not compile is set aside; the others are checked with the whole suite. OUT lists each: its edit, the exit status, how
many cases failed and the causes that the report names; and of those that pass, whether 1,500 drawn files tell them from a
right decoder (missed). The same seed makes the same mutants. Python 3.9 or later, cc for C, node for JavaScript.
"""

import argparse
import concurrent.futures
import json
import os
import random
import re
import subprocess
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
EXAMPLES = os.path.join(HERE, "..", "examples", "decoders")
SOURCES = {"c": "ptm_decoder.c", "js": "ptm_decoder.js", "py": "ptm_decoder.py"}

# One token: comments and strings first, so that nothing inside them is taken for code.
TOKEN = {
    "c": r'/\*.*?\*/|//[^\n]*|"(?:\\.|[^"\\])*"|\'(?:\\.|[^\'\\])*\'|^[ \t]*#[^\n]*',
    "js": r'//[^\n]*|"(?:\\.|[^"\\])*"|`(?:\\.|[^`\\])*`|/\^(?:\\.|[^/\\\n])*/|^#![^\n]*',
    "py": r'"""(?:.|\n)*?"""|#[^\n]*|[rbf]*"(?:\\.|[^"\\\n])*"|[rbf]*\'(?:\\.|[^\'\\\n])*\'',
}
REST = r'|\d+\.\d*(?:[eE][+-]?\d+)?|0[xX][0-9a-fA-F]+|\d+n?|[A-Za-z_]\w*|[<>=!]==?|<<=?|>>>?=?|&&|\|\||\+\+|--|[-+*/%&|^]=|=>|->|\*\*|//|\S'

EXCHANGED = {
    "<": ["<="], "<=": ["<"], ">": [">="], ">=": [">"], "==": ["!="], "!=": ["=="], "===": ["!=="], "!==": ["==="],
    "+": ["-"], "-": ["+"], "*": ["+"], "/": ["*"], "//": ["/"], "%": ["/"], "<<": [">>"], ">>": ["<<"], "&": ["|"], "|": ["&"], "^": ["&"],
    "&&": ["||"], "||": ["&&"], "and": ["or"], "or": ["and"], "not": [""], "!": [""],
    "++": ["--"], "+=": ["-=", "="], "-=": ["+="], "*=": ["+="], "|=": ["&="],
    "break": ["continue"], "continue": ["break"], "True": ["False"], "False": ["True"], "true": ["false"], "false": ["true"],
    "double": ["float", "int"], "size_t": ["unsigned short", "int"], "float": ["int"], "unsigned": ["signed"], "long": ["short"],
    "readUInt8": ["readInt8"], "readUInt16LE": ["readUInt16BE", "readInt16LE"], "little": ["big"], "big": ["little"],
    "floor": ["ceil", "round"], "round": ["floor"], "ceil": ["floor"], "min": ["max"], "max": ["min"], "reversed": ["list"],
}


def tokens(language, text):
    """Every token of code with its place; comments, strings and directives are left out."""
    skipped = re.compile(TOKEN[language], re.S | re.M)
    for match in re.finditer("(?:%s)%s" % (TOKEN[language], REST), text, re.S | re.M):
        if not skipped.fullmatch(match.group()):
            yield match.start(), match.group()


def mutants(language, text):
    """All edits: (operator, start, end, replacement)."""
    found = []
    for at, word in tokens(language, text):
        end = at + len(word)
        if re.fullmatch(r"\d+", word):
            found += [("constant", at, end, str(int(word) + 1)), ("constant", at, end, str(int(word) - 1))]
        elif re.fullmatch(r"0[xX][0-9a-fA-F]+", word):
            found.append(("constant", at, end, hex(int(word, 16) + 1)))
        elif re.fullmatch(r"\d+\.\d*", word):
            found.append(("constant", at, end, str(float(word) + 1)))
        found += [("operator", at, end, other) for other in EXCHANGED.get(word, [])]
    # Exchanged arguments: a call of two or three plain arguments.
    for match in re.finditer(r"\b\w+\(([\w.\[\]]+), ([\w.\[\]]+)(, [\w.\[\]]+)?\)", text):
        a, b = match.group(1), match.group(2)
        if a != b:
            start = match.start(1)
            found.append(("arguments", start, match.end(2), "%s, %s" % (b, a)))
    # A statement dropped, an early return.
    line_start = 0
    for line in text.splitlines(True):
        body = line.strip()
        start = line_start + len(line) - len(line.lstrip())
        end = line_start + len(line.rstrip())
        if language == "py":
            if re.fullmatch(r"[\w.\[\], ]+ [-+*/|&]?= .*[^,(\[{\\]|raise .*|[\w.]+\(.*\)", body):
                found.append(("dropped", start, end, "pass"))
            if re.match(r"for \w+ in range\([^()]*\):", body):
                found.append(("short loop", start, end, re.sub(r"range\(([^()]*)\):", r"range(\1 - 1):", body)))
        else:
            if body.endswith(";") and not re.match(r"(const|let|var|return|static|int|size_t|char|double|unsigned|enum|typedef|struct|[a-zA-Z_]+ \*?\w+\()", body):
                found.append(("dropped", start, end, ";"))
            loop = re.search(r"(for \([^;]*; \w+ <) ([\w.>\-]+);", line)
            if loop:
                found.append(("short loop", line_start + loop.start(), line_start + loop.end(), loop.group(1) + " " + loop.group(2) + " - 1;"))
            if re.match(r"return [^;]+;", body) and language == "c":
                found.append(("early return", start, end, "return 0;"))
        line_start += len(line)
    return found


def runnable(language, text, folder):
    """The command that runs this source, or None if it does not compile."""
    source = os.path.join(folder, "decoder." + language)
    with open(source, "w", encoding="utf-8") as out:
        out.write(text)
    if language == "c":
        program = os.path.join(folder, "decoder")
        built = subprocess.run(["cc", "-std=c99", "-O1", "-w", "-o", program, source, "-lm"], capture_output=True)
        return [program] if built.returncode == 0 else None
    return [{"js": "node", "py": sys.executable}[language], source]


def check(program, command, folder):
    """The exit status of a check, how many cases failed, and the part of the report that names causes."""
    report = os.path.join(folder, "report.yaml")
    served = ["--serve"] if command[0] == sys.executable else []
    run = subprocess.run([program, "check", "--jobs", "1", "--timeout", "3", "--report", report, *served, "--", *command],
                         capture_output=True, cwd=folder, timeout=1800)
    with open(report, encoding="utf-8") as file:
        text = file.read()
    causes = re.search(r"(?ms)^diagnoses:(.*?)^cases:", text)
    return run.returncode, len(re.findall(r"(?m)^  outcome: fail$", text)), brief(causes.group(1)) if causes else ""


def brief(causes):
    """The causes without the lists of cases that each explains."""
    lines = [line for line in causes.strip().splitlines() if not line.startswith("  - ")]
    return "\n".join(lines)[:3000]


def differs(program, command, folder):
    """Whether files that are not of the suite show a difference."""
    run = subprocess.run([program, "fuzz", "--jobs", "1", "--executions", "1500", "--seed", "7", "--out", os.path.join(folder, "finds"),
                          "--", *command], capture_output=True, cwd=folder, timeout=1800)
    return run.returncode != 0


def try_one(job):
    program, language, text, (operator, start, end, new) = job
    mutant = text[:start] + new + text[end:]
    line = text.count("\n", 0, start) + 1
    row = {"language": language, "line": line, "operator": operator,
           "was": text.splitlines()[line - 1].strip(), "is": mutant.splitlines()[line - 1].strip()}
    with tempfile.TemporaryDirectory() as folder:
        command = runnable(language, mutant, folder)
        if command is None:
            return None
        try:
            status, failed, causes = check(program, command, folder)
            if status == 0:
                return dict(row, status=0, missed=differs(program, command, folder))
        except subprocess.TimeoutExpired:
            return dict(row, status="timeout")
        return dict(row, status=status, failed=failed, causes=causes)


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("program")
    arguments.add_argument("out")
    arguments.add_argument("--language", action="append", choices=sorted(SOURCES))
    arguments.add_argument("--count", type=int, default=1000)
    arguments.add_argument("--seed", type=int, default=1)
    arguments.add_argument("--jobs", type=int, default=os.cpu_count())
    given = arguments.parse_args()
    program = os.path.abspath(given.program)
    jobs = []
    for language in given.language or sorted(SOURCES):
        with open(os.path.join(EXAMPLES, SOURCES[language]), encoding="utf-8") as file:
            text = file.read()
        jobs += [(program, language, text, edit) for edit in mutants(language, text)]
    random.Random(given.seed).shuffle(jobs)
    jobs = jobs[:given.count]
    rows, invalid = [], 0
    with concurrent.futures.ThreadPoolExecutor(given.jobs) as pool, open(given.out, "w", encoding="utf-8") as out:
        for done, row in enumerate(pool.map(try_one, jobs), 1):
            if row is None:
                invalid += 1
            else:
                rows.append(row)
                out.write("- " + json.dumps(row, ensure_ascii=False) + "\n")
                out.flush()
            print("\r%d of %d" % (done, len(jobs)), end="", file=sys.stderr)
    passed = [row for row in rows if row["status"] == 0]
    missed = sum(row["missed"] for row in passed)
    print("\n%d mutants, %d do not compile, %d caught, %d pass, of which drawn files show %d to be wrong"
          % (len(jobs), invalid, len(rows) - len(passed), len(passed), missed))


if __name__ == "__main__":
    main()
