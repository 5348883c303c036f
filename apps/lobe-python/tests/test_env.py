"""Environment maps against quadrature in numpy, closed forms, and the command."""

import json
import os
import shutil
import subprocess
import warnings

import numpy as np
import pytest

import lobe
from oracles import basis, rotation


def centers(height, width):
    """Directions of the centers of texels of a lat-long map, +x in the middle, +y to the left; and their solid angles."""
    theta = np.pi * (np.arange(height) + 0.5) / height
    phi = np.pi * (1 - (2 * np.arange(width) + 1) / width)
    t, p = np.meshgrid(theta, phi, indexing="ij")
    d = np.stack([np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)], axis=-1)
    edges = np.cos(np.pi * np.arange(height + 1) / height)
    return d, np.repeat((edges[:-1] - edges[1:])[:, None] * 2 * np.pi / width, width, axis=1)


def test_a_projection_is_the_sum_over_texels():
    d, w = centers(64, 128)
    image = (1 + 0.5 * d[..., 2:] + d**2).astype(np.float32)
    y = basis(4, d.reshape(-1, 3))
    expected = y.T @ (image.reshape(-1, 3) * w.reshape(-1, 1))
    found = lobe.project(image, 4)
    # Texels are averages here and points there: a difference of the square of their size.
    np.testing.assert_allclose(found.coefficients, expected, atol=4e-3)
    gray = lobe.project(image[..., 1], 4)
    assert not gray.is_color
    np.testing.assert_array_equal(gray.coefficients, found.coefficients[:, 1])


@pytest.mark.parametrize("order, width, height", [(1, 1, 1), (3, 16, 8), (16, 36, 17), (20, 30, 9), (40, 64, 32)])
def test_the_texels_of_functions_are_their_values_towards_the_centers(order, width, height):
    d, _ = centers(height, width)
    for shape in [(order**2,), (2, 3, order**2), (2, order**2, 3)]:
        c = np.random.default_rng(order).normal(size=shape)
        for dtype, bound in [(np.float64, 1e-12), (np.float32, 2e-5)]:
            f = lobe.Sh(c.astype(dtype))
            found = f.texels(width, height)
            assert found.dtype == dtype and found.shape == f.shape + (height, width) + ((3,) if f.is_color else ())
            np.testing.assert_allclose(found, lobe.Sh(c).eval(d), atol=bound * order)


@pytest.mark.parametrize("order", [4, 20])
def test_a_picture_of_double_precision_is_not_rounded(order):
    c = np.zeros(order**2)
    c[0], c[2] = 1.0, 1e-10
    picture = lobe.Sh(c).texels(64, 32)
    assert abs(lobe.project(picture, order).coefficients[2] / c[2] - 1) < 1e-2, "texels are averages here and points there"
    color = np.repeat(picture[..., None], 3, axis=-1)
    np.testing.assert_allclose(lobe.project(color, order).coefficients[:, 1], lobe.project(picture, order).coefficients, atol=1e-15)
    every_second = np.repeat(picture, 2, axis=1)[:, ::2]
    assert not every_second.flags.c_contiguous
    np.testing.assert_array_equal(lobe.project(every_second, order).coefficients, lobe.project(picture, order).coefficients)


@pytest.mark.parametrize("height", [8, 512])
def test_texels_are_kept_however_many_there_are(height):
    texels = np.random.default_rng(height).random((height, 2 * height, 3), dtype=np.float32)
    np.testing.assert_array_equal(lobe.EnvMap(texels).texels, texels)


def test_a_constant_is_exact():
    f = lobe.project(np.full((3, 7, 3), 2.0), 5)
    expected = np.zeros((25, 3))
    expected[0] = 2 * np.sqrt(4 * np.pi)
    np.testing.assert_allclose(f.coefficients, expected, atol=1e-13)


