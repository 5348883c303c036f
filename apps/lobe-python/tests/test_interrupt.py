"""Ctrl-C stops long work."""

import signal
import subprocess
import sys

import pytest

LONG = {
    "log": "f.resized(10).log()",
    "minimum": "f.minimum()",
    "product": "f.product(f, 31)",
    "encoding": "f.resized(3).encode('zh3').eval(np.tile([0.0, 0.0, 1.0], (100_000, 1)))",
    "errors of encodings": "lobe.Sh(np.asarray(f)[0]).encodings(normals=1 << 20)",
    "sky": "lobe.EnvMap.sky([0, 0, 1], height=8192)",
    "reconstruction": "lobe.reconstruct(lobe.Sh(np.asarray(f)[0]), 16384, 8192)",
    "projection": "lobe.project(np.ones((6 * 2048, 2048, 3), np.float32), 16, 'cube')",
    "irradiance": "lobe.EnvMap.bundled('sunset').irradiance(16, 16384, 8192)",
    "conversion": "lobe.EnvMap.bundled('sunset').convert('cube', 4096)",
    "prefiltering": "lobe.EnvMap.bundled('sunset').prefilter(2048)",
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
