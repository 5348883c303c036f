"""Irradiance in a few numbers, and lights as functions."""

import json
import os
import subprocess

import numpy as np
import pytest

import lobe
from command import lobe_json
from oracles import directions

WHOLE_SPHERE = ["sh-2", "sh-3", "sh-5", "non-linear-l1", "zh3", "zh3-hallucinated", "ambient-cube", "ahd"]
ONE_SIDE = ["h-4", "h-6", "sh-3-hemisphere", "hl2"]


@pytest.fixture
def irradiance():
    return lobe.EnvMap.bundled("sunset").project(6).convolve("cosine")


@pytest.mark.parametrize("name", WHOLE_SPHERE + ONE_SIDE)
def test_constant_irradiance_is_kept_by_every_encoding(name):
    constant = lobe.Sh(np.concatenate([[np.sqrt(4 * np.pi)], np.zeros(8)]))
    n = directions(64)
    n = n[n[:, 2] >= 0] if name in ONE_SIDE else n
    assert constant.encode(name).eval(n) == pytest.approx(np.ones(len(n)), abs=1e-6), name


def test_three_bands_are_their_own_encoding(irradiance):
    n = directions(64)
    encoded = irradiance.encode("sh-3")
    assert encoded.eval(n) == pytest.approx(irradiance.resized(3).eval(n), abs=1e-12)
    assert set(encoded.numbers) == {f"E_{k}" for k in range(9)}
    assert encoded.numbers["E_0"] == pytest.approx(np.asarray(irradiance)[0])


def test_a_batch_has_the_encodings_of_its_functions(irradiance):
    one = np.asarray(irradiance)
    batch = lobe.Sh(np.stack([one, 2 * one, one]).reshape(3, 1, 36, 3)).encode("ahd")
    assert batch.shape == (3, 1)
    assert batch.numbers["direction"].shape == (3, 1, 3)
    assert batch.numbers["ambient"].shape == (3, 1, 3)
    values = batch.eval([[0, 0, 1], [1, 0, 0]])
    assert values.shape == (3, 1, 2, 3)
    assert values[1] == pytest.approx(2 * values[0])
    assert values[2, 0] == pytest.approx(irradiance.encode("ahd").eval([[0, 0, 1], [1, 0, 0]]))


@pytest.mark.parametrize("name", ONE_SIDE)
def test_one_side_of_a_surface_turns_with_its_normal(name):
    turn = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    lamp = lobe.light("cone", 6, half_angle=0.5).convolve("cosine")
    n = directions(64)
    n = n[n[:, 2] >= 0.1]
    up = lamp.encode(name).eval(n)
    turned = lamp.rotate(turn).encode(name, normal=turn @ [0, 0, 1])
    # About an axis of symmetry it does not matter which way the tangents point, but for the three colors of hl2.
    n = np.array([[0.0, 0.0, 1.0]]) if name == "hl2" else n
    up = up if name != "hl2" else lamp.encode(name).eval(n)
    assert turned.eval(n @ turn.T) == pytest.approx(up, abs=1e-6)


@pytest.mark.parametrize("name", ["sh-5", "packed-5"])
def test_order_5_is_kept_by_its_bands_and_by_its_vectors(irradiance, name):
    n = directions(64)
    five = irradiance.resized(5)
    encoded = irradiance.encode(name)
    assert encoded.eval(n) == pytest.approx(five.eval(n), abs=1e-12)
    assert sum(values.size for values in encoded.numbers.values()) == 54


@pytest.mark.parametrize("name", ["packed", "matrix", "r-h"])
def test_constants_of_shaders_have_the_values_of_three_bands(irradiance, name):
    n = directions(64)
    three = irradiance.resized(3)
    assert irradiance.encode(name).eval(n) == pytest.approx(three.eval(n), abs=1e-12)
    green = lobe.Sh(np.ascontiguousarray(np.asarray(irradiance)[:, 1])).encode(name)
    assert green.eval(n) == pytest.approx(three.eval(n)[:, 1], abs=1e-12)
    # Where y points up, and of what a white surface leaves.
    used = irradiance.encode(name, over_pi=True, up="y")
    assert used.eval(n[:, [0, 2, 1]] * [1, 1, -1]) == pytest.approx(three.eval(n) / np.pi, abs=1e-12)


