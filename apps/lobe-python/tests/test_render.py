"""Pictures of scenes: transfer beside the truth, furnaces, and the command."""

from typing import get_args, get_type_hints

import numpy as np
import pytest

import lobe
from command import lobe_json

WHITE = lobe.Sh([np.sqrt(4 * np.pi)])
SMALL = {"width": 32, "height": 24}


@pytest.fixture(scope="module")
def baked(tmp_path_factory):
    path = tmp_path_factory.mktemp("baked") / "b.glb"
    lobe.bake("built-in:ball", path, lobe.BakeOptions(samples=256, order=4))
    return path


def test_transfer_is_near_its_truth(baked):
    sky = lobe.EnvMap.bundled("sunset").project(4).dering()
    fast = lobe.render(baked, sky, **SMALL)
    truth = lobe.trace("built-in:ball", sky, samples=256, **SMALL)
    assert fast.shape == truth.mean.shape == truth.variance.shape == (24, 32, 3) and fast.dtype == np.float32
    found = lobe.compare(fast, truth.mean)
    assert found.psnr > 30 and found.flip < 0.1, found
    # The noise is what the variance says.
    again = lobe.trace("built-in:ball", sky, samples=256, seed=1, **SMALL)
    seen = truth.variance[..., 1] + again.variance[..., 1]
    z = (truth.mean - again.mean)[..., 1][seen > 0] / np.sqrt(seen[seen > 0])
    assert 0.7 < np.std(z) < 1.4, np.std(z)


def test_a_white_furnace_is_white():
    picture = lobe.trace("built-in:furnace", WHITE, samples=4, bounces=50, camera=lobe.Camera((0, 0, 0), (1, 0, 0)), **SMALL).mean
    assert picture.min() >= 0 and picture.max() < 1 + 1e-5


def test_the_background_is_the_light(baked):
    studio = lobe.EnvMap.bundled("studio")
    away = lobe.Camera((0, -50, 1), (0, -60, 1), fov=20)
    for picture in [lobe.render(baked, studio, camera=away, **SMALL), lobe.trace(baked, studio, camera=away, samples=64, **SMALL).mean]:
        expected = studio.radiance([0, -1, 0])
        np.testing.assert_allclose(picture[11:13, 15:17].mean(axis=(0, 1)), expected, rtol=0.3)


def test_a_background_is_nothing_a_color_or_the_light_that_lights(baked):
    sky = lobe.EnvMap.bundled("sunset")
    of = lambda background: lobe.render(baked, sky, background=background, **SMALL)  # noqa: E731
    clear, color = of("none"), of((0.5, 2.0, 0.25))
    assert clear.shape == (*color.shape[:2], 4), clear.shape
    alpha = clear[..., 3:]
    assert alpha.min() == 0 and alpha.max() == 1
    np.testing.assert_allclose(clear[..., :3] + (1 - alpha) * np.float32([0.5, 2.0, 0.25]), color, atol=1e-5)
    np.testing.assert_allclose(of("#ff0000")[0, 0], [1, 0, 0])
    behind = alpha[..., 0] == 0
    assert np.abs(of("light") - of("env"))[behind].max() > 0.01, "the map is not its expansion"
    for bad in ["sky", (1.0, 2.0), (1.0, -1.0, 0.0)]:
        with pytest.raises(ValueError, match="background: expected"):
            of(bad)


def test_a_traced_picture_has_the_backgrounds_of_a_rendered_one():
    sky = lobe.EnvMap.bundled("sunset")
    of = lambda background, light=sky: lobe.trace("built-in:ball", light, samples=4, background=background, **SMALL)  # noqa: E731
    clear, color, given = of("none"), of((0.5, 2.0, 0.25)), lobe.trace("built-in:ball", sky, samples=4, **SMALL)
    assert clear.mean.shape == (24, 32, 4) and color.mean.shape == clear.variance.shape == (24, 32, 3)
    np.testing.assert_array_equal(clear.mean[..., 3], clear.coverage)
    behind = 1 - clear.coverage[..., None]
    assert behind.min() == 0 and behind.max() == 1
    np.testing.assert_allclose(clear.mean[..., :3] + behind * np.float32([0.5, 2.0, 0.25]), color.mean, atol=1e-5)
    for name in ["env", "light"]:
        np.testing.assert_array_equal(of(name).mean, given.mean, err_msg=name)
    np.testing.assert_allclose(of("#ff0000", WHITE).mean[0, 0], [1, 0, 0])
    moment = lobe.MovingScene("built-in:three-objects").trace(sky, samples=4, background="none", **SMALL)
    assert moment.mean.shape == (24, 32, 4)
    with pytest.raises(ValueError, match="background: expected"):
        of("sky")


