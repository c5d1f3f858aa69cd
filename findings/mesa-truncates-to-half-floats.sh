#!/usr/bin/env bash
# finding: Mesa's software renderers truncate the numbers that they store in RGBA16F textures and framebuffers, instead of rounding to the nearest.
# software: numpy 2.4.6, moderngl 5.13.0, Mesa 22.3.6 (llvmpipe and softpipe of Debian 12: libegl1, libgl1, libgl1-mesa-dri)
# expected: 0.300049, the half-precision number closest to 0.3, as numpy.float16(0.3).
# observed: numpy: 0.300049
# observed: llvmpipe: 0.299805 from a texture, 0.299805 from a framebuffer
# observed: softpipe: 0.299805 from a texture, 0.299805 from a framebuffer
. "$(dirname "$0")/tools.sh"
python_packages numpy==2.4.6 moderngl==5.13.0
export LIBGL_ALWAYS_SOFTWARE=1 MESA_GL_VERSION_OVERRIDE=4.5 MESA_GLSL_VERSION_OVERRIDE=450
cd "$work"
cat > run.py <<'PYTHON'
import sys
import moderngl, numpy

context = moderngl.create_context(standalone=True, backend="egl", libgl="libGL.so.1", libegl="libEGL.so.1")
assert sys.argv[1] in context.info["GL_RENDERER"]
RGBA16F = 0x881A
value = numpy.full(4, 0.3, "f4")
texture = context.texture((1, 1), 4, value.tobytes(), dtype="f4", internal_format=RGBA16F)
texture.filter = moderngl.NEAREST, moderngl.NEAREST
texture.use(0)
vertex = "#version 330\nvoid main() { gl_Position = vec4(vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4.0 - 1.0, 0, 1); }"


def draw(expression, kind):
    program = context.program(vertex_shader=vertex, fragment_shader="#version 330\nuniform sampler2D image; uniform vec4 value; out vec4 color; void main() { color = " + expression + "; }")
    if "value" in program:
        program["value"].write(value.tobytes())
    target = context.framebuffer([context.texture((1, 1), 4, dtype=kind)])
    target.use()
    context.vertex_array(program, []).render(mode=moderngl.TRIANGLES, vertices=3)
    return numpy.frombuffer(target.read(components=4, dtype="f4"), "f4")[0]


print(f"{sys.argv[1]}: {draw('texture(image, vec2(0.5))', 'f4'):.6f} from a texture, {draw('value', 'f2'):.6f} from a framebuffer")
PYTHON
"$python" -c 'import numpy; print(f"numpy: {numpy.float16(0.3):.6f}")' > lines
for driver in llvmpipe softpipe; do
    GALLIUM_DRIVER=$driver "$python" run.py $driver >> lines 2> errors || missing "EGL gives no context of $driver: $(tail -n 1 errors)"
done
confirm < lines