@pytest.mark.parametrize("name", ["packed", "packed-5", "matrix", "r-h", "sh-5", "zh3", "h-4"])
def test_numbers_of_an_encoding_are_those_of_the_command(irradiance, tmp_path, name):
    irradiance.save(tmp_path / "e.sh.json", quantity="irradiance")
    expected = lobe_json("sh encode", tmp_path / "e.sh.json", "--over-pi --up y --as", name)
    found = irradiance.encode(name, over_pi=True, up="y").numbers
    assert [row["name"] for row in expected["numbers"]] == list(found)
    for row in expected["numbers"]:
        assert np.ravel(found[row["name"]]) == pytest.approx(row["values"], rel=1e-12, abs=1e-14), row["name"]
    with pytest.raises(ValueError, match="up: expected y or z, found 'x'"):
        irradiance.encode(name, up="x")


def test_errors_are_those_of_their_definition(irradiance):
    errors = {error.name: error for error in irradiance.encodings(512)}
    assert len(errors) == 19
    assert errors["sh-3"].floats == 27 and not errors["sh-3"].is_hemispherical and errors["h-4"].is_hemispherical
    assert errors["sh-3"].max >= errors["sh-3"].rms >= errors["sh-3"].mean > 0
    assert errors["sh-3"].rms < errors["zh3"].rms < errors["sh-2"].rms


def test_what_cannot_be_encoded_says_so(irradiance):
    with pytest.raises(ValueError, match="expected packed, packed-5, matrix, r-h, three, .*, cesium or one of sh-2"):
        irradiance.encode("zh4")
    with pytest.raises(ValueError, match="zero or not finite"):
        irradiance.encode("h-4", normal=(0, 0, 0))
    with pytest.raises(ValueError, match="normal: expected one vector"):
        irradiance.encode("h-4", normal=[[0, 0, 1]])
    with pytest.raises(ValueError, match="one function"):
        lobe.Sh(np.zeros((2, 9))).encodings()
    assert lobe.Sh(np.zeros((0, 9))).encode("zh3").eval([0, 0, 1]).shape == (0,)


def test_a_light_lights_the_surface_that_faces_it_as_its_normalization_says():
    toward = np.array([1.0, 2.0, -2.0]) / 3.0
    for kind in ["directional", "cone", "soft-cone"]:
        sun = lobe.light(kind, 4, direction=3 * toward, half_angle=0.3, color=(1.0, 0.5, 0.25))
        reflected = sun.convolve("cosine").eval(toward) / np.pi
        assert reflected == pytest.approx([1.0, 0.5, 0.25]), kind
    cap = lobe.light("cone", 1, direction=toward, half_angle=0.3, normalize="none")
    assert cap.mean() == pytest.approx(np.full(3, (1 - np.cos(0.3)) / 2)), "its share of the sphere"


def test_skies_have_their_colors_at_their_poles():
    sky = lobe.light("hemisphere", 2, color=[[1, 2, 3], [0.5, 0.25, 0]], normalize="none")
    assert sky.eval([[0, 0, 1], [0, 0, -1]]) == pytest.approx(np.array([[1, 2, 3], [0.5, 0.25, 0]]))
    assert lobe.light("ambient", 3, color=(2, 2, 2)).eval([0.6, 0, 0.8]) == pytest.approx(np.full(3, 2.0))
    even = lobe.light("gradient", 4, color=np.ones((3, 3)))
    assert even.eval([0.6, 0, 0.8]) == pytest.approx(np.ones(3))


def test_the_command_makes_the_same_light(tmp_path):
    command = os.environ.get("LOBE")
    if not command:
        pytest.skip("the command is not built")
    corners = [[1, 0.2, 0], [1, 0, 0.5], [1, -0.4, 0]]
    path = tmp_path / "window.sh.json"
    text = " ".join(",".join(map(str, corner)) for corner in corners)
    subprocess.run([command, "light", "polygon", "--vertices", text, "--order", "5", "-o", path], check=True)
    expected = json.loads(path.read_text())["coefficients"]
    assert np.asarray(lobe.light("polygon", 5, vertices=corners)) == pytest.approx(np.array(expected), abs=1e-12)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"kind": "torch"}, "found 'torch'"),
        ({"kind": "cone"}, "half_angle"),
        ({"kind": "cone", "half_angle": 4.0}, "angle"),
        ({"kind": "polygon"}, "vert"),
        ({"kind": "polygon", "vertices": [[0, 1]]}, "vertices: expected rows of three"),
        ({"kind": "hemisphere"}, "hemisphere with two"),
        ({"kind": "ambient", "normalize": "half"}, "normalize"),
        ({"kind": "directional", "direction": (0, 0, 0)}, "zero or not finite"),
        ({"kind": "ambient", "color": (1, np.nan, 1)}, "finite"),
        ({"kind": "ambient", "order": 0}, "order"),
    ],
)
def test_lights_that_cannot_be_made_say_so(arguments, message):
    with pytest.raises(ValueError, match=message):
        lobe.light(**arguments)
