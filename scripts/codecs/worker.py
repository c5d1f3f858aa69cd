"""The Python libraries as plane codecs.

    python worker.py NAME      requests on standard input: "decode BYTES" and a stream, or "encode WIDTH HEIGHT QUALITY BYTES" and samples

Each answer is "ok WIDTH HEIGHT CHANNELS BYTES" and the samples (or 0 0 0 and the stream), or "error TEXT". The workers in other languages
speak the same protocol. Library calls are as short as their documentation shows, because the calls are what is measured.
"""

import io
import os
import sys
import tempfile


def frame_header(stream):
    """Returns (marker, precision, height, width, components) of the first frame header, or None."""
    at = 2
    while at + 9 < len(stream) and stream[at] == 0xFF:
        marker, length = stream[at + 1], int.from_bytes(stream[at + 2:at + 4], "big")
        if marker == 0xFF:
            at += 1
            continue
        if marker == 0xF7 or (0xC0 <= marker <= 0xCF and marker not in (0xC4, 0xC8, 0xCC)):
            size = int.from_bytes(stream[at + 5:at + 7], "big"), int.from_bytes(stream[at + 7:at + 9], "big")
            return marker, stream[at + 4], *size, stream[at + 9]
        at += 2 + length
    return None


def array_answer(array):
    import numpy
    if array is None:
        raise ValueError("no image")
    array = numpy.asarray(array)
    if array.dtype != numpy.uint8:
        if array.max(initial=0) > 255:
            raise ValueError("samples above 255 of type %s" % array.dtype)
        array = array.astype(numpy.uint8)
    height, width = array.shape[:2]
    return width, height, array.size // (width * height), array.tobytes()


def gray(samples, width, height):
    import numpy
    return numpy.frombuffer(samples, numpy.uint8).reshape(height, width)


def pillow(stream):
    from PIL import Image
    image = Image.open(io.BytesIO(stream), formats=["JPEG"])
    return *image.size, len(image.getbands()), image.tobytes()


def pillow_encode(samples, width, height, quality):
    from PIL import Image
    out = io.BytesIO()
    Image.frombytes("L", (width, height), samples).save(out, "JPEG", quality=quality)
    return out.getvalue()


def pillow_restart_encode(samples, width, height, quality):
    from PIL import Image
    out = io.BytesIO()
    Image.frombytes("L", (width, height), samples).save(out, "JPEG", quality=quality, restart_marker_blocks=2)
    return out.getvalue()


def pillow_color_encode(samples, width, height, quality):
    from PIL import Image
    out = io.BytesIO()
    Image.frombytes("L", (width, height), samples).convert("RGB").save(out, "JPEG", quality=quality)
    return out.getvalue()


def opencv(flag):
    def decode(stream):
        import cv2
        import numpy
        return array_answer(cv2.imdecode(numpy.frombuffer(stream, numpy.uint8), getattr(cv2, flag)))
    return decode


def opencv_encode(samples, width, height, quality):
    import cv2
    return cv2.imencode(".jpg", gray(samples, width, height), [cv2.IMWRITE_JPEG_QUALITY, quality])[1].tobytes()


def pyav(codec):
    def decode(stream):
        import av
        context = av.CodecContext.create(codec, "r")
        frames = context.decode(av.Packet(stream)) + context.decode(None)
        frame = frames[0]
        if frame.format.name != "gray":
            return array_answer(frame.to_ndarray(format="rgb24"))
        plane = frame.planes[0]
        rows, step = bytes(plane), plane.line_size
        samples = b"".join(rows[y * step:y * step + frame.width] for y in range(frame.height))
        return frame.width, frame.height, 1, samples
    return decode


def pyav_encode(codec, pixels):
    def encode(samples, width, height, quality):
        import av
        from fractions import Fraction
        frame = av.VideoFrame.from_ndarray(gray(samples, width, height), format="gray").reformat(format=pixels)
        frame.pts, frame.time_base = 0, Fraction(1, 25)
        context = av.CodecContext.create(codec, "w")
        context.width, context.height, context.pix_fmt, context.time_base = width, height, pixels, Fraction(1, 25)
        return b"".join(bytes(packet) for packet in context.encode(frame) + context.encode(None))
    return encode


def imagecodecs_jpeg(stream):
    import imagecodecs
    return array_answer(imagecodecs.jpeg_decode(stream))


def imagecodecs_jpeg_encode(samples, width, height, quality):
    import imagecodecs
    return imagecodecs.jpeg_encode(gray(samples, width, height), level=quality)


def imagecodecs_jpegls(stream):
    import imagecodecs
    return array_answer(imagecodecs.jpegls_decode(stream))


