"""Arrays of every kind: what is taken, and what is refused in which words."""

import copy
import os
import pickle
import subprocess
import sys

import numpy as np
import pytest

import lobe


def test_arrays_of_any_layout_have_the_same_values():
    c = np.random.default_rng(0).normal(size=(6, 9, 3))
    expected = lobe.Sh(c).eval([[0, 0, 1], [1, 2, 3]])
    read_only = c.copy()
    read_only.setflags(write=False)
    for other in [np.asfortranarray(c), np.repeat(c, 2, axis=0)[::2], c.astype(">f8"), read_only, c.tolist()]:
        np.testing.assert_array_equal(lobe.Sh(other).eval([[0, 0, 1], [1, 2, 3]]), expected)


def test_empty_batches_have_empty_results():
    f = lobe.Sh(np.zeros((0, 4, 9, 3), np.float32))
    assert f.eval([0, 0, 1]).shape == (0, 4, 3) and f.rotate(np.eye(3)).shape == (0, 4)
    assert f.product(f).shape == (0, 4) and f.dering().shape == (0, 4) and f.exp().shape == (0, 4)
    assert f.minimum()[0].shape == (0, 4, 3) and f.lights().ambient.shape == (0, 4, 3)
    assert lobe.Sh(np.ones(9)).eval(np.zeros((0, 3))).shape == (0,)


def test_integers_are_numbers():
    assert lobe.Sh([1, 0, 0, 0]).dtype == np.float64


@pytest.mark.parametrize("values", [["a"] * 4, [None] * 4, [1j] * 4, [True] * 4, np.zeros(4, np.float16), np.zeros(4, "M8[s]")])
def test_what_is_no_number_is_a_type_error(values):
    with pytest.raises(TypeError, match="expected numbers of float32 or float64"):
        lobe.Sh(values)


@pytest.mark.parametrize(
    ("shape", "message"),
    [((), "found a number"), ((5,), "found 5"), ((2, 8), "found 8"), ((4, 2), "found 2"), ((0,), "found 0"), ((257**2,), "66049")],
)
def test_what_is_no_expansion_is_a_value_error(shape, message):
    with pytest.raises(ValueError, match=message):
        lobe.Sh(np.zeros(shape))


def test_arguments_at_fault_say_what_was_expected():
    f = lobe.Sh(np.ones(9))
    for call, error, message in [
        (lambda: f.eval([1, 2]), ValueError, r"shape \(..., 3\)"),
        (lambda: f.eval([0, 0, 0]), ValueError, "vectors with a length"),
        (lambda: f.eval([np.nan, 0, 1]), ValueError, "vectors with a length"),
        (lambda: f.rotate(np.eye(2)), ValueError, r"shape \(3, 3\)"),
        (lambda: f.rotate(2 * np.eye(3)), ValueError, "rotation"),
        (lambda: f.rotate(np.full((3, 3), np.nan)), ValueError, "finite"),
        (lambda: f.product(np.ones(9)), TypeError, "expected functions"),
        (lambda: f.product(lobe.Sh(np.ones(9, np.float32))), TypeError, "one dtype"),
        (lambda: f.product(f, 0), ValueError, "order: expected 1 to 256"),
        (lambda: f.product(f, 2.0), TypeError, "whole number"),
        (lambda: f.convolve("box"), ValueError, "cosine, phong or ggx"),
        (lambda: f.convolve("ggx", 2), ValueError, r"α in \[0, 1\]"),
        (lambda: f.convolve("phong", -1), ValueError, "exponent"),
        (lambda: f.convolve([1, 1]), ValueError, "each of 3 bands"),
        (lambda: f.window("hanning:0"), ValueError, "hanning"),
        (lambda: f.dering("magic"), ValueError, "least-change"),
        (lambda: f.log(0), ValueError, "clamp"),
        (lambda: f.resized(11).exp(), ValueError, "order 10 at most"),
        (lambda: f.resized(11).log(), ValueError, "order 10 at most"),
        (lambda: f.resized(65).minimum(), ValueError, "order 64 at most"),
        (lambda: f.resized(65).dering(), ValueError, "order 64 at most"),
        (lambda: f.resized(65).lights(), ValueError, "order 64 at most"),
        (lambda: f.minimum(0), ValueError, "tolerance"),
        (lambda: f.lights(0), ValueError, "count"),
        (lambda: lobe.Sh([1.0]).lights(), ValueError, "order"),
        (lambda: f + lobe.Sh(np.ones(4)), ValueError, "one order"),
        (lambda: f * f, TypeError, "product"),
        (lambda: len(f), TypeError, "no length"),
    ]:
        with pytest.raises(error, match=message):
            call()


def test_coefficients_that_are_not_finite_go_through_or_are_refused():
    c = np.ones((3, 9))
    c[1, 4] = np.nan
    f = lobe.Sh(c)
    values = f.eval([0.1, 0.2, 0.3])
    assert np.isnan(values[1]) and np.isfinite(values[[0, 2]]).all(), "only its own function"
    for call in [f.exp, f.log, f.minimum, f.lights, f.dering]:
        with pytest.raises(ValueError, match="function 1.*finite|finite.*function 1"):
            call()


