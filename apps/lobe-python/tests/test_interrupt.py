"""Ctrl-C stops long work."""

import signal
import subprocess
import sys

import pytest

LONG = {
    "log": "lobe.Sh(random(4000, 256)).log()",
    "minimum": "lobe.Sh(random(20000, 256)).minimum()",
    "product": "lobe.Sh(random(20000, 256)).product(lobe.Sh(random(20000, 256)), 31)",
}


@pytest.mark.skipif(sys.platform == "win32", reason="signals of another kind")
@pytest.mark.parametrize("work", LONG)
def test_an_interrupt_stops_work_on_many_functions(work):
    program = f"""
import numpy as np, lobe
random = lambda *shape: np.random.default_rng(0).normal(size=shape)
print("begun", flush=True)
{LONG[work]}
"""
    process = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stdout.readline() == "begun\n"
    process.send_signal(signal.SIGINT)
    # It would take minutes by itself; that it ends by the signal is what is judged, not when.
    _, error = process.communicate()
    assert error.rstrip().endswith("KeyboardInterrupt"), error
