#!/usr/bin/env python3
"""The texture stage of PEXlib 5.2: answers one question about the texture mapping table.

    pex_texture.py texture FILE    FILE is a question in JSON; the answer is a JSON object on standard output

Exit status: 0 answered, 65 out of the valid range or malformed, 69 unsupported. The steps are in the order of
the pipeline. If the chapter leaves a question open, the name of the ruling follows in brackets, as in [gamma].
It needs only the standard library of Python 3.8 or later. For maps made from PTM files, it also needs
ptm_decoder.py in the same directory.
"""

import json
import math
import sys


class OutOfRange(Exception):
    """A value of the question is out of the valid range."""


class Unsupported(Exception):
    """The question may be valid, but this program does not answer it."""


class ImplementationDefined(Exception):
    """The chapter gives no answer. The argument names the open point."""


# The table: fallback values, and the entry for an index

IDENTITY = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
FALLBACK = {
    "map_ids": [],
    "rendering_control": "PostLight",
    "parameterization": "ReflectionSphereVRC",
    "fp_data_index": 0,
    "reflection_matrix": IDENTITY,
    "reflection_hints": "Identity",
    "orientation_matrix": IDENTITY,
    "orientation_hints": "Identity",
    "composition": "Replace",
    "channel": "Red",
    "env_color": [0, 0, 0],
    "background_color": [0, 0, 0],
    "min_sample": "SingleBase",
    "mag_sample": "SingleBase",
    "boundary": ["Wrap", "Wrap", "Wrap"],
    "clamp_method": "Discontinue",
    "clamp_color": [0, 0, 0],
    "depth_bias": 0.0,
    "frequency": [1.0, 1.0, 1.0],
}


def complete_entry(fields):
    return {**FALLBACK, **fields}


def resolve(given):
    table = given.get("table", {})
    index = given["index"]
    if not 1 <= index <= 65535:
        raise OutOfRange("index-out-of-range")
    for named in (str(index), "1"):                       # [undefined-entry]
        if named in table:
            return complete_entry(table[named])
    return complete_entry({})


# Selection: the table entries for a facet

def select(given):
    front = given.get("interior_style"), given.get("active", [])
    back = given.get("bf_interior_style"), given.get("bf_active", [])
    is_back = given.get("facet_distinguish", False) and given.get("back_facing", False)
    style, active = back if is_back else front
    if style != "Texture":
        return {"entries": "untextured"}
    if not active:
        return {"entries": ["default"]}
    return {"entries": active[:given.get("max_texture_maps", len(active))]}


# Parameterization: the source of texture coordinates

def parameterize(entry, point, dimensions):
    method = entry["parameterization"]
    if method == "VertexMCCoord":
        return point["mc"]
    if method == "VertexWCCoord":
        return point["wc"]
    if method == "VertexMCNormal":
        return normal(point, "mc")
    if method == "VertexWCNormal":
        return normal(point, "wc")
    if method == "NURBUV":
        return [point.get("u", 0.0), point.get("v", 0.0), 0.0] if is_spline(point) else [0.0, 0.0, 0.0]
    if method == "FloatData":
        return float_data(entry["fp_data_index"], point, dimensions)
    if method == "ReflectionSphereVRC":
        x, y, z = reflection(entry, point, "vrc")
        # [vrc-azimuth] Half a turn spans the whole map: from -x past the viewer to +x, and again on the far side.
        return [turns(x, z) * 2 % 1, height(x, y, z), 0.0]
    if method == "ReflectionSphereWC":
        x, y, z = reflection(entry, point, "wc")
        return [turns(x, z), height(x, y, z), 0.0]         # [wc-azimuth]
    raise Unsupported(method)


def normal(point, space):
    own, facet = point.get(space + "_normal"), point.get(space + "_geometric_normal")
    return own if own is not None else facet


def is_spline(point):
    return point.get("nurb", "u" in point or "data_splines" in point)


def float_data(first, point, dimensions):
    if is_spline(point):
        data = [values[0] for values in point.get("data_splines", [])]
    else:
        data = point.get("fp_data", [])
    wanted = data[first:first + dimensions]
    if len(wanted) < dimensions:
        raise ImplementationDefined("fp-data-short")
    return wanted + [0.0] * (3 - dimensions)


