#!/usr/bin/env python3
"""Measures how renderers evaluate a PTM and sample textures, and prints the tables of docs/gpu.md in Markdown.

    cargo build
    examples/gpu/measure.py [--program target/debug/ptm-conform] [--no-check] [--json FILE] [--docs docs/gpu.md]

Runs OpenGL through EGL on Mesa's llvmpipe and softpipe, and numpy. Needs numpy, moderngl, libEGL, libGL and Mesa; ends with status 77 if
one is missing. recorded.json contains the rows of an NVIDIA H200. --gpu measures the driver that EGL chooses by itself.
"""

import argparse
import datetime
import json
import math
import os
import pathlib
import re
import subprocess
import sys
import tempfile
from fractions import Fraction

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
sys.path[:0] = [str(HERE), str(HERE.parent / "decoders"), str(ROOT / "scripts")]
import measuring
from measuring import say, table
import units
import numpy
import ptm_decoder
import ptm_shader

RENDERERS = {
    "llvmpipe": {"LIBGL_ALWAYS_SOFTWARE": "1", "GALLIUM_DRIVER": "llvmpipe"},
    # softpipe declares OpenGL 3.3, but has compute shaders
    "softpipe": {"LIBGL_ALWAYS_SOFTWARE": "1", "GALLIUM_DRIVER": "softpipe", "MESA_GL_VERSION_OVERRIDE": "4.5", "MESA_GLSL_VERSION_OVERRIDE": "450"},
    "gpu": {},
}


# Colors of a PTM


def make_maps():
    """Returns {name: file} of six maps of 96×64 texels."""
    width, height = 96, 64
    random = numpy.random.default_rng(11)
    x, y = numpy.meshgrid(numpy.arange(width), numpy.arange(height))
    waves = [128 + 60 * numpy.sin(x / (7 + k)) * numpy.cos(y / (9 + 2 * k)) for k in range(6)]
    smooth = numpy.stack([wave.astype(numpy.uint8).ravel() for wave in waves], 1).tobytes()

    def noise(channels):
        return random.integers(0, 256, (width * height, channels), numpy.uint8).tobytes()

    def file(format, scale, bias, data):
        return f"PTM_1.2\nPTM_FORMAT_{format}\n{width}\n{height}\n{scale}\n{bias}\n".encode() + data

    usual = "2 2 2 2 2 1", "128 128 128 128 128 0"
    odd = "1.3671875 0.9140625 1.7382 0.6123 1.1111 1.2", "131 120 127 140 99 3"
    integers = "1 1 1 1 1 1", "128 128 128 128 128 0"
    return {
        "LRGB, smooth": file("LRGB", *usual, smooth + noise(3)),
        "LRGB, noise": file("LRGB", *odd, noise(6) + noise(3)),
        "RGB, smooth": file("RGB", *usual, smooth * 3),
        "RGB, noise": file("RGB", *odd, noise(18)),
        "LRGB, integers": file("LRGB", *integers, noise(6) + b"\xff" * (3 * width * height)),
        "RGB, integers": file("RGB", *integers, noise(18)),
    }


LIGHTS = ["0,0", "0.5,-0.5", "0.3,0.2", "-0.7071,0.7071", "0.1234,-0.5678", "1,0", "0.25,0.75"]


def to_bits(values, bits):
    """Rounds float32 numbers to a number of significant bits, ties to even."""
    if bits == 24:
        return numpy.asarray(values, numpy.float32)
    pattern = numpy.asarray(values, numpy.float32).view(numpy.uint32).astype(numpy.uint64)
    drop = 24 - bits
    rounded = pattern + (1 << (drop - 1)) - 1 + ((pattern >> drop) & 1)
    return (rounded >> drop << drop).astype(numpy.uint32).view(numpy.float32)


def matrix_product(input_bits, output_bits):
    """Evaluates the polynomial as (texels, 6) × (6): inputs and the result are rounded, products are added in float32."""
    def evaluate(a, u, v):
        basis = to_bits(numpy.array([u * u, v * v, u * v, u, v, 1], numpy.float32), input_bits)
        total = numpy.zeros(len(a), numpy.float32)
        for column, factor in zip(to_bits(a, input_bits).T, basis):
            total += column * factor
        return to_bits(total, output_bits)
    return evaluate


