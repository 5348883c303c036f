"""Suns apart from the expansion of a light."""

import numpy as np
import pytest

import lobe

SMALL = {"width": 32, "height": 24}
BAKE = {"mode": "interreflected", "order": 3, "bake_samples": 64}


def sunny() -> lobe.EnvMap:
    """A gray sky with a sun of a few texels, towards (0.6, 0, 0.8)."""
    values = np.full((64, 128, 3), 0.4, dtype=np.float32)
    values[12:14, 63:65] = 2000.0
    return lobe.EnvMap(values)


def render(light, **options):
    return lobe.render("built-in:ball", light, **SMALL, **BAKE, **options)


def test_a_sun_of_the_map_is_the_sun_that_is_given_beside_the_rest():
    sky = sunny()
    sun = sky.sun()
    assert sun is not None
    apart, given = render(sky, background="none"), render(sun.rest, suns=[sun], background="none")
    np.testing.assert_allclose(given, apart, rtol=1e-4, atol=1e-4)
    smeared = render(sky, suns="none", background="none")
    assert np.abs(apart - smeared).max() > 0.1 * smeared.max()


def test_a_light_without_suns_is_lit_by_its_expansion_alone():
    gray = lobe.EnvMap(np.full((16, 32, 3), 0.5, dtype=np.float32))
    np.testing.assert_array_equal(render(gray), render(gray, suns="none"))
    # Behind the scene a map is no expansion.
    np.testing.assert_array_equal(render(gray, suns=2, background="none"), render(gray.project(8), background="none"))


def test_suns_are_read_from_a_file_and_what_is_none_is_refused(tmp_path):
    path, sky = tmp_path / "suns.json", sunny()
    sun = sky.sun()
    path.write_text(f'{{"direction": {sun.direction.tolist()}, "irradiance": {sun.irradiance.tolist()}, "diameter": {np.degrees(sun.angular_diameter)}}}')
    by_file, given = (render(sun.rest, suns=suns, background="none") for suns in (path, [sun]))
    np.testing.assert_allclose(by_file, given, rtol=1e-6, atol=1e-6)
    for suns, message in [("some", "suns: expected auto, none"), (1025, "suns: expected"), ([3], "suns: expected"), ("no.json", "suns: no.json")]:
        with pytest.raises((ValueError, TypeError), match=message):
            render(sky, suns=suns)
    with pytest.raises(ValueError, match="an expansion holds no suns"):
        render(sky.project(3), suns=1)
