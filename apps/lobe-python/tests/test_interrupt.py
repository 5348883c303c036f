"""Ctrl-C stops long work."""

import signal
import subprocess
import sys

import pytest

LONG = {
    "log": "f.log()",
    "minimum": "f.minimum()",
    "product": "f.product(f, 31)",
}


@pytest.mark.skipif(sys.platform == "win32", reason="signals of another kind")
@pytest.mark.parametrize("work", LONG)
def test_an_interrupt_stops_work_on_many_functions(work):
    program = f"""
import signal, numpy as np, lobe
# A shell that starts tests in the background has interrupts ignored, and so does what they start.
signal.signal(signal.SIGINT, signal.default_int_handler)
f = lobe.Sh(np.random.default_rng(0).normal(size=(40000, 256)))
print("begun", flush=True)
{LONG[work]}
"""
    process = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stdout.readline() == "begun\n"
    process.send_signal(signal.SIGINT)
    # It would take minutes by itself; that it ends by the signal is what is judged, not when.
    _, error = process.communicate()
    assert error.rstrip().endswith("KeyboardInterrupt"), error