def in_type(kind):
    def evaluate(a, u, v):
        u, v = kind(u), kind(v)
        return a[:, 0] * u * u + a[:, 1] * v * v + a[:, 2] * u * v + a[:, 3] * u + a[:, 4] * v + a[:, 5]
    return evaluate


def values(ptm, stored, u, v, kind, evaluate):
    """Returns colors that are not clamped, for RGB and LRGB."""
    def polynomial(first):
        final = (stored[:, first:first + 6].astype(kind) - numpy.array(ptm.bias).astype(kind)) * numpy.array(ptm.scale).astype(kind)
        return evaluate(final, u, v).astype(kind)
    if stored.shape[1] == 18:
        return numpy.stack([polynomial(first) for first in (0, 6, 12)], 1)
    return polynomial(0)[:, None] * stored[:, 6:].astype(kind) / kind(255)


def in_numpy(kind, evaluate, truncate=False):
    def render(ptm, stored, light):
        with numpy.errstate(over="ignore"):             # float16 ends at 65,504
            colors = numpy.clip(values(ptm, stored, *light, kind, evaluate).astype(float), 0, 255)
        return numpy.floor(colors + (0 if truncate else 0.5))
    return render


def shader(*options):
    made = []

    def render(ptm, stored, light):
        if not made:
            made.append(ptm_shader.Renderer(*options))
        return made[0].colors(ptm, light).astype(float)
    return render


def evaluations(renderer):
    if renderer == "numpy":
        f2, f4 = numpy.float16, numpy.float32
        return {
            "float32, rounded": in_numpy(f4, in_type(f4)),
            "float16, rounded": in_numpy(f2, in_type(f2)),
            "float16, truncated": in_numpy(f2, in_type(f2), True),
            "matrix product in TF32, emulated": in_numpy(f4, matrix_product(11, 24)),
            "matrix product in float16, emulated": in_numpy(f4, matrix_product(11, 11)),
            "matrix product in bfloat16, emulated": in_numpy(f4, matrix_product(8, 8)),
        }
    return {
        "RGBA8 framebuffer": shader("rgba8"),
        "RGBA16F framebuffer, rounded": shader("rgba16f"),
        "RGBA32F framebuffer, rounded": shader("rgba32f"),
        "RGBA32F framebuffer, truncated": shader("rgba32f", True),
    }


def measure_colors(program, renderer):
    compared = {name: {"samples": 0, "reference": 0, "truncated": 0, "beyond": 0, "largest": 0.0} for name in evaluations(renderer)}
    renders = evaluations(renderer)
    with tempfile.TemporaryDirectory() as folder:
        for data in make_maps().values():
            path = pathlib.Path(folder) / "map.ptm"
            path.write_bytes(data)
            ptm = ptm_decoder.read_ptm(data)
            stored = numpy.frombuffer(b"".join(ptm.texels), numpy.uint8).reshape(len(ptm.texels), -1)
            for light in LIGHTS:
                frame = subprocess.run([program, "reference", "rgb:" + light, path], stdout=subprocess.PIPE, check=True).stdout
                reference = numpy.frombuffer(frame[frame.index(b"\n") + 1:], numpy.uint8).reshape(-1, 3)
                light = [float(word) for word in light.split(",")]
                exact = numpy.clip(values(ptm, stored, *light, numpy.float64, in_type(numpy.float64)), 0, 255)
                for name, result in compared.items():
                    found = renders[name](ptm, stored, light)
                    error = numpy.abs(found - exact)
                    result["samples"] += found.size
                    result["reference"] += int((found != reference).sum())
                    result["truncated"] += int((found != numpy.floor(exact)).sum())
                    result["beyond"] += int((error > 1 + 1 / 64).sum())
                    result["largest"] = max(result["largest"], float(error.max()))
    return compared


# Texture units


def gray(values):
    return numpy.array([[value, value, value, 1.0] for value in values])