def test_maps_keep_their_texels_and_mapping():
    texels = np.random.default_rng(0).random((12, 2, 3)).astype(np.float32)
    cube = lobe.EnvMap(texels, "cube")
    assert cube.mapping == "cube" and cube.shape == (12, 2) and repr(cube) == "EnvMap(cube, 2 x 12)"
    np.testing.assert_array_equal(np.asarray(cube), texels)


@pytest.mark.parametrize("mapping, shape", [("lat-long", (8, 16)), ("octahedral", (8, 8))])
def test_a_png_is_the_picture_of_a_map_and_tells_its_mapping(tmp_path, mapping, shape):
    path = tmp_path / "map.png"
    lobe.EnvMap(np.linspace(0, 4, 3 * shape[0] * shape[1]).reshape((*shape, 3)), mapping).save(path)
    with pytest.warns(lobe.LoadNote, match="map.png: PNG of 8 bits"):
        shown = lobe.EnvMap.load(path)
    assert (shown.mapping, shown.shape) == (mapping, shape)
    assert 0 < shown.texels.max() <= 1, "tone mapped"
    with pytest.raises(OSError, match="none"):
        shown.save(tmp_path / "none" / "map.png")


def test_conversions_and_rotations_keep_the_mean_and_turn_the_light():
    sky = lobe.EnvMap.bundled("sunset")
    r = rotation(5)
    small = sky.convert("lat-long", 128)
    turned = small.rotate(r)
    np.testing.assert_allclose(turned.project(1).coefficients, small.project(1).coefficients, rtol=1e-3)
    np.testing.assert_allclose(
        turned.project(3).coefficients, small.project(3).rotate(r).coefficients, atol=0.02 * float(small.project(1).coefficients.max())
    )
    cube = sky.convert("cube", 32)
    assert cube.shape == (192, 32)
    up = cube.radiance([0, 0, 1]), sky.radiance([0, 0, 1])
    np.testing.assert_allclose(up[0], up[1], rtol=0.2)


def test_irradiance_is_the_convolution():
    sky = lobe.EnvMap.bundled("studio")
    found = sky.irradiance(3, 32, 16).texels
    d, _ = centers(16, 32)
    expected = sky.project(3).convolve("cosine").eval(d)
    np.testing.assert_allclose(found, expected, rtol=1e-4, atol=1e-4)
    back = lobe.reconstruct(sky.project(3), 32, 16).texels
    np.testing.assert_allclose(back, sky.project(3).eval(d), rtol=1e-4, atol=1e-4)


def test_prefiltered_levels_grow_even_and_keep_a_constant():
    levels = lobe.EnvMap(np.ones((16, 32, 3))).prefilter(16, 4)
    assert [level.shape for level in levels] == [(96, 16), (48, 8), (24, 4)]
    for level in levels:
        np.testing.assert_allclose(level.texels, 1, atol=1e-4)


def test_the_sun_of_the_sunset_is_found_and_its_light_kept():
    sky = lobe.EnvMap.bundled("sunset")
    sun = sky.sun()
    assert sun is not None and abs(np.linalg.norm(sun.direction) - 1) < 1e-12
    whole, rest = (m.project(1).coefficients[0] * np.sqrt(4 * np.pi) for m in (sky, sun.rest))
    np.testing.assert_allclose(rest + sun.irradiance, whole, rtol=1e-4)
    assert lobe.EnvMap(np.ones((8, 16, 3))).sun() is None


def test_a_clear_sky_is_brightest_near_the_sun():
    sky = lobe.EnvMap.sky([1, 0, 1], turbidity=3, height=64)
    assert sky.radiance([1, 0, 1])[1] > 3 * sky.radiance([-1, 0, 1])[1]


def test_files_are_written_and_read(tmp_path):
    texels = np.random.default_rng(1).random((4, 8, 3)).astype(np.float32)
    for name in ["a.exr", "a.pfm"]:
        lobe.EnvMap(texels).save(tmp_path / name)
        back = lobe.EnvMap.load(tmp_path / name)
        np.testing.assert_allclose(back.texels, texels, rtol=1e-3)


