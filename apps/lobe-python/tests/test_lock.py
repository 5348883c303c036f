"""The interpreter's lock: other threads of a program go on while the package computes."""

import sys
import threading
import time

import numpy as np
import pytest

import lobe

WORK = {
    # Of many bands: it takes milliseconds, and a busy machine gives no turn sooner.
    "rotate": lambda f: f.resized(16).rotate(np.eye(3)[[1, 2, 0]]),
    "minimum": lambda f: f.resized(12).minimum(),
    "exp": lambda f: f.exp(),
    "texels": lambda f: f.texels(64, 32),
    "bake": lambda f: lobe.BakeOptions(order=3, samples=256).of(lobe.Scene("built-in:ball")),
    "trace": lambda f: lobe.trace("built-in:ball", lobe.Sh(np.ones((1, 3))), width=64, height=48, samples=64),
}


@pytest.fixture
def no_turns_but_those_that_are_given():
    """Threads take turns only where one gives the lock away: by itself, or while it computes outside of Python."""
    before = sys.getswitchinterval()
    sys.setswitchinterval(1000.0)
    yield
    sys.setswitchinterval(before)


@pytest.mark.parametrize("name", WORK)
def test_another_thread_goes_on_while_the_package_computes(name, no_turns_but_those_that_are_given):
    f = lobe.Sh(np.random.default_rng(0).normal(size=(2000, 25)) * 0.1)
    steps, met = [0], []

    def work():
        before = steps[0]
        WORK[name](f)
        met.append(steps[0] - before)

    thread = threading.Thread(target=work)
    thread.start()
    while not met and thread.is_alive():
        steps[0] += 1
        time.sleep(0)
    thread.join()
    assert met and met[0] > 0, f"{name}: no step of another thread"


def test_a_thread_that_keeps_the_lock_lets_no_other_go_on(no_turns_but_those_that_are_given):
    # What the test above would see of a package that keeps it.
    steps, met = [0], []

    def work():
        before = steps[0]
        sum(range(1_000_000))
        met.append(steps[0] - before)

    thread = threading.Thread(target=work)
    thread.start()
    while not met and thread.is_alive():
        steps[0] += 1
        time.sleep(0)
    thread.join()
    assert met == [0]