def weights(unit, format):
    """Samples between two texels 0 and 1 at 65,537 coordinates."""
    coordinates = ((0.5 + numpy.arange(65537) / 65536) / 2).astype(numpy.float32)
    exact = coordinates.astype(float) * 2 - 0.5
    found = unit.sample([([2], gray([0, 1]))], ["edge"], coordinates[:, None], format=format, linear=True)[:, 0].astype(float)
    steps = {k: bool(numpy.all(numpy.abs(found * k - numpy.round(found * k)) < 1e-4 * k / 255)) for k in (255, 256)}
    return {"distinct": len(numpy.unique(found)), "error": float(numpy.abs(found - exact).max()), "half": float(found[32768]),
            "steps": next((k for k, all_are in steps.items() if all_are), None)}


def bilinear(unit):
    """Samples between random texels. Returns the largest error."""
    random = numpy.random.default_rng(7)
    texels = random.random((16, 4))
    at = (random.random((20000, 2)) * 0.75 + 0.125).astype(numpy.float32)
    found = unit.sample([([4, 4], texels)], ["edge"] * 2, at, linear=True).astype(float)
    position = at.astype(float) * 4 - 0.5
    low = numpy.floor(position).astype(int)
    a, b = (position - low)[:, :1], (position - low)[:, 1:]
    grid = texels.astype(numpy.float32).astype(float).reshape(4, 4, 4)
    corner = lambda i, j: grid[numpy.clip(low[:, 1] + j, 0, 3), numpy.clip(low[:, 0] + i, 0, 3)]
    exact = (1 - a) * (1 - b) * corner(0, 0) + a * (1 - b) * corner(1, 0) + (1 - a) * b * corner(0, 1) + a * b * corner(1, 1)
    return float(numpy.abs(found - exact).max())


def closest(unit, n, wrap, coordinates, border=-1.0):
    at = numpy.array(coordinates, numpy.float32)[:, None]
    return [float(v) for v in unit.sample([([n], gray(range(n)))], [wrap], at, format="r32f", border=[border] * 4)[:, 0]]


def ties(unit):
    """Returns, for each number of texels, how many of the coordinates k/N give a texel other than k."""
    return {n: sum(v != k for k, v in enumerate(closest(unit, n, "repeat", [k / n for k in range(n)]))) for n in (2, 3, 4, 5, 6, 7, 8, 9, 11, 13, 100, 255, 1000)}


COORDINATES = {"1": 1.0, "-0": -0.0, "-2^-24": -2.0**-24, "-1e-10": -1e-10, "-1e-38": -1e-38, "1 - 2^-24": 1 - 2.0**-24, "2": 2.0, "-1": -1.0,
               "2^20 + 1/3": 2.0**20 + 1 / 3, "-2^20 - 1/3": -(2.0**20) - 1 / 3, "2^23": 2.0**23, "2^24 + 2": 2.0**24 + 2, "3e9": 3e9}


def boundaries(unit):
    """Returns {mode: [coordinate (N): texel instead of texel]} for textures of 3 and 4 texels."""
    wrong = {}
    for wrap in "repeat", "mirror", "edge", "border":
        sizes = {}
        for n in 3, 4:
            show = lambda k: {-1: "border", None: "border", n - 1: "last"}.get(k, f"{k or 0:g}")
            found = closest(unit, n, wrap, list(COORDINATES.values()))
            for (name, s), texel in zip(COORDINATES.items(), found):
                exact = units.inside(wrap, math.floor(Fraction(float(numpy.float32(s))) * n), n)
                if texel != (-1 if exact is None else exact):
                    sizes.setdefault(f"{name}: {show(texel)} instead of {show(exact)}", []).append(str(n))
        wrong[wrap] = [what + ("" if len(found) == 2 else f" (N = {found[0]})") for what, found in sizes.items()]
    return wrong


def border(unit):
    """Samples the texels 0.25 and 0.75 with a border of 2."""
    at = [0.0, 0.05, 0.95, 1.0, 1.2, 1.25]
    sample = lambda linear: unit.sample([([2], gray([0.25, 0.75]))], ["border"], [[s] for s in at], linear=linear, border=[2] * 4)[:, 0]
    return {"linear": [round(float(v), 4) for v in sample(True)], "closest": [round(float(v), 4) for v in sample(False)]}


