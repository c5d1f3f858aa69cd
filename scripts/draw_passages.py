#!/usr/bin/env python3
"""Draws random passages for a review of the English: scripts/draw_passages.py COMMIT [EARLIER...]

Prints 40 passages of documents, 40 messages, and 40 doc comments with names, seeded with COMMIT. Omits the passages in the files
EARLIER, which are earlier outputs. A heading before each kind states the number of passages.
"""
import pathlib
import random
import re
import sys

COUNT = 40
root = pathlib.Path(__file__).parent.parent


def read_text(path):
    return path.read_text(encoding="utf-8")


def files(*patterns):
    return sorted(path for pattern in patterns for path in root.glob(pattern))


def paragraphs():
    """Yields the paragraphs and list items of documents, without code and tables."""
    for path in files("*.md", "docs/*.md", "spec-cases/*.md", "packages/*/README.md", "reports/*.md"):
        text = re.sub(r"```.*?```", "", read_text(path), flags=re.S)
        for block in re.split(r"\n\s*\n|\n(?=- |\d\. )", text):
            if not block.startswith(("    ", "|", "#", "[!", "<")) and len(block.split()) >= 6:
                yield f"{path.relative_to(root)}: {' '.join(block.split())}"
    for path in files("spec-cases/site/*.yaml", "spec-cases/annotated/*.yaml"):
        for value in re.findall(r"(?:intro|text|notes?|rule): >-\n((?: +(?! |- |(?:clauses|examples|formula|steps|table):).*\n)+)", read_text(path)):
            yield f"{path.relative_to(root)}: {' '.join(value.split())}"


def messages():
    """Yields the texts of misreadings, rulings, cases, probe and lint codes."""
    for path in files("spec-cases/*.yaml", "spec-cases/cases/*.yaml", "spec-cases/texture/**/*.yaml"):
        for key, value in re.findall(r"^ *-? ?(effect|fix|because|says|next|reason|decision): (.{20,})$", read_text(path), flags=re.M):
            yield f"{path.relative_to(root)}: {key}: {value}"


def comments():
    """Yields doc comments with the line of code after them."""
    for path in files("src/**/*.rs", "crates/**/*.rs", "spec-cases/*.rs", "tests/it/**/*.rs"):
        lines = read_text(path).splitlines()
        at = 0
        while at < len(lines):
            start = at
            while at < len(lines) and lines[at].lstrip().startswith(("///", "//!")):
                at += 1
            if at > start:
                code = next((line.strip() for line in lines[at:] if not line.lstrip().startswith("#[")), "")
                words = " ".join(line.strip().lstrip("/!").strip() for line in lines[start:at])
                yield f"{path.relative_to(root)}: {words} || {code}"
            at += 1


commit, *earlier = sys.argv[1:]
drawn = {line for path in earlier for line in pathlib.Path(path).read_text(encoding="utf-8").splitlines()}
generator = random.Random(commit)
for name, passages in [("documents", paragraphs), ("messages", messages), ("doc comments and names", comments)]:
    population = [passage for passage in dict.fromkeys(passages()) if passage not in drawn]
    count = min(COUNT, len(population))
    print(f"# {name}: {count} of {len(population)}")
    print(*generator.sample(population, count), sep="\n")
