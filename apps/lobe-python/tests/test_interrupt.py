"""Ctrl-C stops long work."""

import signal
import subprocess
import sys
import time

import pytest

LONG = {
    "log": "f.resized(10).log()",
    "minimum": "f.minimum()",
    "product": "f.product(f, 31)",
    "mean of a product": "f.product(f, 1)",
    "encoding": "f.resized(3).encode('zh3').eval(np.tile([0.0, 0.0, 1.0], (100_000, 1)))",
    "errors of encodings": "lobe.Sh(np.asarray(f)[0]).encodings(normals=1 << 20)",
    "sky": "lobe.EnvMap.sky([0, 0, 1], height=8192)",
    "reconstruction": "lobe.reconstruct(lobe.Sh(np.asarray(f)[0]), 16384, 8192)",
    "projection": "lobe.project(np.ones((6 * 2048, 2048, 3), np.float32), 16, 'cube')",
    "irradiance": "lobe.EnvMap.bundled('sunset').irradiance(16, 16384, 8192)",
    "conversion": "lobe.EnvMap.bundled('sunset').convert('cube', 4096)",
    "prefiltering": "lobe.EnvMap.bundled('sunset').prefilter(2048)",
    "irradiance by brute force": "lobe.EnvMap.bundled('sunset').irradiance(width=2048, height=1024, method='brute-force')",
    "irradiance of many normals": "lobe.EnvMap.bundled('sunset').irradiance_at(np.tile([0.0, 0.0, 1.0], (1_000_000, 1)))",
    "a table of reflectance": "lobe.dfg_table(1024)",
    "reflectance": "lobe.dfg(np.linspace(0, 1, 10_000_000), 0.5)",
    "an area light": "lobe.AreaLight.disc((0, 0, 1), (0, 0.2, -1), 2.0).irradiance(np.tile([0.0, 0.5, 0.0], (20_000_000, 1)), (0, 1, 1))",
    "techniques": "lobe.EnvMap.bundled('sunset').techniques(1024)",
    "spheres": "lobe.spheres('built-in:walking-figure', 512, entity='figure', points=1 << 15)",
    "a scene that moves": "lobe.MovingScene('built-in:three-objects', lobe.MovingOptions(order=6, bake_samples=1 << 20)).bake()",
    "a lamp": "lobe.lamp('rectangle', __import__('tempfile').mkdtemp() + '/l.safetensors', size=(1, 1), order=8, pictures=[np.ones((64, 64, 3))], patches=(64, 64))",
    "transfer on the way": "lobe.render('built-in:still-life', lobe.EnvMap.bundled('sunset'), mode='glossy', bake_samples=1 << 20)",
    "comparison": "lobe.compare(np.random.default_rng(1).random((4000, 4000, 3)), np.ones((4000, 4000, 3)))",
}


@pytest.mark.skipif(sys.platform == "win32", reason="signals of another kind")
@pytest.mark.parametrize("work", LONG)
def test_an_interrupt_stops_long_work(work):
    program = f"""
import signal, numpy as np, lobe
# A shell that starts tests in the background has interrupts ignored, and so does what they start.
signal.signal(signal.SIGINT, signal.default_int_handler)
f = lobe.Sh(np.random.default_rng(0).normal(size=(40000 if "f." in {LONG[work]!r} else 1, 256)))
print("begun", flush=True)
{LONG[work]}
"""
    process = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stdout.readline() == "begun\n"
    process.send_signal(signal.SIGINT)
    # That it ends by the signal is what is judged, not when.
    _, error = process.communicate()
    assert error.rstrip().endswith("KeyboardInterrupt"), error


@pytest.mark.nightly
@pytest.mark.skipif(sys.platform == "win32", reason="signals of another kind")
def test_a_map_whose_writing_was_stopped_is_not_there_later(tmp_path):
    program = f"""
import os, signal, time, numpy as np, lobe
signal.signal(signal.SIGINT, signal.default_int_handler)
sky = lobe.EnvMap(np.random.default_rng(0).random((2048, 4096, 3), np.float32))
print("begun", flush=True)
try:
    sky.save({str(tmp_path / "sky.exr")!r})
except KeyboardInterrupt:
    # Longer than the encoding takes.
    time.sleep(5)
    print(os.listdir({str(tmp_path)!r}))
"""
    process = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stdout.readline() == "begun\n"
    time.sleep(0.1)
    process.send_signal(signal.SIGINT)
    told, error = process.communicate()
    assert told == "[]\n", told + error