def levels(unit):
    pyramid = [([8 >> n, 8 >> n], gray([n] * (8 >> n)**2)) for n in range(4)]
    at = numpy.full((65537, 2), 0.3, numpy.float32)
    depths = numpy.arange(65537) / 65536
    between = unit.sample(pyramid, ["repeat"] * 2, at, linear=True, mipmap="linear", level=depths)[:, 0]
    nearest = unit.sample(pyramid, ["repeat"] * 2, at, mipmap="nearest", level=depths)[:, 0]

    def depth(dx, dy):
        gradients = [numpy.array([[part / 8 for part in vector]], numpy.float32) for vector in (dx, dy)]
        return float(unit.sample(pyramid, ["repeat"] * 2, at[:1], linear=True, mipmap="linear", gradients=gradients)[0, 0])

    spans = [1 + 3 * i / 64 for i in range(65)]
    random = numpy.random.default_rng(3)
    made = 0.0
    for size in [4], [4, 4], [4, 4, 4]:
        texels = random.random((math.prod(size), 4))
        exact = texels.astype(numpy.float32).astype(float).reshape([*size, 4])
        for axis in range(len(size)):
            exact = (exact.take(range(0, 4, 2), axis) + exact.take(range(1, 4, 2), axis)) / 2
        made = max(made, float(numpy.abs(unit.half(size, texels, "rgba32f")[1] - exact.reshape(-1, 4)).max()))
    return {"distinct": len(numpy.unique(between)), "error": float(numpy.abs(between - depths).max()), "nearest at 0.5": float(nearest[32768]),
            "axis": max(abs(depth((s, 0), (0, 0)) - math.log2(s)) for s in spans), "(2, 2)": depth((2, 2), (0, 0)), "(3, 4)": depth((3, 4), (0, 0)),
            "(4, 0), (3, 1)": depth((4, 0), (3, 1)), "made": made}


def measure_unit(program, renderer):
    """Returns what one renderer does. Runs in a process of its own, whose environment chooses the renderer."""
    unit = units.make("opengl")
    return {"renderer": unit.describe(), "colors": measure_colors(program, renderer), "weights": {format: weights(unit, format) for format in units.FORMATS},
            "bilinear": bilinear(unit), "ties": ties(unit), "boundaries": boundaries(unit), "border": border(unit), "levels": levels(unit)}


# check