def reflection(entry, point, space):
    """Returns the reflection vector, transformed by the reflection matrix, as a unit vector."""
    s = point.get("s")
    if s is None:
        i = point.get("i")
        if i is None:
            i = unit([p - e for p, e in zip(point[space], point["eye_" + space])])
        s = reflect(i, normal(point, space))
    # [reflection-matrix] A direction is rotated but not translated, so the last column is ignored.
    turned = [sum(m * c for m, c in zip(row, s)) for row in entry["reflection_matrix"][:3]]
    if not any(turned):
        raise ImplementationDefined("no-reflection")
    return unit(turned)


def reflect(i, n):
    """Returns the line of sight reflected at the normal n [reflection-vector]."""
    n_dot_i = sum(a * b for a, b in zip(n, i))
    return [a - 2 * n_dot_i * b for a, b in zip(i, n)]


def unit(vector):
    length = math.sqrt(sum(c * c for c in vector))
    return [c / length for c in vector] if length else vector


def turns(x, z):
    """Returns the angle around +y as a fraction of a turn, from +x, counter-clockwise as seen from +y [poles]."""
    return math.atan2(-z, x) / (2 * math.pi) % 1 if x or z else 0.0


def height(x, y, z):
    """Returns the angle from -y, scaled to 0 at -y and 1 at +y [vrc-height, wc-height]."""
    return 1 - math.atan2(math.hypot(x, z), y) / math.pi


# Orientation, interpolation, sites

def orient(matrix, t):
    x, y, z, w = (row[0] * t[0] + row[1] * t[1] + row[2] * t[2] + row[3] for row in matrix)
    return [c / w for c in (x, y, z)] if w not in (0, 1) else [x, y, z]     # [orientation-w]


def interpolate(given):
    shares, corners = given["b"], given["ts"]
    if given["correction"] == "Vertex":
        raise ImplementationDefined("vertex-correction")
    if given["correction"] == "Pixel":                     # [perspective]
        shares = [b / w for b, w in zip(shares, given["w"])]
        shares = [b / sum(shares) for b in shares]
    return [sum(b * t for b, t in zip(shares, ts)) for ts in zip(*corners)]


def site(given):
    if given["frequency"] == "Pixel":
        return "pixel"
    return {"None": "facet", "Color": "vertex", "DotProduct": "pixel", "Normal": "pixel"}[given["interp"]]


# Depth and mode

def depth(given):
    size = given["size"]
    hints = given.get("freq", []) + [1.0] * 3
    spans = [n * math.hypot(dx, dy) for n, dx, dy in zip(size, given["dtdx"], given["dtdy"])]
    widest = max(hint * span for hint, span in zip(hints, spans))           # [depth-formula]
    level = math.log2(widest) + given.get("bias", 0.0) if widest else "-inf"
    return {"depth": level, "mode": "min" if max(spans) > 1 else "mag"}     # [one-texel, bias-and-mode]


# Texture maps: a kind, and levels with a size and texels; t0 varies fastest

def checkerboard():
    def square(k):
        i, j = k % 16 // 2, k // 16 // 2
        return [1.0 - (i + j) % 2] * 3
    return {"kind": "RGB", "levels": [{"size": [16, 16], "texels": [square(k) for k in range(256)]}]}


def read_map(given):
    if given is None or given == "default":
        return checkerboard()
    made = ptm_map(given) if "ptm" in given else {"kind": given["kind"], "levels": list(given["levels"])}
    if given.get("mipmap") == "box":
        while max(made["levels"][-1]["size"]) > 1:
            made["levels"].append(half_level(made["levels"][-1]))
    return made


def ptm_map(given):
    """Returns a PTM under a light as a map. Both start with the bottom row [ptm-rows]."""
    try:
        import ptm_decoder
    except ImportError:
        raise Unsupported("maps made from PTM files need ptm_decoder.py") from None
    ptm = ptm_decoder.read_ptm(bytes.fromhex(given["ptm"]))
    colors = [ptm_decoder.texel_color(ptm, texel, *given["light"]) for texel in ptm.texels]
    rows = [colors[y * ptm.width:(y + 1) * ptm.width] for y in range(ptm.height)]
    step = (lambda c: math.floor(c + 0.5)) if given.get("texel") == "rgb8" else (lambda c: c)   # [ptm-texels]
    texels = [[step(min(255.0, max(0.0, c))) / 255 for c in color] for row in reversed(rows) for color in row]
    return {"kind": "RGB", "levels": [{"size": [ptm.width, ptm.height], "texels": texels}]}


