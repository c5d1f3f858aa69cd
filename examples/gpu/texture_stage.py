#!/usr/bin/env python3
"""The texture stage of PEXlib 5.2 with a texture unit for all sampling.

    texture_stage.py [--unit opengl|cuda|emulated] [--format rgba32f|rgba16f|rgba8] [--border] texture FILE

examples/decoders/pex_texture.py answers the question. The unit finds the closest texel, averages, applies boundary conditions, and
interpolates between levels; OpenGL also chooses the depth and makes levels. ClampExplicit is tested here, because GL_CLAMP_TO_EDGE knows no
outside; with --border it is GL_CLAMP_TO_BORDER. Exit status: as pex_texture.py, and 77 if the unit is missing.
"""

import argparse
import pathlib
import sys

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "decoders")]
import pex_texture

WRAPS = {"Wrap": "repeat", "Mirror": "mirror", "ClampBorder": "edge", "ClampExplicit": "edge"}
COMPONENTS = {"L": 1, "LA": 2, "RGB": 3, "RGBA": 4}


class Stage:
    def __init__(self, unit, format, border):
        self.name, self.format, self.border, self.unit = unit, format, border, None
        self.soft_answer, self.soft_half = pex_texture.answer, pex_texture.half_level
        pex_texture.fetch, pex_texture.answer = self.fetch, self.answer
        pex_texture.half_level = self.half_level

    def start(self):
        """Imports the unit when a question needs it. Most do not."""
        import units
        self.units = units
        self.unit = self.unit or units.or_skip(units.make, self.name)

    def fetch(self, entry, texture, t, depth=0.0, magnify=False):
        self.start()
        dimensions = len(texture["levels"][0]["size"])
        explicit = [d for d in range(dimensions) if entry["boundary"][d] == "ClampExplicit"]
        outside = ("clamp", entry["clamp_color"]) if entry["clamp_method"] == "Color" else None
        if not self.border and any(not 0 <= t[d] <= 1 for d in explicit):
            return outside
        method = entry["mag_sample"] if magnify else entry["min_sample"]
        mipmap = "none" if method.endswith("Base") else "nearest" if method.endswith("InMipmap") else "linear"
        wraps = ["border" if self.border and d in explicit else WRAPS[entry["boundary"][d]] for d in range(dimensions)]
        options = {"format": self.format, "linear": method.startswith("Weighted"), "mipmap": mipmap, "level": depth}
        levels = [(level["size"], self.units.rgba(level["texels"])) for level in texture["levels"]]
        if self.border and explicit:
            # A texture of ones with a border of zeros tells whether only the border is sampled.
            ones = [(size, [[1.0] * 4] * len(texels)) for size, texels in levels]
            if self.unit.sample(ones, wraps, [t[:dimensions]], border=(0, 0, 0, 0), **options)[0, 0] == 0:
                return outside
        sampled = self.unit.sample(levels, wraps, [t[:dimensions]], border=(*entry["clamp_color"], 1), **options)[0]
        return texture["kind"], [float(component) for component in sampled[:COMPONENTS[texture["kind"]]]]

    def half_level(self, level):
        self.start()
        if self.name != "opengl":
            return self.soft_half(level)
        size, texels = self.unit.half(level["size"], self.units.rgba(level["texels"]), self.format)
        return {"size": size, "texels": [[float(c) for c in texel[:len(level["texels"][0])]] for texel in texels]}

    def answer(self, op, given):
        if op == "index":
            self.start()
            texels = self.units.rgba([[k] for k in range(given["size"])])
            sampled = self.unit.sample([([given["size"]], texels)], [WRAPS[given["boundary"]]], [[t] for t in given["t"]])
            return {"index": [round(float(k)) for k in sampled[:, 0]]}
        if op == "depth" and self.name == "opengl":
            self.start()
            size = given["size"]
            hints = (given.get("freq", []) + [1.0] * 3)[:len(size)]
            steps = [[hint * step for hint, step in zip(hints, given[name])] for name in ("dtdx", "dtdy")]
            depth = self.unit.depth(size, *steps, given.get("bias", 0.0))
            return {"depth": depth, "mode": "min" if depth > 0 else "mag"}
        return self.soft_answer(op, given)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--unit", choices=["opengl", "cuda", "emulated"], default="opengl")
    parser.add_argument("--format", choices=["rgba32f", "rgba16f", "rgba8"], default="rgba32f")
    parser.add_argument("--border", action="store_true")
    options, sys.argv[1:] = parser.parse_known_args()
    Stage(options.unit, options.format, options.border)
    return pex_texture.main()


if __name__ == "__main__":
    sys.exit(main())
