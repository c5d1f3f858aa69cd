#!/usr/bin/env python3
"""A PTM decoder whose colors come from a fragment shader, as in a viewer. It answers the view rgb of PTM-CP 1.

    ptm_shader.py [--target rgba8|rgba16f|rgba32f] [--truncate] VIEW FILE | serve | capabilities

examples/decoders/ptm_decoder.py reads the file. The stored bytes become textures of RGBA8, and the shader does the rest in single precision:
scale, bias, the polynomial, color, and clamping. It writes to a framebuffer of 8-bit, half or float components. 8-bit components are read
as they are; others are multiplied by 255 and rounded, or truncated with --truncate. Exit status: as ptm_decoder.py, and 77 without OpenGL.
"""

import os
import pathlib
import sys

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "decoders")]
import units
import numpy
import ptm_decoder

SHADER = """#version 330
uniform sampler2DArray stored_bytes;
uniform int channels;
uniform float scale[6];
uniform float bias[6];
uniform mat4 matrix;
uniform vec2 light;
out vec4 color;

float raw(int channel) {
    return texelFetch(stored_bytes, ivec3(gl_FragCoord.xy, channel / 4), 0)[channel % 4] * 255.0;
}

float polynomial(int first) {
    float a[6];
    for (int i = 0; i < 6; i++)
        a[i] = (raw(first + i) - bias[i]) * scale[i];
    return a[0] * light.x * light.x + a[1] * light.y * light.y + a[2] * light.x * light.y + a[3] * light.x + a[4] * light.y + a[5];
}

void main() {
    vec3 value;
    if (channels == 18)
        value = vec3(polynomial(0), polynomial(6), polynomial(12));
    else if (channels == 9)
        value = polynomial(0) * vec3(raw(6), raw(7), raw(8)) / 255.0;
    else
        value = (matrix * vec4(polynomial(0), raw(6), raw(7), 1.0)).rgb;
    color = vec4(clamp(value / 255.0, 0.0, 1.0), 1.0);
}
"""
MAX_SIDE = 4096      # texels are folded into rows, because a map may be larger than a texture


class Renderer:
    def __init__(self, target="rgba8", truncate=False):
        self.kind, self.truncate = {"rgba8": "f1", "rgba16f": "f2", "rgba32f": "f4"}[target], truncate
        self.context = units.create_context(330)
        vertex = "#version 330\nvoid main() { gl_Position = vec4(vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4.0 - 1.0, 0, 1); }"
        self.program = self.context.program(vertex_shader=vertex, fragment_shader=SHADER)
        self.vertices = self.context.vertex_array(self.program, [])

    def describe(self):
        return f"{self.context.info['GL_RENDERER']}, OpenGL {self.context.info['GL_VERSION']}"

    def colors(self, ptm, light):
        """Returns the bytes of an image, as an array (texels, 3)."""
        stored = numpy.frombuffer(b"".join(ptm.texels), numpy.uint8).reshape(len(ptm.texels), -1)
        count, channels = stored.shape
        width = min(count, MAX_SIDE)
        rows, layers = -(-count // width), -(-channels // 4)
        folded = numpy.zeros((rows * width, 4 * layers), numpy.uint8)
        folded[:count, :channels] = stored
        planes = numpy.ascontiguousarray(folded.reshape(rows, width, layers, 4).transpose(2, 0, 1, 3))
        texture = self.context.texture_array((width, rows, layers), 4, planes.tobytes(), alignment=1, dtype="f1")
        texture.use(0)
        values = {"channels": channels, "scale": ptm.scale, "bias": ptm.bias, "light": light, "matrix": ptm.matrix or [0.0] * 16}
        for name, value in values.items():
            if name == "channels":
                self.program[name] = value
            else:
                with numpy.errstate(over="ignore"):
                    self.program[name].write(numpy.array(value, float).astype(numpy.float32).tobytes())
        image = self.context.texture((width, rows), 4, dtype=self.kind)
        target = self.context.framebuffer([image])
        target.use()
        self.vertices.render(mode=4, vertices=3)
        read_as = "f1" if self.kind == "f1" else "f4"
        pixels = numpy.frombuffer(target.read(components=4, alignment=1, dtype=read_as), numpy.uint8 if read_as == "f1" else numpy.float32)
        for used in target, image, texture:
            used.release()
        pixels = pixels.reshape(-1, 4)[:count, :3]
        return pixels if read_as == "f1" else numpy.floor(pixels * 255 + (0 if self.truncate else 0.5)).astype(numpy.uint8)


class Decoder:
    """Replaces the function of ptm_decoder.py that answers a request. It renders with OpenGL from the first request on."""

    def __init__(self, *options):
        self.options, self.renderer = options, None

    def frame(self, view, path):
        name, light = ptm_decoder.parse_view(view)
        if name != b"rgb":
            raise ptm_decoder.Unsupported("view")
        with open(path, "rb") as file:
            ptm = ptm_decoder.read_ptm(file.read())
        self.renderer = self.renderer or units.or_skip(Renderer, *self.options)
        return b"PTM1 rgb %d %d 3 u8\n" % (ptm.width, ptm.height) + self.renderer.colors(ptm, light).tobytes()


def main(arguments):
    target = "rgba8"
    if arguments[:1] == ["--target"]:
        target, arguments = arguments[1], arguments[2:]
    truncate = arguments[:1] == ["--truncate"]
    ptm_decoder.frame = Decoder(target, truncate).frame
    ptm_decoder.CAPABILITIES = ptm_decoder.CAPABILITIES.replace("ptm-decoder-python", "ptm-shader-" + target).replace("raw, coef, rgb", "rgb")
    ptm_decoder.main(arguments[1:] if truncate else arguments)


if __name__ == "__main__":
    main(sys.argv[1:])
