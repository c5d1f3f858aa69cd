#!/usr/bin/env python3
"""A PTM fitter: the least-squares optimum for images under known lights, as RGB or LRGB.

    ptm_fitter.py fit REQUEST OUT

REQUEST is a JSON file with format, width, height and the path of an .lp file. OUT is the PTM file to write. See
docs/writers.md. Exit status: 0 written, 69 unsupported format. It needs NumPy. The images are 8-bit RGB PNG files.

    ptm-conform check-writer --fitter -- python3 examples/writers/ptm_fitter.py
"""

import json
import os
import struct
import sys
import zlib

import numpy as np


def read_png(path):
    """Returns the height × width × 3 values of an 8-bit RGB PNG file."""
    with open(path, "rb") as file:
        data = file.read()
    at, packed = 8, b""
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at:at + 8])
        chunk = data[at + 8:at + 8 + length]
        if kind == b"IHDR":
            width, height, depth, color = struct.unpack(">IIBB", chunk[:10])
        elif kind == b"IDAT":
            packed += chunk
        at += length + 12
    if (depth, color) != (8, 2):
        raise ValueError("%s: not an 8-bit RGB PNG file" % path)
    rows = np.frombuffer(zlib.decompress(packed), np.uint8).reshape(height, 1 + 3 * width)
    image = np.zeros((height + 1, 3 * width + 3), int)
    for y, row in enumerate(rows, 1):
        for x, value in enumerate(row[1:], 3):
            left, up, corner = image[y, x - 3], image[y - 1, x], image[y - 1, x - 3]
            nearest = min((left, up, corner), key=lambda value: abs(left + up - corner - value))
            image[y, x] = (int(value) + (0, left, up, (left + up) // 2, nearest)[row[0]]) % 256
    return image[1:, 3:].reshape(height, width, 3)


def read_lp(path):
    """Returns the light vectors, their rank tolerance, and the images: lights × height × width × 3."""
    with open(path, encoding="utf-8") as file:
        lines = [line.split() for line in file if line.strip()][1:]
    folder = os.path.dirname(path)
    lights = np.array([[float(number) for number in line[-3:]] for line in lines])
    # The terms of lights on a ring are dependent, but those of the rounded vectors in the file are not.
    decimals = max(len(number.partition(".")[2]) for line in lines for number in line[-3:])
    tolerance = min(max(10.0 ** -decimals / np.linalg.norm(lights, axis=1).min(), 1e-5), 3e-3)
    images = np.array([read_png(os.path.join(folder, " ".join(line[:-3]))) for line in lines])
    return lights, tolerance, images


def terms(lights):
    """1.0: returns u², v², uv, u, v, 1 of each normalized light vector."""
    lights = lights / np.linalg.norm(lights, axis=1, keepdims=True)
    u, v = lights[:, 0], lights[:, 1]
    return np.stack([u * u, v * v, u * v, u, v, np.ones_like(u)], axis=1)


def fit(design, values, tolerance):
    """Returns the least-squares solution. If there are several within the tolerance, it has the smallest norm."""
    return np.linalg.lstsq(design, values, rcond=tolerance)[0]


def split_color(design, coefficients):
    """LRGB: returns the best six luminance coefficients and the best color of each texel."""
    rendered = np.einsum("ki,itc->tkc", design, coefficients)
    color = np.abs(np.linalg.svd(rendered, full_matrices=False)[2][:, 0])
    color = np.round(color / color.max(axis=1, keepdims=True) * 255)
    along = np.einsum("itc,tc->it", coefficients, color)
    return along / (color ** 2).sum(axis=1) * 255, color


def scale_and_bias(coefficients):
    """2.4: returns six scales and biases for the ranges of the coefficients. Biases are integers."""
    low, high = coefficients.min(axis=1), coefficients.max(axis=1)
    scale = np.maximum((high - low) / 254, np.abs(low) / 1e4)
    bias = np.round(-low / np.maximum(scale, 1e-9))
    # A constant is stored as 255 if it is positive, or as 0.
    constant, middle = high - low < 0.01, (high + low) / 2
    zero = constant & (np.abs(middle) < 0.01)
    scale = np.where(zero, 1, np.where(constant, np.abs(middle) / 255, scale))
    return scale, np.where(constant, np.where(zero | (middle > 0), 0, 255), bias)


def stored(coefficients, scale, bias):
    """Returns the stored bytes, texel by texel."""
    raw = np.round(coefficients / scale[:, None] + bias[:, None])
    return np.clip(raw, 0, 255).astype(np.uint8).T.tobytes()


def write(request):
    """Returns the PTM file."""
    lights, tolerance, images = read_lp(request["lp"])
    # Texels are stored with the bottom row first (2.7).
    texels = images[:, ::-1].reshape(len(images), -1)
    design = terms(lights)
    coefficients = fit(design, texels.astype(float), tolerance).reshape(6, -1, 3)
    if request["format"] == "PTM_FORMAT_LRGB":
        luminance, color = split_color(design, coefficients)
        scale, bias = scale_and_bias(luminance)
        payload = stored(luminance, scale, bias) + color.astype(np.uint8).tobytes()
    else:
        scale, bias = scale_and_bias(coefficients.reshape(6, -1))
        payload = b"".join(stored(coefficients[:, :, channel], scale, bias) for channel in range(3))
    header = "PTM_1.2\n%s\n%d\n%d\n%s\n%s\n" % (
        request["format"], request["width"], request["height"],
        " ".join("%.9g" % number for number in scale), " ".join("%d" % number for number in bias),
    )
    return header.encode("ascii") + payload


def main():
    _, command, request, out = sys.argv
    with open(request) as file:
        request = json.load(file)
    if command != "fit" or request["format"] not in ("PTM_FORMAT_RGB", "PTM_FORMAT_LRGB"):
        sys.exit(69)
    with open(out, "wb") as file:
        file.write(write(request))


if __name__ == "__main__":
    main()
