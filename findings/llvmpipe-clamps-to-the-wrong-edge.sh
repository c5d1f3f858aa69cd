#!/usr/bin/env bash
# finding: With GL_CLAMP_TO_EDGE and GL_NEAREST, llvmpipe returns the first texel instead of the last if s times the width is 2^31 or more.
# software: numpy 2.4.6, moderngl 5.13.0, Mesa 22.3.6 (llvmpipe of Debian 12: libegl1, libgl1, libgl1-mesa-dri)
# expected: the last texel, 40, for every s of 1 or more.
# observed: s = 1: 40
# observed: s = 5e8: 40
# observed: s = 5.4e8: 10
# observed: s = 3e9: 10
# observed: s = inf: 10
. "$(dirname "$0")/tools.sh"
python_packages numpy==2.4.6 moderngl==5.13.0
export GALLIUM_DRIVER=llvmpipe LIBGL_ALWAYS_SOFTWARE=1
cd "$work"
cat > run.py <<'PYTHON'
import moderngl, numpy

context = moderngl.create_context(standalone=True, backend="egl", libgl="libGL.so.1", libegl="libEGL.so.1")
assert "llvmpipe" in context.info["GL_RENDERER"]
texture = context.texture((4, 1), 1, numpy.array([10, 20, 30, 40], "f4").tobytes(), dtype="f4")
texture.filter = moderngl.NEAREST, moderngl.NEAREST
texture.repeat_x = False                            # GL_CLAMP_TO_EDGE
texture.use(0)
program = context.program(
    vertex_shader="#version 330\nvoid main() { gl_Position = vec4(vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4.0 - 1.0, 0, 1); }",
    fragment_shader="#version 330\nuniform sampler2D image; uniform float s; out float value; void main() { value = texture(image, vec2(s, 0.5)).r; }")
target = context.framebuffer([context.texture((1, 1), 1, dtype="f4")])
target.use()
vertices = context.vertex_array(program, [])
for s in "1", "5e8", "5.4e8", "3e9", "inf":
    program["s"] = float(s)
    vertices.render(mode=moderngl.TRIANGLES, vertices=3)
    print(f"s = {s}: {numpy.frombuffer(target.read(components=1, dtype='f4'), 'f4')[0]:g}")
PYTHON
"$python" run.py > lines 2> errors || missing "EGL gives no context of llvmpipe: $(tail -n 1 errors)"
confirm < lines