def test_the_error_over_surfaces_is_free_of_the_noise_of_its_reference():
    of = lambda seed: lobe.trace("built-in:ball", WHITE, samples=16, seed=seed, **SMALL)  # noqa: E731
    one, other, third = of(1), of(2), of(3)
    found = lobe.compare_surfaces(1.1 * one.mean, other, third)
    assert found.pixels == np.sum((other.coverage == 1) & (third.coverage == 1)) < one.coverage.size
    # A tenth too bright, and the noise of the picture itself.
    assert abs(found.relative_rms - 0.1) < 0.05 and abs(found.mean_ratio - 1.1) < 0.02, found
    assert lobe.compare_surfaces(0 * one.mean, other, third).dark > 0.9
    counted = (other.coverage == 1) & (third.coverage == 1)
    p, a, b = ((1.1 if k == 0 else 1.0) * x.mean[counted].astype(float) for k, x in enumerate((one, other, third)))
    expected = np.sqrt(np.mean((p - a) * (p - b)) / np.mean(a * b))
    assert found.relative_rms == pytest.approx(expected, rel=1e-5)
    with pytest.raises(ValueError, match="half: expected another seed"):
        lobe.compare_surfaces(one.mean, other, other)
    with pytest.raises(TypeError, match="picture: expected what lobe.trace returns"):
        lobe.compare_surfaces(one.mean, other.mean, third)
    with pytest.raises(ValueError, match="one size"):
        lobe.compare_surfaces(one.mean[1:], other, third)


def test_equal_pictures_do_not_differ_and_noise_is_measured():
    a = np.random.default_rng(0).random((16, 16, 3)).astype(np.float32)
    same = lobe.compare(a, a)
    assert same.rmse == 0 and same.psnr == np.inf and same.flip == 0
    b = a + np.float32(0.1)
    found = lobe.compare(b, a)
    assert abs(found.rmse - 0.1) < 1e-6 and abs(found.psnr - 20 * np.log10(a.max() / 0.1)) < 1e-3 and found.flip > 0


def test_pictures_are_apart_as_far_away_as_one_looks(tmp_path):
    a, b = np.random.default_rng(1).random((2, 24, 32, 3)).astype(np.float32)
    for path, picture in [("a.pfm", a), ("b.pfm", b)]:
        lobe.EnvMap(picture).save(tmp_path / path)
    for per_degree in [20.0, 67.0]:
        expected = lobe_json("compare", tmp_path / "a.pfm", tmp_path / "b.pfm", f"--pixels-per-degree {per_degree}")
        assert lobe.compare(a, b, pixels_per_degree=per_degree).flip == pytest.approx(expected["flip"], rel=1e-6)
    assert lobe.compare(a, b, for_display=True).flip != lobe.compare(a, b).flip
    with pytest.raises(ValueError, match="pixels_per_degree: expected a number above 0"):
        lobe.compare(a, b, pixels_per_degree=0)


def test_chance_explains_other_paths_and_not_another_light():
    one, other = (lobe.trace("built-in:ball", WHITE, samples=256, seed=seed, **SMALL) for seed in (1, 2))
    found = lobe.z_test(one, other)
    assert found.passes and one.degrees_of_freedom >= 5, found
    z = (one.mean - other.mean).astype(float) / np.sqrt(np.maximum(one.variance.astype(float) + other.variance, 1e-30))
    assert found.mean_z == pytest.approx(z.mean(axis=(0, 1)), abs=1e-4)
    brighter = lobe.trace("built-in:ball", lobe.Sh(1.02 * WHITE.coefficients), samples=256, seed=2, **SMALL)
    biased = lobe.z_test(brighter, one)
    assert not biased.passes and min(biased.p_bias) < 1e-3, biased
    with pytest.raises(ValueError, match="level: expected a probability"):
        lobe.z_test(one, other, level=1.0)
    with pytest.raises(TypeError, match="picture: expected what lobe.trace returns"):
        lobe.z_test(one.mean, other)


def test_what_cannot_be_shown_says_so(baked, tmp_path):
    for call, error, message in [
        (lambda: lobe.render(tmp_path / "none.glb", WHITE), OSError, "none.glb"),
        (lambda: lobe.render(baked, lobe.Sh(np.ones((2, 9)))), ValueError, "one function"),
        (lambda: lobe.render(baked, WHITE, width=0), ValueError, "width"),
        (lambda: lobe.render(baked, WHITE, camera=lobe.Camera(fov=180)), ValueError, "fov"),
        (lambda: lobe.render(baked, WHITE, camera=lobe.Camera(target=(0, 0, 0))), ValueError, "only with an eye"),
        (lambda: lobe.render(baked, WHITE, camera=lobe.Camera((0, 0, 1), (0, 0, 1))), ValueError, "another point"),
        (lambda: lobe.trace("built-in:ball", WHITE, samples=1), ValueError, "samples"),
        (lambda: lobe.compare(np.ones((2, 2, 3)), np.ones((2, 3, 3))), ValueError, "one size"),
        (lambda: lobe.compare(np.ones((2, 2)), np.ones((2, 2))), ValueError, "shape"),
    ]:
        with pytest.raises(error, match=message):
            call()


def test_tone_mapped_bytes_are_srgb_of_the_curve():
    light = np.random.default_rng(1).uniform(0, 4, (5, 7, 3))
    shown = np.clip(light * 2**-1.5, 0, 1)
    srgb = np.where(shown <= 0.0031308, 12.92 * shown, 1.055 * shown ** (1 / 2.4) - 0.055)
    found = lobe.tone_mapped(light, tone="clip", exposure=-1.5)
    assert found.dtype == np.uint8 and np.abs(found - np.round(255 * srgb)).max() <= 1
    assert lobe.tone_mapped(light).shape == light.shape
    *names, last = get_args(get_type_hints(lobe.tone_mapped)["tone"])
    for bad, message in [({"tone": "film"}, f"tone: expected {', '.join(names)} or {last}, found"), ({"exposure": 1e9}, "exposure: ")]:
        with pytest.raises(ValueError, match=message):
            lobe.tone_mapped(light, **bad)