def imagecodecs_jpegls_encode(samples, width, height, quality):
    import imagecodecs
    return imagecodecs.jpegls_encode(gray(samples, width, height))


def simplejpeg(**options):
    def decode(stream):
        import simplejpeg
        return array_answer(simplejpeg.decode_jpeg(stream, "GRAY", **options))
    return decode


def simplejpeg_encode(samples, width, height, quality):
    import simplejpeg
    return simplejpeg.encode_jpeg(gray(samples, width, height).reshape(height, width, 1), quality, "GRAY", "Gray")


def libjpeg(stream):
    import libjpeg
    return array_answer(libjpeg.decode(stream))


def gdcm(stream):
    """Wraps the stream as a DICOM file, the only form that GDCM reads."""
    import gdcm
    header = frame_header(stream)
    if header is None:
        raise ValueError("no frame header")
    marker, precision, height, width, components = header
    syntax = {0xC0: "1.2.840.10008.1.2.4.50", 0xF7: "1.2.840.10008.1.2.4.81"}.get(marker, "1.2.840.10008.1.2.4.51")

    def element(group, number, kind, value):
        value += b"\0" * (len(value) % 2) if kind in (b"UI", b"OB") else b" " * (len(value) % 2)
        length = len(value).to_bytes(4, "little") if kind == b"OB" else len(value).to_bytes(2, "little")
        return group.to_bytes(2, "little") + number.to_bytes(2, "little") + kind + (b"\0\0" if kind == b"OB" else b"") + length + value

    def short(number):
        return number.to_bytes(2, "little")

    uid = b"1.2.826.0.1.3680043.2.1125.1"
    secondary = b"1.2.840.10008.5.1.4.1.1.7"
    meta = (element(2, 1, b"OB", b"\0\1") + element(2, 2, b"UI", secondary) + element(2, 3, b"UI", uid)
            + element(2, 0x10, b"UI", syntax.encode()) + element(2, 0x12, b"UI", uid))
    bits = precision if marker == 0xF7 else 8
    values = (element(8, 0x16, b"UI", secondary) + element(8, 0x18, b"UI", uid)
              + element(0x28, 2, b"US", short(1)) + element(0x28, 4, b"CS", b"MONOCHROME2")
              + element(0x28, 0x10, b"US", short(height)) + element(0x28, 0x11, b"US", short(width))
              + element(0x28, 0x100, b"US", short(8)) + element(0x28, 0x101, b"US", short(bits))
              + element(0x28, 0x102, b"US", short(bits - 1)) + element(0x28, 0x103, b"US", short(0)))
    item = b"\xfe\xff\x00\xe0"
    data = stream + b"\0" * (len(stream) % 2)
    pixels = (b"\xe0\x7f\x10\x00OB\0\0\xff\xff\xff\xff" + item + bytes(4) + item + len(data).to_bytes(4, "little") + data
              + b"\xfe\xff\xdd\xe0" + bytes(4))
    with tempfile.NamedTemporaryFile(suffix=".dcm") as file:
        group = b"\2\0\0\0UL\4\0" + len(meta).to_bytes(4, "little")
        file.write(bytes(128) + b"DICM" + group + meta + values + pixels)
        file.flush()
        reader = gdcm.ImageReader()
        reader.SetFileName(file.name)
        if not reader.Read():
            raise ValueError("GDCM does not read the file")
        buffer = reader.GetImage().GetBuffer()
    samples = buffer.encode("utf-8", "surrogateescape") if isinstance(buffer, str) else bytes(buffer)
    if len(samples) != width * height:
        raise ValueError("GDCM returns %d samples" % len(samples))
    return width, height, 1, samples


def imageio(stream):
    import imageio.v3
    return array_answer(imageio.v3.imread(stream, extension=".jpg"))


def imageio_encode(samples, width, height, quality):
    import imageio.v3
    return imageio.v3.imwrite("<bytes>", gray(samples, width, height), extension=".jpg", quality=quality)


def scikit_image(stream):
    import skimage.io
    with tempfile.NamedTemporaryFile(suffix=".jpg") as file:
        file.write(stream)
        file.flush()
        return array_answer(skimage.io.imread(file.name))


def pyvips(stream):
    import pyvips
    image = pyvips.Image.new_from_buffer(stream, "")
    return image.width, image.height, image.bands, bytes(image.write_to_memory())


def pyvips_encode(samples, width, height, quality):
    import pyvips
    return pyvips.Image.new_from_memory(samples, width, height, 1, "uchar").jpegsave_buffer(Q=quality)