def half_level(level):
    """Returns the next level: each texel is the mean of those it covers. All sizes can be halved [level-making]."""
    size = [max(1, n // 2) for n in level["size"]]
    texels = []
    for at in places(size):
        near = places([n // m for n, m in zip(level["size"], size)])
        below = [[c * (n // m) + o for c, o, n, m in zip(at, off, level["size"], size)] for off in near]
        parts = [texel_at(level, place) for place in below]
        texels.append([sum(values) / len(parts) for values in zip(*parts)])
    return {"size": size, "texels": texels}


def places(size):
    """Returns the positions of all texels of a level; t0 varies fastest."""
    if not size:
        return [[]]
    return [[i] + rest for rest in places(size[1:]) for i in range(size[0])]


def texel_at(level, place):
    number = 0
    for n, i in zip(reversed(level["size"]), reversed(place)):
        number = number * n + i
    return level["texels"][number]


# Sampling

def fetch(entry, texture, t, sample_depth=0.0, magnify=False):
    """Returns the kind and the components of a sample, ("clamp", clamp color), or None if texturing is discontinued."""
    directions = range(len(texture["levels"][0]["size"]))
    if any(entry["boundary"][d] == "ClampExplicit" and not 0 <= t[d] <= 1 for d in directions):
        return ("clamp", entry["clamp_color"]) if entry["clamp_method"] == "Color" else None
    method = entry["mag_sample"] if magnify else entry["min_sample"]
    take = weighted if method.startswith("Weighted") else closest
    levels = texture["levels"]
    top = len(levels) - 1
    if method.endswith("Base"):
        return texture["kind"], take(entry, levels[0], t)
    if method.endswith("InMipmap"):
        nearest = math.ceil(sample_depth - 0.5)            # [level-tie]
        return texture["kind"], take(entry, levels[min(top, max(0, nearest))], t)
    # Interpolate between two levels. Beyond the first or the last level, use only that level.
    exact = min(float(top), max(0.0, sample_depth))
    lower = math.floor(exact)
    upper = min(top, lower + 1)
    below, above = take(entry, levels[lower], t), take(entry, levels[upper], t)
    return texture["kind"], [a + (exact - lower) * (b - a) for a, b in zip(below, above)]


def closest(entry, level, t):
    """Returns the texel whose cell contains t [texel-grid, texel-tie]."""
    place = [inside(entry["boundary"][d], math.floor(t[d] * n), n) for d, n in enumerate(level["size"])]
    return texel_at(level, place)


def weighted(entry, level, t):
    """Returns the weighted mean of the 2^n texels whose centers surround t [weights]."""
    total = None
    for corner in places([2] * len(level["size"])):
        place, weight = [], 1.0
        for d, n in enumerate(level["size"]):
            low = math.floor(t[d] * n - 0.5)
            share = t[d] * n - 0.5 - low
            place.append(inside(entry["boundary"][d], low + corner[d], n))
            weight *= share if corner[d] else 1 - share
        part = [weight * c for c in texel_at(level, place)]
        total = part if total is None else [a + b for a, b in zip(total, part)]
    return total


def inside(boundary, k, n):
    """Maps the texel index k, which may be out of range, to an index in the map."""
    if boundary == "Wrap":
        return k % n
    if boundary == "Mirror":
        k %= 2 * n
        return k if k < n else 2 * n - 1 - k
    return min(n - 1, max(0, k))                           # ClampBorder, or ClampExplicit inside [explicit-neighbour]


# Composition

def compose(entry, sampled, color, alpha, white):
    """Applies one map. `white` is a white surface in the light (split form), or white itself (direct form)."""
    if sampled is None:
        return color, alpha
    kind, parts = sampled
    if kind == "clamp":                                    # [clamp-color] The clamp color has no alpha.
        kind = "RGB"
    has_alpha = kind.endswith("A")
    texel = [parts[0]] * 3 if kind.startswith("L") else list(parts[:3])
    texel_alpha = parts[-1] if has_alpha else 1.0
    method = entry["composition"]
    lit = [w * t for w, t in zip(white, texel)]
    if method == "Replace":
        return lit, texel_alpha if has_alpha else alpha
    if method == "Modulate":
        return [c * t for c, t in zip(color, texel)], alpha * texel_alpha
    if method == "BlendEnvColor":
        gamma = selected(entry["channel"], kind, texel, texel_alpha)
        environment = [w * e for w, e in zip(white, entry["env_color"])]
        return blend(color, environment, gamma), alpha * texel_alpha
    if method == "Decal":
        return blend(color, lit, texel_alpha), alpha
    if method == "DecalBackground":
        background = [w * b for w, b in zip(white, entry["background_color"])]
        return blend(background, lit, texel_alpha), alpha
    raise Unsupported(method)


def selected(channel, kind, texel, texel_alpha):
    """Returns the factor for BlendEnvColor: a channel, or the luminance [gamma, no-alpha-to-select]."""
    if kind.startswith("L"):
        return texel[0]
    return {"Red": texel[0], "Green": texel[1], "Blue": texel[2], "Alpha": texel_alpha}[channel]


def blend(under, over, share):
    return [(1 - share) * a + share * b for a, b in zip(under, over)]


# The whole stage

def sample_of(given, entry):
    if "texel" in given:
        return None if given["texel"] == "discontinue" else tuple(given["texel"])
    texture = read_map(given.get("map"))
    t = given.get("t")
    if t is None:
        t = parameterize(entry, given["point"], len(texture["levels"][0]["size"]))
        t = orient(entry["orientation_matrix"], t)
    return fetch(entry, texture, t, given.get("depth", 0.0), given.get("mag", False))


def stage(given):
    surface = given["surface"]
    color, alpha = surface["color"], surface.get("alpha", 1.0)
    white, specular = surface.get("cw", [1, 1, 1]), surface.get("cs", [0, 0, 0])
    maps = []
    for one in given["entries"]:
        entry = complete_entry(one.get("entry", {}))
        maps.append((entry, sample_of(one, entry)))
    # [two-stages, split-form]
    split = given.get("interp", "None") in ("None", "Color") and given.get("frequency") == "Pixel"
    if split:
        color = [w * c for w, c in zip(white, color)]
    for entry, sampled in maps:
        if entry["rendering_control"] == "PreLight":
            color, alpha = compose(entry, sampled, color, alpha, white if split else [1, 1, 1])
    if not split:
        color = [w * c for w, c in zip(white, color)]
    color = [c + s for c, s in zip(color, specular)]
    for entry, sampled in maps:
        if entry["rendering_control"] == "PostLight":
            color, alpha = compose(entry, sampled, color, alpha, [1, 1, 1])
    return {"color": color, "alpha": alpha}


# Questions and answers

def answer(op, given):
    entry = complete_entry(given.get("entry", {}))
    if op == "defaults":
        return complete_entry({})
    if op == "select":
        return select(given)
    if op == "resolve":
        return resolve(given)
    if op == "parameterize":
        return {"t": parameterize(entry, given["point"], given.get("dim", 2))}
    if op == "reflect":
        return {"s": reflect(given["i"], given["n"])}
    if op == "orient":
        return {"t": orient(given["matrix"], given["t"])}
    if op == "interpolate":
        return {"t": interpolate(given)}
    if op == "sites":
        return {"site": site(given)}
    if op == "depth":
        return depth(given)
    if op == "index":
        n = given["size"]
        return {"index": [inside(given["boundary"], math.floor(t * n), n) for t in given["t"]]}
    if op == "sample":
        sampled = fetch(entry, read_map(given["map"]), given["t"], given.get("depth", 0.0), given.get("mag", False))
        return {"texel": sampled[1] if sampled else "discontinue"}
    if op == "compose":
        texel = None if given["texel"] == "discontinue" else given["texel"]
        white = given.get("cw", [1, 1, 1])
        color, alpha = compose(entry, texel, given["color"], given.get("alpha", 1.0), white)
        return {"color": color, "alpha": alpha}
    if op == "stage":
        return stage(given)
    raise Unsupported(op)


def main():
    if len(sys.argv) != 3 or sys.argv[1] != "texture":
        print(__doc__, file=sys.stderr)
        return 69
    with open(sys.argv[2], encoding="utf-8") as file:
        question = json.load(file)
    try:
        print(json.dumps(answer(question["op"], question["given"])))
    except ImplementationDefined as point:
        print(json.dumps({"impl_defined": str(point)}))
    except OutOfRange as why:
        print("out of range:", why, file=sys.stderr)
        return 65
    except Unsupported as what:
        print("unsupported:", what, file=sys.stderr)
        return 69
    return 0


if __name__ == "__main__":
    sys.exit(main())
