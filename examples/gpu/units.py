#!/usr/bin/env python3
"""Texture units: OpenGL through EGL without a window, CUDA, and an emulation in numpy with filter weights of 8 bits.

    units.py [opengl|cuda|emulated]     says which renderer answers

A unit has one function that all of them share:

    sample(levels, wraps, coordinates, ...)     returns an array (n, 4) of float32

`levels` is a list of (size, texels): the size is a list of one to three numbers, and texels an array (n, 4) in which t0 varies fastest.
`wraps` has one of repeat, mirror, edge and border for each direction. OpenGL needs moderngl, libEGL and libGL (Mesa's llvmpipe is enough:
apt-get install libegl1 libgl1 libgl1-mesa-dri), CUDA needs CuPy and an NVIDIA GPU. If something is missing, the program ends with status
77 and says what.
"""

import ctypes
import itertools
import math
import sys

try:
    import numpy
except ImportError:
    print("skipped: numpy is not installed", file=sys.stderr)
    sys.exit(77)

# In OpenGL: internal format, format, type and components of the texels
FORMATS = {
    "r8": (0x8229, 0x1903, 0x1401, 1),
    "rgba8": (0x8058, 0x1908, 0x1401, 4),
    "r32f": (0x822E, 0x1903, 0x1406, 1),
    "rgba16f": (0x881A, 0x1908, 0x1406, 4),
    "rgba32f": (0x8814, 0x1908, 0x1406, 4),
}


class Missing(Exception):
    """A package, a library or a device is missing."""


def make(name):
    return {"opengl": OpenGL, "cuda": Cuda, "emulated": Emulated}[name]()


def or_skip(make_it, *arguments):
    """Returns what a function returns. Ends the program with status 77 if something is missing."""
    try:
        return make_it(*arguments)
    except Missing as what:
        print("skipped:", what, file=sys.stderr)
        sys.exit(77)


def rgba(texels):
    """Returns texels of one to four components as an array (n, 4); alpha is 1."""
    result = numpy.zeros((len(texels), 4))
    result[:, 3] = 1
    for row, texel in zip(result, texels):
        row[:len(texel)] = texel
    return result


def stored(texels, bytes_):
    """Returns texels as a texture holds them: bytes, or 32-bit floating-point numbers."""
    if bytes_:
        return numpy.ascontiguousarray(numpy.floor(numpy.clip(texels, 0, 1) * 255 + 0.5).astype(numpy.uint8))
    return numpy.ascontiguousarray(texels, numpy.float32)


# OpenGL


def create_context(version=430):
    try:
        import moderngl
    except ImportError:
        raise Missing("moderngl is not installed") from None
    problem = None
    for libraries in {"libgl": "libGL.so.1", "libegl": "libEGL.so.1"}, {"libgl": "libOpenGL.so.0", "libegl": "libEGL.so.1"}, {}:
        try:
            return moderngl.create_context(standalone=True, backend="egl", require=version, **libraries)
        except Exception as what:                    # moderngl raises plain exceptions
            problem = problem or what
    raise Missing(f"EGL gives no context of OpenGL {version / 100:.1f}: {problem}")