def test_functions_are_chosen_by_numbers_arrays_and_masks():
    c = np.random.default_rng(1).normal(size=(4, 2, 9))
    f = lobe.Sh(c)
    for key in [2, [0, 1], np.array([0, 3]), np.array([True, False, True, False]), (np.array([0, 1]), 1), (slice(None), np.array([1]))]:
        np.testing.assert_array_equal(f[key].coefficients, c[key])
    np.testing.assert_array_equal(f[..., 0].coefficients, c[:, 0])


def test_an_array_that_may_not_be_a_copy_is_none():
    f = lobe.Sh(np.ones((2, 9)))
    assert f.__array__(copy=False) is f.coefficients and f.__array__(dtype=np.float64, copy=False) is f.coefficients
    assert f.__array__(copy=True) is not f.coefficients
    with pytest.raises(ValueError, match="as float32 they are copied"):
        f.__array__(dtype=np.float32, copy=False)
    with pytest.raises(ValueError, match="texels are copied"):
        lobe.EnvMap(np.ones((2, 4, 3))).__array__(copy=False)


def test_only_functions_are_added_and_only_real_numbers_are_factors():
    f = lobe.Sh(np.arange(9.0))
    np.testing.assert_array_equal(sum([f, f, f]).coefficients, 3 * f.coefficients)
    np.testing.assert_array_equal((np.float64(2) * f).coefficients, 2 * f.coefficients)
    for call in [lambda: f + np.ones(9), lambda: np.ones(9) + f, lambda: f - 1.0, lambda: 1.0 - f, lambda: 1 + f]:
        with pytest.raises(TypeError, match="expected functions, lobe.Sh, found"):
            call()
    with pytest.raises(TypeError, match="expected a real number"):
        f * (2 + 3j)


def test_maps_and_lights_are_sent_to_other_processes():
    map = lobe.EnvMap(np.random.default_rng(2).random((6, 1, 3)), "cube")
    for copied in [pickle.loads(pickle.dumps(map)), copy.deepcopy(map)]:
        assert copied.mapping == "cube"
        np.testing.assert_array_equal(copied.texels, map.texels)
    place = [[0.1, 0.2, 0.0]], [0.0, 0.0, 1.0]
    for light in [
        lobe.AreaLight.sphere((0, 0, 2), 0.5),
        lobe.AreaLight.disc((0, 0, 2), (0, 0, -1), 0.5),
        lobe.AreaLight.rectangle((0, 0, 2), (1, 0, 0), (0, -1, 0)),
        lobe.AreaLight.polygon([[0, 0, 2], [0, 1, 2], [1, 0, 2]]),
    ]:
        again = pickle.loads(pickle.dumps(light))
        np.testing.assert_array_equal(again.irradiance(*place), light.irradiance(*place))
        assert repr(again) == repr(light)


def test_encoded_irradiances_are_sent_to_other_processes_and_keep_their_numbers():
    c = np.random.default_rng(3).normal(size=(2, 9, 3))
    irradiance, n = lobe.Sh(c), np.random.default_rng(4).normal(size=(5, 3))
    for name, options in [("zh3", {}), ("h-6", {"normal": (0.3, -0.4, 2.0)}), ("packed", {"over_pi": True, "up": "y"}), ("ahd", {})]:
        encoded = irradiance.encode(name, **options)
        before = encoded.eval(n)
        c += 1.0
        for again in [pickle.loads(pickle.dumps(encoded)), copy.deepcopy(encoded)]:
            assert repr(again) == repr(encoded) and again.numbers.keys() == encoded.numbers.keys()
            np.testing.assert_array_equal(again.eval(n), before, err_msg=name)
        c -= 1.0


def test_results_without_room_are_a_memory_error():
    f = lobe.Sh(np.broadcast_to(np.ones(4), (1 << 20, 4)))
    with pytest.raises(MemoryError, match="rows of 65536 numbers"):
        f.product(f, 256)


FORKED = """
import multiprocessing, sys
import numpy as np
import lobe

f = lobe.Sh(np.random.default_rng(0).normal(size=(2000, 16)))
turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
sky = lobe.EnvMap.bundled("sunset")

def work():
    values = f.eval(np.eye(3))
    return f.rotate(turn).coefficients, values, sky.project(4).coefficients, sky.irradiance(4, 256, 128).texels

expected = work()

def child():
    for found, here in zip(work(), expected):
        np.testing.assert_array_equal(found, here)

process = multiprocessing.get_context("fork").Process(target=child)
process.start()
process.join(60)
sys.exit(process.exitcode if process.exitcode is not None else 99)
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system does not fork")
def test_a_process_that_was_forked_works_with_threads_of_its_own():
    done = subprocess.run([sys.executable, "-c", FORKED], capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
