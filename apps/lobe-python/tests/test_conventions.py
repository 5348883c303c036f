"""Coefficients as other libraries and engines keep them."""

import doctest
import json
import typing

import numpy as np
import pytest

import lobe
from command import lobe_command
from lobe import _conventions, _light, _lobe, _sh
from oracles import directions

NAMES = sorted(lobe.CONVENTIONS)


def function(order, *shape, seed=3):
    return lobe.Sh(np.random.default_rng(seed).normal(size=(*shape, order * order)))


def color(order, *shape, seed=4):
    return lobe.Sh(np.random.default_rng(seed).normal(size=(*shape, order * order, 3)))


def test_names_in_types_are_those_of_the_library():
    assert list(typing.get_args(_conventions.Convention)) == list(lobe.CONVENTIONS)
    assert list(typing.get_args(_conventions.EngineForm)) == _lobe.engine_forms()


@pytest.mark.parametrize("name", NAMES)
def test_there_and_back_changes_the_last_digits_alone(name):
    for f in (function(4), color(4), function(3, 5), color(2, 2, 5)):
        array = f.to_convention(name)
        back = lobe.Sh.from_convention(array, name)
        assert (back.shape, back.is_color) == (f.shape, f.is_color)
        assert np.abs(back.coefficients - f.coefficients).max() < 1e-14
        of_columns = lobe.Sh.from_convention(np.asfortranarray(array), name)
        assert of_columns.coefficients == pytest.approx(back.coefficients, abs=0)
    assert function(4, 0).to_convention(name).shape[0] == 0
    assert lobe.Sh.from_convention(function(4, 0).to_convention(name), name).shape == (0,)


@pytest.mark.parametrize("name", NAMES)
def test_the_command_writes_the_same_array(name, tmp_path):
    for f in (function(4), color(4)):
        f.save(tmp_path / "f.sh.json")
        lobe_command("sh convert", tmp_path / "f.sh.json", "--to", name, "-o", tmp_path / "c.npy")
        found, ours = np.load(tmp_path / "c.npy"), f.to_convention(name)
        assert (found.dtype, found.shape) == (ours.dtype, ours.shape)
        assert np.array_equal(found, ours)


def test_shapes_and_types_are_those_of_the_libraries():
    f = function(4)
    shapes = {"pyshtools": (2, 4, 4), "healpy": (10,), "shtns": (10,), "scipy": (4, 7), "sphericart": (16,), "e3nn": (16,), "fuma": (16,)}
    for name, shape in shapes.items():
        array = f.to_convention(name)
        assert array.shape == shape, name
        assert array.dtype == (np.complex128 if name in ("healpy", "shtns", "scipy") else np.float64), name
    assert color(4, 2).to_convention("scipy").shape == (2, 3, 4, 7)
    batch = function(4, 3).to_convention("pyshtools")
    assert lobe.Sh.from_convention(batch, "pyshtools").is_color
    assert lobe.Sh.from_convention(batch, "pyshtools", color=False).shape == (3,)


def test_ambisonics_signals_of_a_source_are_the_functions_towards_it():
    x, y, z = 0.48, -0.6, 0.64
    # Each function towards the source.
    source = lobe.Sh([lobe.Sh(row).eval([x, y, z]) for row in np.eye(4)])
    assert source.to_convention("ambix") == pytest.approx([1, y, z, x], abs=1e-14)
    assert source.to_convention("fuma") == pytest.approx([np.sqrt(0.5), x, y, z], abs=1e-14)
    assert source.to_convention("ambisonics-n3d") == pytest.approx([1, *np.sqrt(3) * np.array([y, z, x])], abs=1e-14)


def test_what_is_no_real_function_or_no_array_is_refused():
    refused = [
        (np.array([1, 1j, 0]), "healpy", "healpy: l = 1, m = 0: expected a real number, found the imaginary part 1"),
        (np.ones(5), "ambix", r"ambix: expected an array of shape \(n²\)"),
        (np.ones((2, 2)), "pyshtools", "array: expected 3 axes or more for pyshtools"),
        (np.full(4, np.nan), "ambix", "ambix: number 0 of 4 is not finite"),
        (np.ones(25), "fuma", "fuma: expected order 1 to 4"),
        (np.ones(4), "mathematica", "convention: expected one of pyshtools, .* found \"mathematica\""),
    ]
    for array, name, said in refused:
        with pytest.raises(ValueError, match=said):
            lobe.Sh.from_convention(array, name)
    with pytest.raises(TypeError, match="array: expected real or complex numbers, found object"):
        lobe.Sh.from_convention(np.array([None] * 4), "ambix")
    with pytest.raises(TypeError, match="convention: expected a name"):
        function(2).to_convention(3)
    with pytest.raises(ValueError, match="fuma: expected order 1 to 4"):
        function(5).to_convention("fuma")
    with pytest.raises(ValueError, match="an axis of three colors"):
        lobe.Sh.from_convention(np.ones((2, 4)), "ambix", color=True)


@pytest.mark.parametrize("form", _lobe.engine_forms())
def test_engines_get_the_numbers_of_the_command_and_give_them_back(form, tmp_path):
    radiance = color(3)
    encoded = radiance.convolve("cosine").encode(form)
    radiance.save(tmp_path / "f.sh.json")
    text = lobe_command("sh encode", tmp_path / "f.sh.json", "--as", form, "--json")
    rows = {row["name"]: row["values"] for row in json.loads(text)["numbers"]}
    assert list(encoded.numbers) == list(rows)
    for name, values in encoded.numbers.items():
        assert values == pytest.approx(rows[name], abs=1e-14), name
    (tmp_path / "numbers.json").write_text(text)
    back = lobe.import_coefficients(tmp_path / "numbers.json", form)
    assert back.coefficients == pytest.approx(radiance.coefficients, abs=1e-14)
    n = directions(32)
    assert encoded.eval(n) == pytest.approx(radiance.convolve("cosine").eval(n), abs=1e-12)


def test_what_engines_cannot_have_is_refused(tmp_path):
    irradiance = color(3).convolve("cosine")
    with pytest.raises(ValueError, match="over_pi: the form of unity says it by itself"):
        irradiance.encode("unity", over_pi=True)
    with pytest.raises(ValueError, match="up: the form of three says it by itself"):
        irradiance.encode("three", up="y")
    with pytest.raises(ValueError, match="r-h, three, babylon, .* or one of"):
        irradiance.encode("quake")
    with pytest.raises(OSError, match="none.json"):
        lobe.import_coefficients(tmp_path / "none.json", "three")
    (tmp_path / "few.txt").write_text("1 2 3")
    with pytest.raises(ValueError, match="27 numbers, expected, found 3"):
        lobe.import_coefficients(tmp_path / "few.txt", "three")
    with pytest.raises(ValueError, match="form: expected one of three"):
        lobe.import_coefficients(tmp_path / "few.txt", "quake")


def test_examples_in_the_documentation_are_true():
    for module in (_sh, _light):
        result = doctest.testmod(module, extraglobs={"lobe": lobe})
        assert result.attempted > 0 and result.failed == 0