class OpenGL:
    WRAPS = {"repeat": 0x2901, "mirror": 0x8370, "edge": 0x812F, "border": 0x812D}
    TARGETS = {1: 0x0DE0, 2: 0x0DE1, 3: 0x806F}
    SAMPLERS = {1: ("sampler1D", "x"), 2: ("sampler2D", "xy"), 3: ("sampler3D", "xyz")}

    def __init__(self):
        self.context = create_context()
        self.egl = ctypes.CDLL("libEGL.so.1")
        self.egl.eglGetProcAddress.restype = ctypes.c_void_p
        self.programs = {}
        self.call("glPixelStorei", 0x0CF5, 1)        # rows are not padded, in either direction
        self.call("glPixelStorei", 0x0D05, 1)

    def call(self, name, *arguments):
        """Calls a function of OpenGL with integers, real numbers (as c_float) and arrays."""
        address = self.egl.eglGetProcAddress(name.encode())
        converted = [a.ctypes.data_as(ctypes.c_void_p) if isinstance(a, numpy.ndarray) else a if isinstance(a, ctypes._SimpleCData) else ctypes.c_int(a)
                     for a in arguments]
        ctypes.CFUNCTYPE(None, *map(type, converted))(address)(*converted)

    def describe(self):
        return f"{self.context.info['GL_RENDERER']}, OpenGL {self.context.info['GL_VERSION']}"

    def texture(self, levels, format, wraps, linear, mipmap, border, bias=0.0):
        internal, layout, kind, components = FORMATS[format]
        size = levels[0][0]
        target = self.TARGETS[len(size)]
        name = numpy.zeros(1, numpy.uint32)
        self.call("glGenTextures", 1, name)
        self.call("glActiveTexture", 0x84C0)
        self.call("glBindTexture", target, int(name[0]))
        for number, (size, texels) in enumerate(levels):
            data = stored(numpy.asarray(texels, float).reshape(-1, 4)[:, :components], kind == 0x1401)
            self.call(f"glTexImage{len(size)}D", target, number, internal, *size, 0, layout, kind, data)
        for direction, wrap in zip((0x2802, 0x2803, 0x8072), wraps):
            self.call("glTexParameteri", target, direction, self.WRAPS[wrap])
        filter = 0x2601 if linear else 0x2600
        between = {"none": filter, "nearest": filter + 0x100, "linear": filter + 0x102}[mipmap]
        self.call("glTexParameteri", target, 0x2800, filter)
        self.call("glTexParameteri", target, 0x2801, between)
        self.call("glTexParameteri", target, 0x813D, len(levels) - 1)
        self.call("glTexParameterfv", target, 0x1004, numpy.array(border, numpy.float32))
        self.call("glTexParameterf", target, 0x8501, ctypes.c_float(bias))
        return target, name

    def bind(self, texture):
        self.call("glActiveTexture", 0x84C0)
        self.call("glBindTexture", texture[0], int(texture[1][0]))

    def free(self, texture):
        self.call("glDeleteTextures", 1, texture[1])

    def sample(self, levels, wraps, coordinates, format="rgba32f", linear=False, mipmap="none", border=(0, 0, 0, 0), level=0.0, gradients=None):
        """Samples at a level, or at the one that follows from gradients: two arrays like the coordinates."""
        coordinates = numpy.asarray(coordinates, numpy.float32)
        count, dimensions = coordinates.shape
        inputs = [numpy.zeros((count, 4), numpy.float32) for _ in range(1 if gradients is None else 3)]
        for buffer, values in zip(inputs, [coordinates, *(gradients or [])]):
            buffer[:, :dimensions] = values
        inputs[0][:, 3] = level
        program = self.sampling_program(dimensions, gradients is not None)
        program["count"] = count
        buffers = [self.context.buffer(values.tobytes()) for values in inputs] + [self.context.buffer(reserve=16 * count)]
        for slot, buffer in zip((0, 2, 3) if gradients is not None else (0,), buffers):
            buffer.bind_to_storage_buffer(slot)
        buffers[-1].bind_to_storage_buffer(1)
        texture = self.texture(levels, format, wraps, linear, mipmap, border)
        program.run((count + 63) // 64)
        self.context.memory_barrier()
        self.call("glFinish")
        result = numpy.frombuffer(buffers[-1].read(), numpy.float32).reshape(count, 4).copy()
        for buffer in buffers:
            buffer.release()
        self.free(texture)
        return result

    def sampling_program(self, dimensions, has_gradients):
        key = dimensions, has_gradients
        if key not in self.programs:
            sampler, part = self.SAMPLERS[dimensions]
            more = "".join(f"layout(std430, binding={n}) readonly buffer D{n} {{ vec4 d{n}[]; }};\n" for n in (2, 3)) if has_gradients else ""
            look_up = f"textureGrad(image, at[i].{part}, d2[i].{part}, d3[i].{part})" if has_gradients else f"textureLod(image, at[i].{part}, at[i].w)"
            self.programs[key] = self.context.compute_shader(f"""#version 430
                layout(local_size_x=64) in;
                layout(binding=0) uniform {sampler} image;
                uniform int count;
                layout(std430, binding=0) readonly buffer A {{ vec4 at[]; }};
                layout(std430, binding=1) buffer R {{ vec4 result[]; }};
                {more}void main() {{ uint i = gl_GlobalInvocationID.x; if (i < uint(count)) result[i] = {look_up}; }}""")
        return self.programs[key]

    def half(self, size, texels, format):
        """Returns the size and the texels of the next level, as glGenerateMipmap makes it."""
        texture = self.texture([(size, texels)], format, ["edge"] * 3, False, "none", (0, 0, 0, 0))
        self.call("glTexParameteri", texture[0], 0x813D, 1000)
        self.call("glGenerateMipmap", texture[0])
        size = [max(1, n // 2) for n in size]
        result = numpy.zeros((math.prod(size), 4), numpy.float32)
        self.call("glGetTexImage", texture[0], 1, 0x1908, 0x1406, result)
        self.free(texture)
        return size, result

    def depth(self, size, dx, dy, bias=0.0):
        """Returns the second number of textureQueryLod: the depth, with its bias, that is not clamped."""
        dimensions = len(size)
        levels, sides = [], list(size)
        while True:
            levels.append((list(sides), rgba([[len(levels)]] * math.prod(sides))))
            if max(sides) == 1:
                break
            sides = [max(1, n // 2) for n in sides]
        if dimensions not in self.programs:
            sampler, part = self.SAMPLERS[dimensions]
            program = self.context.program(
                vertex_shader="#version 430\nvoid main() { gl_Position = vec4(vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4.0 - 1.0, 0, 1); }",
                fragment_shader=f"""#version 430
                    layout(binding=0) uniform {sampler} image;
                    uniform vec3 dx, dy;
                    out vec4 result;
                    void main() {{
                        vec3 at = vec3(0.5) + dx * (gl_FragCoord.x - 4.0) + dy * (gl_FragCoord.y - 4.0);
                        result = vec4(textureQueryLod(image, at.{part}), texture(image, at.{part}).r, 1);
                    }}""")
            target = self.context.framebuffer([self.context.texture((8, 8), 4, dtype="f4")])
            self.programs[dimensions] = program, self.context.vertex_array(program, []), target
        program, vertices, target = self.programs[dimensions]
        target.use()
        program["dx"], program["dy"] = [tuple([*values, 0.0, 0.0])[:3] for values in (dx, dy)]
        texture = self.texture(levels, "r32f", ["repeat"] * 3, True, "linear", (0, 0, 0, 0), bias)
        vertices.render(mode=4, vertices=3)
        pixels = numpy.frombuffer(target.read(components=4, dtype="f4"), numpy.float32).reshape(8, 8, 4)
        self.free(texture)
        return float(pixels[4, 4, 1])


# Units that filter within a level; the levels are chosen here.


class Levels:
    def sample(self, levels, wraps, coordinates, format="rgba32f", linear=False, mipmap="none", border=(0, 0, 0, 0), level=0.0):
        coordinates = numpy.asarray(coordinates, numpy.float32)
        take = lambda number: self.sample_level(*levels[number], wraps, coordinates, format, linear, border)
        at = min(max(float(level), 0.0), len(levels) - 1.0)
        if mipmap == "none":
            return take(0)
        if mipmap == "nearest":
            return take(math.ceil(at - 0.5))
        lower = math.floor(at)
        share = at - lower
        return take(lower) * (1 - share) + take(min(lower + 1, len(levels) - 1)) * share


class Cuda(Levels):
    """Texture objects of CUDA."""

    SOURCE = r"""
        extern "C" __global__ void sample(cudaTextureObject_t image, const float* at, float4* result, int count) {
            int i = blockIdx.x * blockDim.x + threadIdx.x;
            if (i >= count) return;
            const float* t = at + 3 * i;
            result[i] = LOOKUP;
        }"""
    LOOKUPS = {1: "tex1D<float4>(image, t[0])", 2: "tex2D<float4>(image, t[0], t[1])", 3: "tex3D<float4>(image, t[0], t[1], t[2])"}

    def __init__(self):
        try:
            import cupy
            self.properties = cupy.cuda.runtime.getDeviceProperties(0)
        except ImportError:
            raise Missing("CuPy is not installed") from None
        except Exception as problem:                 # CuPy raises errors of CUDA
            raise Missing(f"CUDA has no device: {problem}") from None
        self.cupy = cupy
        self.kernels = {n: cupy.RawModule(code=self.SOURCE.replace("LOOKUP", code)).get_function("sample") for n, code in self.LOOKUPS.items()}

    def describe(self):
        return f"{self.properties['name'].decode()}, CuPy {self.cupy.__version__}"

    def sample_level(self, size, texels, wraps, coordinates, format, linear, border):
        cupy, textures, runtime = self.cupy, self.cupy.cuda.texture, self.cupy.cuda.runtime
        bytes_ = format == "rgba8"
        data = stored(numpy.asarray(texels, float).reshape(-1, 4), bytes_)
        kind = runtime.cudaChannelFormatKindUnsigned if bytes_ else runtime.cudaChannelFormatKindFloat
        array = textures.CUDAarray(textures.ChannelFormatDescriptor(*[8 if bytes_ else 32] * 4, kind), *size)
        array.copy_from(data.reshape([*size[:0:-1], 4 * size[0]]))
        modes = {"repeat": runtime.cudaAddressModeWrap, "mirror": runtime.cudaAddressModeMirror, "edge": runtime.cudaAddressModeClamp,
                 "border": runtime.cudaAddressModeBorder}
        description = textures.TextureDescriptor(
            [modes[wrap] for wrap in ([*wraps] + ["edge"] * 2)[:3]], runtime.cudaFilterModeLinear if linear else runtime.cudaFilterModePoint,
            runtime.cudaReadModeNormalizedFloat if bytes_ else runtime.cudaReadModeElementType, None, [*map(float, border)], 1, 0)
        image = textures.TextureObject(textures.ResourceDescriptor(runtime.cudaResourceTypeArray, cuArr=array), description)
        count = len(coordinates)
        at = numpy.zeros((count, 3), numpy.float32)
        at[:, :len(size)] = coordinates
        result = cupy.zeros((count, 4), cupy.float32)
        self.kernels[len(size)](((count + 127) // 128,), (128,), (image, cupy.asarray(at), result, numpy.int32(count)))
        return cupy.asnumpy(result)


class Emulated(Levels):
    """A filter in float64 whose weights are rounded to the nearest multiple of 1/256, as those of NVIDIA's texture units are."""

    STEPS = 256

    def describe(self):
        return "emulation in numpy, weights that are multiples of 1/256"

    def sample_level(self, size, texels, wraps, coordinates, format, linear, border):
        texels = numpy.asarray(texels, float).reshape(-1, 4)
        if format == "rgba8":
            texels = stored(texels, True) / 255
        return numpy.array([self.sample_one(size, texels, wraps, at, linear, border) for at in coordinates.astype(float)], numpy.float32)

    def sample_one(self, size, texels, wraps, at, linear, border):
        neighbors = []
        for t, n in zip(at, size):
            low = math.floor(t * n - 0.5) if linear else math.floor(t * n)
            weight = math.floor((t * n - 0.5 - low) * self.STEPS + 0.5) / self.STEPS if linear else 0.0
            neighbors.append([(low, 1 - weight), (low + 1, weight)])
        total = numpy.zeros(4)
        for corner in itertools.product(*neighbors):
            weight = math.prod(share for _, share in corner)
            if weight:
                places = [inside(wrap, k, n) for wrap, (k, _), n in zip(wraps, corner, size)]
                texel = border if None in places else texels[sum(k * math.prod(size[:d]) for d, k in enumerate(places))]
                total += weight * numpy.array(texel, float)
        return total


def inside(wrap, k, n):
    """Maps a texel index to one in the texture, or to None in the border."""
    if wrap == "repeat":
        return k % n
    if wrap == "mirror":
        return k % (2 * n) if k % (2 * n) < n else 2 * n - 1 - k % (2 * n)
    if wrap == "edge":
        return min(n - 1, max(0, k))
    return k if 0 <= k < n else None


if __name__ == "__main__":
    print(or_skip(make, sys.argv[1] if len(sys.argv) > 1 else "opengl").describe())
