"""Reads one file with one library, and compares the values: read.py LIBRARY FILE EXPECTED.npy NAMES

NAMES are the channels of EXPECTED.npy, separated by commas. Prints JSON: {"planes": [...]} says which channel each plane of the library
equals; {"error": "..."} is the error of the library, and {"shape": "..."} an array that is no image of this size.
"""

import json
import os
import sys
import warnings

os.environ["OPENCV_IO_ENABLE_OPENEXR"] = "1"
warnings.simplefilter("ignore")
import numpy


class NoImage(Exception):
    """The library returns no image, and raises no exception."""


def openexr(path):
    import OpenEXR
    channels = OpenEXR.File(path, separate_channels=True).channels()
    return numpy.dstack([channel.pixels for channel in channels.values()]), list(channels)


def openexr_merged(path):
    import OpenEXR
    channels = OpenEXR.File(path).channels()
    return numpy.dstack([channel.pixels for channel in channels.values()]), list(channels)


def openimageio(path):
    import OpenImageIO
    image = OpenImageIO.ImageBuf(path)
    if image.has_error:
        raise NoImage(image.geterror())
    spec = image.spec()
    return image.get_pixels(spec.format), list(spec.channelnames)


def pyexr(path):
    import pyexr
    return pyexr.read(path), list(pyexr.open(path).channels)


def minexr(path):
    import minexr
    with open(path, "rb") as file:
        image = minexr.load(file)
        return image.select(image.channel_names), image.channel_names


def opencv(path):
    import cv2
    image = cv2.imread(path, cv2.IMREAD_UNCHANGED)
    if image is None:
        raise NoImage("returns None")
    return image, None


def opencv_default(path):
    import cv2
    image = cv2.imread(path)
    if image is None:
        raise NoImage("returns None")
    return image, None


def imageio(path):
    import imageio.v3
    return imageio.v3.imread(path), None


def pyav(path):
    import av
    frame = next(av.open(path).decode(video=0))
    return frame.to_ndarray(), None


def pillow(path):
    from PIL import Image
    return numpy.asarray(Image.open(path)), None


def pyvips(path):
    import pyvips
    return pyvips.Image.new_from_file(path).numpy(), None


def tifffile(path):
    import tifffile
    return tifffile.imread(path), None


def imagecodecs(path):
    import imagecodecs
    return imagecodecs.imread(path), None


def numpy_load(path):
    return numpy.load(path), None


def node(path):
    """Reads what read.mjs has written."""
    with open(path, encoding="utf-8") as file:
        head = json.load(file)
    if "error" in head:
        raise NoImage(head["error"])
    shape = head["height"], head["width"], head["channels"]
    return numpy.fromfile(path + ".raw", head["type"]).reshape(shape), head.get("names")


READERS = {function.__name__: function for function in (openexr, openexr_merged, openimageio, pyexr, minexr, opencv, opencv_default, imageio, pyav, pillow, pyvips, tifffile,
                                                        imagecodecs, numpy_load, node)}


def describe(plane, expected, names):
    """Returns the name of the channel that a plane equals, and how it differs from it."""
    for name, channel in zip(names, numpy.moveaxis(expected, 2, 0)):
        for suffix, rows in ("", channel), (", bottom row first", channel[::-1]):
            if numpy.array_equal(plane, rows):
                return name + suffix
            clipped = numpy.clip(rows.astype(float), 0, 1)
            if plane.dtype == numpy.uint8 and expected.dtype != numpy.uint8 and numpy.array_equal(plane, numpy.floor(clipped * 255 + 0.5)) and len(numpy.unique(plane)) > 2:
                return name + ", clipped to 0…1, 8 bits" + suffix
    if len(numpy.unique(plane)) == 1:
        return f"all {plane.flat[0]:g}"
    return "other values"


def main(library, path, expected_path, names):
    try:
        image, own_names = READERS[library](path)
    except ImportError as problem:
        return {"missing": str(problem)}
    except Exception as problem:                        # libraries raise anything
        text = str(problem).strip().replace(path, "FILE").splitlines() or [""]
        return {"error": f"{type(problem).__name__}: {text[0]}" if not isinstance(problem, NoImage) else text[0]}
    expected = numpy.load(expected_path)
    image = numpy.asarray(image)
    if image.ndim == 2:
        image = image[..., None]
    if image.ndim == 4 and len(image) == 1:
        image = image[0]                                # a film of one frame
    if image.ndim == 3 and image.shape[1:] == expected.shape[:2]:
        image = numpy.moveaxis(image, 0, 2)             # planes, rows, columns
    if image.shape[:2] != expected.shape[:2]:
        return {"shape": f"{image.dtype} of shape {image.shape}"}
    return {"planes": [describe(plane, expected, names.split(",")) for plane in numpy.moveaxis(image, 2, 0)], "names": own_names, "type": str(image.dtype)}


if __name__ == "__main__":
    print(json.dumps(main(*sys.argv[1:])))
