#!/usr/bin/env python3
"""Compares the verdicts of check_callable with those of the protocol, and measures its speed.

    measure.py [--copies N] [--options "--smoke"] [--no-speed]

The Python example and wrong copies of it are checked twice: as programs in serve mode, and as functions. All verdicts and causes
must be equal. The speed is measured with a function that returns precomputed answers. PTM_CONFORM_PROGRAM is the path of the
program. NumPy is required. The exit status is 1 if anything differs.
"""

import argparse
import importlib.util
import io
import json
import os
import resource
import subprocess
import sys
import tempfile
import time

HERE = os.path.dirname(os.path.abspath(__file__))
EXAMPLE = os.path.join(HERE, "..", "..", "examples", "decoders", "ptm_decoder.py")
sys.path.insert(0, HERE)

import numpy
import ptm_conform

# Copies with one mistake: the text to replace, and the replacement.
WRONG = [
    ('index, "little")', 'index, "big")'),
    ("reversed(range(height))", "range(height)"),
    ("len(entries) <= 256", "len(entries) < 256"),
    ("(raw - ptm.bias[i % 6]) * ptm.scale[i % 6]", "raw * ptm.scale[i % 6] - ptm.bias[i % 6]"),
    ("zip(red, green, blue)", "zip(blue, green, red)"),
    ("if max(indices) >= len(entries):", "if False:"),
    ("luminance * channel / 255", "luminance * channel / 256"),
    ("255 - value for value in predictor", "256 - value & 255 for value in predictor"),
    ("// 4 for l, r", "// 4 + 1 & 255 for l, r"),
    ('record[:4], "big"', 'record[:4], "little"'),
]


def load_module(path):
    spec = importlib.util.spec_from_file_location("decoder", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def frame_to_array(frame):
    line, samples = frame.split(b"\n", 1)
    _, _, width, height, channels, kind = line.split()
    return numpy.frombuffer(samples, {b"u8": "u1", b"f32": "<f4"}[kind]).reshape(int(height), int(width), int(channels))


def decoder_functions(path):
    """Returns the views of a decoder as functions of the bytes of a file."""
    module = load_module(path)

    def frame(view, file):
        module.open = lambda path, mode: io.BytesIO(file)
        return frame_to_array(module.frame(view.encode(), b""))

    return {
        "raw": lambda file: frame("raw", file),
        "coef": lambda file: frame("coef", file),
        "rgb": lambda file, lu, lv: frame("rgb:%s,%s" % (lu, lv), file),
        "malformed": module.Malformed,
        "unsupported": module.Unsupported,
    }


def check_by_protocol(path, options):
    with tempfile.TemporaryDirectory() as directory:
        report = os.path.join(directory, "report.json")
        command = [ptm_conform.program(), "check", "--serve", "--report", os.path.join(directory, "report.yaml"), "--json", report, *options]
        subprocess.run([*command, "--", sys.executable, path], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        with open(report, "rb") as file:
            return json.load(file)


def verdicts(report):
    outcomes = {case["id"]: case["outcome"] for case in report["cases"]}
    causes = [(cause.get("misreading"), cause["explains"]) for cause in report["diagnoses"]]
    return outcomes, causes, report["scores"]["correctness"], report["dialect"]


def compare(copies, options):
    """Returns True if both ways give equal verdicts on the example and on the given number of wrong copies."""
    with open(EXAMPLE, encoding="utf-8") as file:
        source = file.read()
    equal = True
    for edit in [("", ""), *WRONG[:copies]]:
        assert edit[0] in source, edit
        with tempfile.TemporaryDirectory() as directory:
            path = os.path.join(directory, "decoder.py")
            with open(path, "w", encoding="utf-8") as out:
                out.write(source.replace(*edit, 1))
            called = ptm_conform.check_callable(**decoder_functions(path), options=options)
            same = verdicts(called.data) == verdicts(check_by_protocol(path, options))
        failed = sum(case["outcome"] == "fail" for case in called.data["cases"])
        print("%s: %d failures, %s  %s" % ("equal" if same else "DIFFERENT", failed, ", ".join(called.causes) or "no cause", edit[1] or "the example"), flush=True)
        equal = equal and same
    return equal


def speed():
    """Prints the cases per second of check_callable for a function that only looks up its answer."""
    answers = {}
    path = os.path.join(tempfile.mkdtemp(), "x.ptm")
    reference = subprocess.Popen([ptm_conform.program(), "reference", "serve"], stdin=subprocess.PIPE, stdout=subprocess.PIPE)

    def decode(file):
        if file not in answers:
            with open(path, "wb") as out:
                out.write(file)
            reference.stdin.write(b"1 raw %s\n" % path.encode())
            reference.stdin.flush()
            _, word, *rest = reference.stdout.readline().split(b" ")
            answers[file] = frame_to_array(reference.stdout.read(int(rest[0]))) if word == b"ok" else {b"reject": ptm_conform.Malformed, b"unsupported": ptm_conform.Unsupported}[word]
        answer = answers[file]
        if isinstance(answer, type):
            raise answer("expected")
        return answer

    def processor_time():
        used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
        return sum(one.ru_utime + one.ru_stime for one in used)

    ptm_conform.check_callable(decode)
    began, used = time.perf_counter(), processor_time()
    report = ptm_conform.check_callable(decode)
    seconds, used = time.perf_counter() - began, processor_time() - used
    reference.stdin.close()
    cases = len(report.data["cases"])
    # Unlike wall-clock time, processor time hardly depends on other load of the machine.
    print("%d cases: %.2f s, %.0f per second; %.2f s of processor time, %.0f per second; %s" % (cases, seconds, cases / seconds, used, cases / used, report.data["verdict"]))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--copies", type=int, default=len(WRONG))
    parser.add_argument("--options", default="")
    parser.add_argument("--no-speed", action="store_true")
    arguments = parser.parse_args()
    equal = compare(arguments.copies, arguments.options.split())
    if not arguments.no_speed:
        speed()
    sys.exit(0 if equal else 1)
