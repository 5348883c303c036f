"""Compilers of each language take what `lobe export shader` writes, and devices compute the numbers of the library with it.

    python shaders.py target/release/lobe [CASES.json]
"""

import json
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import wgpu

from functions import Function

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent

# Of the largest number of a row, or of 1: what the test of lobe-gpu allows.
OFF = 1e-5


def ran(*command, **options):
    """The output of a program, whose complaint is an error of ours."""
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True, **options)
    if done.returncode != 0:
        raise RuntimeError(f"{Path(command[0]).name}: {(done.stderr + done.stdout).strip()[:2000]}")
    return done.stdout


def made_cases(folder):
    """What functions take and what the library makes of it, as the test of lobe-gpu has them."""
    path = folder / "cases.json"
    ran("cargo", "test", "--quiet", "--package", "lobe-gpu", "--test", "all", "shader_function", cwd=ROOT,
        env=os.environ | {"LOBE_SHADER_CASES": str(path)})
    return path


class Device:
    """Compute programs of two storage buffers on the first adapter that there is."""

    def __init__(self):
        adapter = wgpu.gpu.request_adapter_sync(power_preference="high-performance")
        self.name = adapter.summary
        self.device = adapter.request_device_sync()

    def run(self, code, given, count):
        device = self.device
        module = device.create_shader_module(code=code)
        usage = wgpu.BufferUsage
        arguments = device.create_buffer_with_data(data=given, usage=usage.STORAGE)
        results = device.create_buffer(size=4 * count, usage=usage.STORAGE | usage.COPY_SRC)
        kinds = [(0, "read-only-storage"), (1, "storage")]
        entries = [{"binding": k, "visibility": wgpu.ShaderStage.COMPUTE, "buffer": {"type": ty}} for k, ty in kinds]
        layout = device.create_bind_group_layout(entries=entries)
        group = device.create_bind_group(layout=layout, entries=[
            {"binding": k, "resource": {"buffer": buffer}} for k, buffer in enumerate([arguments, results])])
        pipeline = device.create_compute_pipeline(
            layout=device.create_pipeline_layout(bind_group_layouts=[layout]),
            compute={"module": module, "entry_point": "main"})
        encoder = device.create_command_encoder()
        work = encoder.begin_compute_pass()
        work.set_pipeline(pipeline)
        work.set_bind_group(0, group)
        work.dispatch_workgroups(-(-count // 64))
        work.end()
        device.queue.submit([encoder.finish()])
        return np.frombuffer(device.queue.read_buffer(results), np.float32)


class Check:
    """The functions in a folder, their cases, and the table of what came of them."""

    def __init__(self, lobe, cases, folder):
        self.folder = folder
        ran(lobe, "export", "shader", "all", "--lang", "wgsl,glsl,hlsl,msl,spirv", "-o", folder)
        self.text = {e: (folder / f"lobe.{e}").read_text() for e in ["wgsl", "glsl", "hlsl", "metal"]}
        rows = json.loads(cases.read_text())
        names = [line.split()[0] for line in ran(lobe, "export", "shader").splitlines()]
        self.functions = [Function(self.text["wgsl"], name) for name in names]
        self.given = {n: np.array([row[0] for row in rows[n]], np.float32) for n in names}
        self.expected = {n: np.array([row[1] for row in rows[n]], np.float64) for n in names}
        self.faults = 0

    def say(self, what, by, answer):
        print(f"{what:28} {by:34} {answer}", flush=True)

    def step(self, what, by, work):
        try:
            self.say(what, by, work())
        except Exception as error:  # Each line of the table is a judgment of its own.
            self.faults += 1
            self.say(what, by, f"FAILED: {error}")

    def off(self, found):
        """The largest difference of what `found(function)` computes, in words; an error where it is too large."""
        worst = (0.0, "")
        for function in self.functions:
            expected = self.expected[function.name]
            numbers = np.asarray(found(function), np.float64).reshape(expected.shape)
            scale = np.maximum(np.abs(expected).max(axis=1, keepdims=True), 1.0)
            largest = float(np.nan_to_num(np.abs(numbers - expected) / scale, nan=np.inf).max())
            if largest > OFF:
                raise RuntimeError(f"{function.name}: off by {largest:.1e}")
            worst = max(worst, (largest, function.name))
        return f"{len(self.functions)} functions, at most {worst[0]:.1e} off ({worst[1]})"

    def on(self, device, code):
        def found(function):
            given = self.given[function.name]
            numbers = device.run(code(function), given, len(given) * function.found)
            return numbers[:len(given) * function.found]

        return lambda: self.off(found)

    def wgsl(self, function):
        body = function.call("wgsl", lambda k: f"given[first + {k}u]", lambda k, v: f"results[row * {function.found}u + {k}u] = {v};")
        return (f"{self.text['wgsl']}\n@group(0) @binding(0) var<storage, read> given: array<f32>;\n"
                "@group(0) @binding(1) var<storage, read_write> results: array<f32>;\n\n"
                "@compute @workgroup_size(64)\nfn main(@builtin(global_invocation_id) id: vec3u) {\n"
                f"  let row = id.x;\n  let first = row * {function.given}u;\n"
                f"  if (row + 1u) * {function.found}u > arrayLength(&results) {{ return; }}\n  {body}\n}}\n")

    def glsl_compute(self, function):
        body = function.call("glsl", lambda k: f"given[first + {k}]", lambda k, v: f"results[row * {function.found} + {k}] = {v};")
        return (f"#version 450\n{self.text['glsl']}\nlayout(local_size_x = 64) in;\n"
                "layout(std430, set = 0, binding = 0) readonly buffer Given { float given[]; };\n"
                "layout(std430, set = 0, binding = 1) buffer Results { float results[]; };\n"
                f"void main() {{\n  int row = int(gl_GlobalInvocationID.x), first = row * {function.given};\n"
                f"  if ((row + 1) * {function.found} > results.length()) return;\n  {body}\n}}\n")

    def hlsl_compute(self, function):
        body = function.call("hlsl", lambda k: f"given[first + {k}]", lambda k, v: f"results[row * {function.found} + {k}] = {v};")
        return (f"{self.text['hlsl']}\n[[vk::binding(0, 0)]] StructuredBuffer<float> given;\n"
                "[[vk::binding(1, 0)]] RWStructuredBuffer<float> results;\n"
                f"[numthreads(64, 1, 1)]\nvoid main(uint3 id : SV_DispatchThreadID) {{\n  int row = id.x, first = row * {function.given};\n"
                f"  if (row >= {len(self.given[function.name])}) return;\n  {body}\n}}\n")

    def by_glslang(self, ending, text, *options):
        def code(function):
            source, module = self.folder / f"program.{ending}", self.folder / "program.spv"
            source.write_text(text(function))
            ran("glslangValidator", *options, "-V", source, "-o", module)
            ran("spirv-val", "--target-env", "vulkan1.1", module)
            return module.read_bytes()

        return code

    def in_every_version(self):
        for version, precision in [("300 es", "precision highp float;"), ("310 es", "precision highp float;"), ("330", ""), ("450", "")]:
            path = self.folder / "library.frag"
            end = "layout(location = 0) out vec4 color;\nvoid main() { color = vec4(0.0); }\n"
            path.write_text(f"#version {version}\n{precision}\n{self.text['glsl']}\n{end}")
            ran("glslangValidator", path)
        return "300 es, 310 es, 330, 450"

    def by_tint(self):
        path = self.folder / "program.wgsl"
        path.write_text(self.wgsl(self.functions[0]))
        ran("tint", "--format", "wgsl", path)
        return "the whole text"

    def spirv_is_valid(self):
        files = sorted(self.folder.glob("*_*.spv"))
        for path in files:
            ran("spirv-val", "--target-env", "vulkan1.1", path)
        return f"{len(files)} modules"

    def metal(self):
        """The Metal text compiled as C++ and run on the processor."""
        text = [self.text["metal"], "#include <cstdio>"]
        for function in self.functions:
            body = function.call("msl", lambda k: f"given[{k}]", lambda k, v: f"results[{k}] = {v};")
            text.append(f"void call_{function.name}(const float *given, float *results) {{\n  {body}\n}}")
        calls = [f'run("{f.name}", call_{f.name}, {f.given}, {f.found});' for f in self.functions]
        text.append("""
#include <string>
#include <vector>
void run(std::string name, void (*call)(const float *, float *), int given, int found) {
  FILE *in = fopen((name + ".given").c_str(), "rb"), *out = fopen((name + ".found").c_str(), "wb");
  std::vector<float> row(given), results(found);
  while (fread(row.data(), 4, given, in) == (size_t)given) {
    call(row.data(), results.data());
    fwrite(results.data(), 4, found, out);
  }
  fclose(in), fclose(out);
}""")
        text.append("int main() {\n  " + "\n  ".join(calls) + "\n}\n")
        source = self.folder / "metal.cpp"
        source.write_text("\n".join(text))
        # Numbers of Metal are of single precision.
        ran("clang++", "-Xclang", "-cl-single-precision-constant", "-std=c++17", "-O1", "-Wall", "-Werror", f"-I{HERE}", source, "-o", self.folder / "metal")
        for function in self.functions:
            self.given[function.name].tofile(self.folder / f"{function.name}.given")
        ran(self.folder / "metal", cwd=self.folder)
        return self.off(lambda f: np.fromfile(self.folder / f"{f.name}.found", np.float32))

    def webgl(self):
        """GLSL ES 300 in WebGL 2: a pixel for each number of a row."""
        programs = []
        for function in self.functions:
            body = function.call("glsl", lambda k: f"texelFetch(given, ivec2({k}, row), 0).x", lambda k, v: f"results[{k}] = {v};")
            programs.append({
                "name": function.name, "given": function.given, "found": function.found, "rows": len(self.given[function.name]),
                "source": f"#version 300 es\nprecision highp float;\nprecision highp int;\n{self.text['glsl']}\n"
                          "uniform highp sampler2D given;\nout vec4 color;\nvoid main() {\n  int row = int(gl_FragCoord.y);\n"
                          f"  float results[{function.found}];\n  {body}\n  color = vec4(results[int(gl_FragCoord.x)]);\n}}\n",
                "numbers": self.given[function.name].ravel().tolist()})
        (self.folder / "programs.json").write_text(json.dumps(programs))
        found = json.loads(ran("node", HERE / "webgl.mjs", self.folder))
        return self.off(lambda f: found[f.name])


def main():
    lobe = Path(sys.argv[1]).resolve()
    with tempfile.TemporaryDirectory(prefix="lobe-shaders-") as name:
        folder = Path(name)
        cases = Path(sys.argv[2]).resolve() if len(sys.argv) > 2 else made_cases(folder)
        check = Check(lobe, cases, folder)
        device = Device()
        on = device.name.split("(")[0].strip()[:28]
        check.step("WGSL", f"naga, run on {on}", check.on(device, check.wgsl))
        if shutil.which("tint"):
            check.step("WGSL", "tint", check.by_tint)
        check.step("SPIR-V", "spirv-val", check.spirv_is_valid)
        check.step("SPIR-V", f"run on {on}", check.on(device, lambda f: (folder / f"{f.name}.spv").read_bytes()))
        check.step("GLSL", "glslang", check.in_every_version)
        check.step("GLSL 450", f"glslang, run on {on}", check.on(device, check.by_glslang("comp", check.glsl_compute)))
        check.step("GLSL ES 300", "ANGLE, run in WebGL 2", check.webgl)
        hlsl = check.by_glslang("hlsl", check.hlsl_compute, "-D", "-S", "comp", "-e", "main")
        check.step("HLSL", f"glslang, run on {on}", check.on(device, hlsl))
        check.step("MSL", "clang as C++, run here", check.metal)
        return 1 if check.faults else 0


if __name__ == "__main__":
    sys.exit(main())