def jpeglib(version):
    def decode(stream):
        import jpeglib
        jpeglib.version.set(version)
        with tempfile.NamedTemporaryFile(suffix=".jpg") as file:
            file.write(stream)
            file.flush()
            return array_answer(jpeglib.read_spatial(file.name).spatial)
    return decode


def jpeglib_encode(version):
    def encode(samples, width, height, quality):
        import jpeglib
        jpeglib.version.set(version)
        with tempfile.NamedTemporaryFile(suffix=".jpg") as file:
            image = jpeglib.from_spatial(gray(samples, width, height).reshape(height, width, 1).copy())
            image.write_spatial(file.name, qt=quality)
            return open(file.name, "rb").read()
    return encode


def pyjpegls(stream):
    import jpeg_ls
    import numpy
    return array_answer(jpeg_ls.decode(numpy.frombuffer(stream, numpy.uint8)))


def pyjpegls_encode(samples, width, height, quality):
    import jpeg_ls
    return bytes(jpeg_ls.encode(gray(samples, width, height)))


def pillow_jpls(open_image):
    def decode(stream):
        import pillow_jpls
        from PIL import Image
        stream = io.BytesIO(stream)
        image = Image.open(stream, formats=["JPEG-LS"]) if open_image else pillow_jpls.JplsImageFile(stream)
        return *image.size, len(image.getbands()), image.tobytes()
    return decode


def pillow_jpls_encode(samples, width, height, quality):
    import pillow_jpls
    from PIL import Image
    out = io.BytesIO()
    Image.frombytes("L", (width, height), samples).save(out, "JPEG-LS")
    return out.getvalue()


def cft_jpegls(stream):
    import cft_jpegls
    return array_answer(cft_jpegls.decode(stream))


CODECS = {
    "pillow": (pillow, pillow_encode),
    "pillow-restart": (None, pillow_restart_encode),
    "pillow-color": (None, pillow_color_encode),
    "opencv-grayscale": (opencv("IMREAD_GRAYSCALE"), opencv_encode),
    "opencv-unchanged": (opencv("IMREAD_UNCHANGED"), None),
    "pyav": (pyav("mjpeg"), pyav_encode("mjpeg", "yuvj444p")),
    "imagecodecs": (imagecodecs_jpeg, imagecodecs_jpeg_encode),
    "simplejpeg": (simplejpeg(), simplejpeg_encode),
    "simplejpeg-fastdct": (simplejpeg(fastdct=True), None),
    "pylibjpeg-libjpeg": (libjpeg, None),
    "gdcm": (gdcm, None),
    "imageio": (imageio, imageio_encode),
    "scikit-image": (scikit_image, None),
    "pyvips": (pyvips, pyvips_encode),
    "jpeglib-6b": (jpeglib("6b"), jpeglib_encode("6b")),
    "jpeglib-9f": (jpeglib("9f"), jpeglib_encode("9f")),
    "jpeglib-turbo": (jpeglib("turbo210"), jpeglib_encode("turbo210")),
    "jpeglib-mozjpeg": (jpeglib("mozjpeg403"), jpeglib_encode("mozjpeg403")),
    "ls-imagecodecs": (imagecodecs_jpegls, imagecodecs_jpegls_encode),
    "ls-pyjpegls": (pyjpegls, pyjpegls_encode),
    "ls-pillow-jpls": (pillow_jpls(False), pillow_jpls_encode),
    "ls-pillow-jpls-open": (pillow_jpls(True), None),
    "ls-pyav": (pyav("jpegls"), pyav_encode("jpegls", "gray")),
    "ls-pylibjpeg-libjpeg": (libjpeg, None),
    "ls-gdcm": (gdcm, None),
    "ls-cft-jpegls": (cft_jpegls, None),
}


def main(name):
    decode, encode = CODECS[name]
    source, answers = sys.stdin.buffer, os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)                                   # libraries print to standard output
    for line in source:
        request, *numbers = line.split()
        numbers = [int(number) for number in numbers]
        body = source.read(numbers[-1])
        try:
            if request == b"decode":
                width, height, channels, result = decode(body)
            else:
                width = height = channels = 0
                result = encode(body, *numbers[:3])
            answers.write(b"ok %d %d %d %d\n" % (width, height, channels, len(result)) + bytes(result))
        except Exception as problem:                # libraries raise any exception
            text = " ".join(f"{type(problem).__name__}: {problem}".split())[:200]
            answers.write(b"error " + text.encode("ascii", "replace") + b"\n")
        answers.flush()


if __name__ == "__main__":
    main(sys.argv[1])