def check(program, environment, *arguments):
    """Returns what one run of `check` counts, and the cause that it names."""
    with tempfile.TemporaryDirectory() as folder:
        report = pathlib.Path(folder) / "report.yaml"
        command = [program, "check", "--quiet", "--report", report, *arguments]
        done = subprocess.run(command, env={**os.environ, **environment}, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        if not report.exists():
            raise SystemExit(done.stdout)
        text = report.read_text()
    outcomes = re.findall(r"^\s*- (?:case|id): (\S+)\n(?:(?!\s*- (?:case|id): ).*\n)*?\s+outcome: (\S+)", text, re.MULTILINE)
    failures = [case for case, outcome in outcomes if outcome == "fail"]
    passed = sum(outcome == "pass" for _, outcome in outcomes)
    cause = re.search(r"^(\d+ of \d+ failures: .*?) \(clause", done.stdout, re.MULTILINE)
    return {"passed": passed, "judged": passed + len(failures), "failures": failures, "cause": cause[1] if cause else "none" if failures else ""}


STAGES = [
    ("OpenGL, RGBA32F", "llvmpipe", []),
    ("OpenGL, RGBA32F, ClampExplicit as GL_CLAMP_TO_BORDER", "llvmpipe", ["--border"]),
    ("OpenGL, RGBA8", "llvmpipe", ["--format", "rgba8"]),
    ("OpenGL, RGBA16F", "llvmpipe", ["--format", "rgba16f"]),
    ("OpenGL, RGBA32F", "softpipe", []),
    ("OpenGL, RGBA8", "softpipe", ["--format", "rgba8"]),
    ("emulation of 8-bit weights", "numpy", ["--unit", "emulated"]),
    ("emulation of 8-bit weights, RGBA8", "numpy", ["--unit", "emulated", "--format", "rgba8"]),
]
DECODERS = [
    ("RGBA8 framebuffer", "llvmpipe", []),
    ("RGBA16F framebuffer, rounded", "llvmpipe", ["--target", "rgba16f"]),
    ("RGBA32F framebuffer, truncated", "llvmpipe", ["--target", "rgba32f", "--truncate"]),
    ("RGBA8 framebuffer", "softpipe", []),
]


def measure_checks(program, chosen):
    results = {"decoders": [], "stages": []}
    for kind, rows, example, options in ("decoders", DECODERS, "ptm_shader.py", ["--view", "rgb"]), ("stages", STAGES, "texture_stage.py", ["--suite", "texture"]):
        for name, renderer, arguments in rows:
            if renderer in (*chosen, "numpy"):
                result = check(program, RENDERERS.get(renderer, {}), *options, "--", sys.executable, str(HERE / example), *arguments)
                results[kind].append({"name": name, "renderer": renderer, **result})
                say(f"{name}, {renderer}: {result}")
    return results


# The tables


def percent(part, whole):
    share = 100 * part / whole
    return "0" if part == 0 else f"{share:.{2 if share < 1 else 3}g} %"


def fraction_of_255(error):
    return "0" if error < 1e-6 else f"{error * 255:.3f}/255"


def markdown(results, recorded, date):
    units_of = results["units"]
    lines = ["### Colors of a PTM", ""]
    rows = []
    for renderer, measured in units_of.items():
        for name, r in measured["colors"].items():
            rows.append([f"{renderer}, {name}", date, percent(r["reference"], r["samples"]), percent(r["truncated"], r["samples"]),
                         f"{r['largest']:.3f}", percent(r["beyond"], r["samples"])])
    lines += table(["evaluation", "date", "bytes that differ from the reference's", "from truncated bytes", "largest error", "beyond 1 + 1/64"], rows + recorded["colors"])
    if "checks" in results:
        lines += ["### PTM decoders in `check --view rgb`", ""]
        rows = [[f"{r['renderer']}, {r['name']}", date, f"{r['passed']} of {r['judged']}", ", ".join(r["failures"]) or "–"] for r in results["checks"]["decoders"]]
        lines += table(["decoder", "date", "passed", "failures"], rows + recorded["decoders"])
    gl = {renderer: measured for renderer, measured in units_of.items() if "weights" in measured}
    lines += ["### Weights of a linear filter", ""]
    rows = []
    for renderer, measured in gl.items():
        for formats in ("r8", "rgba8"), ("r32f", "rgba32f", "rgba16f"):
            groups = {}
            for format in formats:
                groups.setdefault(json.dumps(measured["weights"][format]), []).append(format.upper())
            for text, same in groups.items():
                w = json.loads(text)
                steps = f"multiples of 1/{w['steps']}" if w["steps"] else "–"
                error = f"{measured['bilinear']:.1g}" if "RGBA32F" in same else "–"
                rows.append([renderer, date, ", ".join(same), f"{w['distinct']:,}", steps, fraction_of_255(w["error"]), error])
    lines += table(["renderer", "date", "textures", "distinct weights", "values", "largest error", "of bilinear samples in 0…1"], rows + recorded["weights"])
    lines += ["### The closest texel at s = k/N", ""]
    rows = []
    for renderer, measured in gl.items():
        counts = {int(n): count for n, count in measured["ties"].items()}
        rows.append([renderer, date, ", ".join(str(n) for n, count in counts.items() if not count),
                     ", ".join(f"{n} ({count} of {n - 1})" for n, count in counts.items() if count) or "–"])
    lines += table(["renderer", "date", "N that give texel k for each k", "N that give texel k − 1 for some k (how many)"], rows + recorded["ties"])
    lines += ["### Boundary conditions at extreme coordinates", ""]
    rows = []
    for renderer, measured in gl.items():
        rows.append([renderer, date] + ["; ".join(measured["boundaries"][wrap]) or "exact" for wrap in ("repeat", "mirror", "edge", "border")])
    lines += table(["renderer", "date", "`GL_REPEAT`", "`GL_MIRRORED_REPEAT`", "`GL_CLAMP_TO_EDGE`", "`GL_CLAMP_TO_BORDER`"], rows + recorded["boundaries"])
    lines += ["### `GL_CLAMP_TO_BORDER`: texels 0.25 and 0.75, border 2", ""]
    rows = [[renderer, date, filter] + measured["border"][key] for renderer, measured in gl.items() for filter, key in (("linear", "linear"), ("nearest", "closest"))]
    lines += table(["renderer", "date", "filter", "s = 0", "0.05", "0.95", "1", "1.2", "1.25"], rows + recorded["border"])
    lines += ["### Levels and depth", ""]
    rows = []
    for renderer, measured in gl.items():
        level = measured["levels"]
        rows.append([renderer, date, f"{level['distinct']:,}", f"{level['error']:.2g}", f"{level['nearest at 0.5']:g}", f"{level['axis']:.2g}"]
                    + [f"{level[key]:.4f}" for key in ("(2, 2)", "(3, 4)", "(4, 0), (3, 1)")] + [f"{level['made']:.0e}"])
    lines += table(["renderer", "date", "weights between levels", "largest error", "nearest level at depth 0.5", "largest error of the depth along an axis",
                    "depth for (2, 2): log2 is 1.5", "(3, 4): 2.3219", "(4, 0), (3, 1): longest 2, ellipse 2.3325", "error of `glGenerateMipmap`"], rows + recorded["levels"])
    if "checks" in results:
        lines += ["### Texture stages in `check --suite texture`", ""]
        rows = [[f"{r['renderer']}, {r['name']}", date, f"{r['passed']} of {r['judged']}", summary(r["failures"]), r["cause"] or "–"]
                for r in results["checks"]["stages"]]
        lines += table(["stage", "date", "passed", "failures", "cause that is named"], rows + recorded["stages"])
    lines += ["### nvJPEG", ""] + table(["planes", "date", "result"], recorded["nvjpeg"])
    lines += [f"Renderers: {'; '.join(measured['renderer'] for measured in units_of.values())}."]
    return "\n".join(lines) + "\n"


def summary(failures):
    """Lists a few failures, or counts many by the prefix of their ids."""
    if len(failures) < 12:
        return ", ".join(failures) or "–"
    groups = {}
    for case in failures:
        groups[case.split("-")[0]] = groups.get(case.split("-")[0], 0) + 1
    return f"{len(failures)}: " + ", ".join(f"{group} {count}" for group, count in sorted(groups.items(), key=lambda pair: (-pair[1], pair[0])))


def main():
    parser = measuring.option_parser(__doc__)
    parser.add_argument("--no-check", action="store_true", help="do not run `check`")
    parser.add_argument("--gpu", action="store_true", help="measure the renderer that EGL chooses, instead of Mesa's")
    parser.add_argument("--unit", choices=RENDERERS, help=argparse.SUPPRESS)
    options = measuring.parse(parser)
    program = options.program
    if options.unit:
        return print(json.dumps(units.or_skip(measure_unit, program, options.unit)))
    chosen = ["gpu"] if options.gpu else ["llvmpipe", "softpipe"]
    results = {"units": {}}
    for renderer in chosen:
        command = [sys.executable, __file__, "--unit", renderer, "--program", program]
        done = subprocess.run(command, env={**os.environ, **RENDERERS[renderer]}, stdout=subprocess.PIPE)
        if done.returncode:
            sys.exit(done.returncode)
        results["units"][renderer] = json.loads(done.stdout)
        say(f"{renderer}: measured")
    results["units"]["numpy"] = {"renderer": f"numpy {numpy.__version__}", "colors": measure_colors(program, "numpy")}
    if not options.no_check:
        results["checks"] = measure_checks(program, chosen)
    recorded = json.loads((HERE / "recorded.json").read_text())
    measuring.write_results(options, "examples/gpu/measure.py", results, markdown(results, recorded, datetime.date.today().isoformat()))


if __name__ == "__main__":
    main()