@pytest.mark.parametrize("name, numbers", [("map.png", [1, 1, 1]), ("map.pfm", [-1, 2, 3]), ("map.pfm", [np.nan, 2, 3])])
def test_what_a_reader_notes_is_a_warning_in_the_words_of_the_command(name, numbers, tmp_path):
    path = tmp_path / name
    lobe.EnvMap(np.ones((4, 8, 3))).save(path)
    if name.endswith("pfm"):
        path.write_bytes(path.read_bytes()[:-12] + np.array(numbers, "<f4").tobytes())
    with pytest.warns(lobe.LoadNote) as told:
        lobe.EnvMap.load(path, nonfinite="zero")
    command = os.environ.get("LOBE") or shutil.which("lobe")
    if command is None:
        pytest.skip("the command lobe is not built: set LOBE to it")
    run = [command, "project", path, "--nonfinite", "zero", "--order", "1", "-o", tmp_path / "s.sh.json"]
    notes = subprocess.run(run, check=True, capture_output=True, text=True).stderr.splitlines()
    # The command adds what it has to do about it.
    assert [f"note: {warning.message}" for warning in told] == [note.partition(" (lobe")[0] for note in notes]
    # Who has read them may have enough of them.
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", lobe.LoadNote)
        lobe.EnvMap.load(path, nonfinite="zero")


def test_what_is_no_map_says_so(tmp_path):
    (tmp_path / "cut.exr").write_bytes(b"\x76\x2f\x31\x01")
    for call, error, message in [
        (lambda: lobe.EnvMap.load(tmp_path / "none.exr"), OSError, "none.exr"),
        (lambda: lobe.EnvMap.load(tmp_path / "cut.exr"), ValueError, "cut.exr"),
        (lambda: lobe.EnvMap.bundled("moon"), ValueError, "sunset or studio"),
        (lambda: lobe.EnvMap(np.zeros((4, 8, 2))), ValueError, r"\(height, width, 3\)"),
        (lambda: lobe.EnvMap(np.zeros((4, 8, 3)), "flat"), ValueError, "lat-long or cube"),
        (lambda: lobe.EnvMap(np.zeros((4, 8, 3)), "cube"), ValueError, "cube"),
        (lambda: lobe.EnvMap(np.zeros((0, 8, 3))), ValueError, "0"),
        (lambda: lobe.EnvMap(np.zeros((4, 8, 3))).save(tmp_path / "a.txt"), ValueError, "a.txt"),
        (lambda: lobe.EnvMap(np.zeros((4, 8, 3))).project(0), ValueError, "order"),
        (lambda: lobe.EnvMap.sky([0, 0, -1]), ValueError, "horizon"),
        (lambda: lobe.EnvMap.sky([0, 0, 1], albedo=[2, 0, 0]), ValueError, "albedo"),
        (lambda: lobe.reconstruct(lobe.Sh(np.ones((2, 9))), 8, 4), ValueError, "one function"),
    ]:
        with pytest.raises(error, match=message):
            call()
    assert sorted(os.listdir(tmp_path)) == ["cut.exr"], "nothing is left behind"


def test_the_command_finds_the_same_numbers(tmp_path):
    command = os.environ.get("LOBE") or shutil.which("lobe")
    if command is None:
        pytest.skip("the command lobe is not built: set LOBE to it")
    run = [command, "project", "bundled:sunset", "--order", "4", "-o", str(tmp_path / "s.sh.json"), "--quiet"]
    subprocess.run(run, check=True)
    expected = np.array(json.loads((tmp_path / "s.sh.json").read_text())["coefficients"])
    found = lobe.EnvMap.bundled("sunset").project(4).coefficients
    np.testing.assert_allclose(found, expected, rtol=1e-6, atol=1e-6 * np.abs(expected).max())
