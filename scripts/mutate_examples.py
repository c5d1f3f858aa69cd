#!/usr/bin/env python3
"""Measures the diagnosis with mutants of the example decoders, whose mistakes are unrelated to PTM.

    python3 scripts/mutate_examples.py PROGRAM OUT.yaml --seed HEX [--count c=40,py=30,js=30]

PROGRAM is ptm-conform. Each mutant is an example decoder with one edit by a common operator of mutation testing: a constant
off by one, a different comparison or operator, a missing negation, exchanged arguments, a removed statement, a different type
or width, an early return, or a loop that is one iteration short. OUT contains the edit and the output of `check` for the
first suitable mutants, in an order that depends on the seed. A suitable mutant runs, changes the image of a legal file, passes
first contact and takes less than 100 seconds. The mutants depend only on the seed. Needs Python 3.9 or later, cc and node.
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

# Regular expressions for a token. Comments and strings come first, so that nothing inside them counts as code.
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
    """Yields the position and the text of every token, except comments, strings and directives."""
    skipped = re.compile(TOKEN[language], re.S | re.M)
    for match in re.finditer("(?:%s)%s" % (TOKEN[language], REST), text, re.S | re.M):
        if not skipped.fullmatch(match.group()):
            yield match.start(), match.group()


def mutants(language, text):
    """Returns all edits: (operator, start, end, replacement)."""
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
    # Removed statements, short loops, and early returns.
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


def compile_mutant(language, text, folder):
    """Returns the command that runs this source, or None if it does not compile."""
    source = os.path.join(folder, "decoder." + language)
    with open(source, "w", encoding="utf-8") as out:
        out.write(text)
    if language == "c":
        program = os.path.join(folder, "decoder")
        built = subprocess.run(["cc", "-std=c99", "-O1", "-w", "-o", program, source, "-lm"], capture_output=True)
        return [program] if built.returncode == 0 else None
    return [{"js": "node", "py": sys.executable}[language], source]


def check(program, command, folder):
    """Returns the exit status of a check, whether an image of a legal file is wrong, and what the program printed."""
    report = os.path.join(folder, "report.yaml")
    served = ["--serve"] if len(command) > 1 else []
    run = subprocess.run([program, "check", "--jobs", "1", "--timeout", "3", "--report", report, *served, "--", *command],
                         capture_output=True, cwd=folder, timeout=100, encoding="utf-8", errors="replace")
    with open(report, encoding="utf-8") as file:
        text = file.read()
    return run.returncode, "samples differ" in text, run.stdout


def try_one(job):
    program, language, text, (operator, start, end, new) = job
    mutant = text[:start] + new + text[end:]
    line = text.count("\n", 0, start) + 1
    row = {"language": language, "line": line, "operator": operator,
           "was": text.splitlines()[line - 1].strip(), "is": mutant.splitlines()[line - 1].strip()}
    with tempfile.TemporaryDirectory() as folder:
        command = compile_mutant(language, mutant, folder)
        if command is None:
            return None
        try:
            status, changes, printed = check(program, command, folder)
        except subprocess.TimeoutExpired:
            return None
        return dict(row, printed=printed) if status == 1 and changes else None


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("program")
    arguments.add_argument("out")
    arguments.add_argument("--seed", required=True, help="the first eight hexadecimal digits of the commit under test")
    arguments.add_argument("--count", default="c=40,py=30,js=30", help="number of mutants of each language (default: %(default)s)")
    given = arguments.parse_args()
    program = os.path.abspath(given.program)
    with open(given.out, "w", encoding="utf-8") as out:
        for part in given.count.split(","):
            language, count = part.split("=")
            with open(os.path.join(EXAMPLES, SOURCES[language]), encoding="utf-8") as file:
                text = file.read()
            jobs = [(program, language, text, edit) for edit in mutants(language, text)]
            random.Random(int(given.seed, 16)).shuffle(jobs)
            tried, kept = 0, 0
            with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
                for row in pool.map(try_one, jobs[:8 * int(count)]):
                    tried += 1
                    if row and kept < int(count):
                        kept += 1
                        out.write("- " + json.dumps(row, ensure_ascii=False) + "\n")
                        out.flush()
                    if kept == int(count):
                        pool.shutdown(cancel_futures=True)
                        break
            print("%s: %d mutants kept of %d tried" % (language, kept, tried), file=sys.stderr)


if __name__ == "__main__":
    main()
