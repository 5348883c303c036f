"""Integrals over environment maps and the options of each: identities, and the command."""

import numpy as np
import pytest

import lobe
from command import lobe_command, lobe_json
from oracles import directions

SKY = lobe.EnvMap.bundled("sunset")


def test_vector_irradiance_is_band_one_of_the_map_and_the_net_of_both_sides():
    e, c = SKY.vector_irradiance(), SKY.project(2).coefficients
    expected = np.sqrt(4 * np.pi / 3) * np.stack([-c[3], -c[1], c[2]], axis=-1)
    np.testing.assert_allclose(e, expected, rtol=1e-5)
    n = directions(10)
    np.testing.assert_allclose(n @ e.T, SKY.irradiance_at(n) - SKY.irradiance_at(-n), rtol=1e-3, atol=1e-2 * np.abs(e).max())


def test_the_command_finds_the_same_vector():
    told = lobe_json("env vector-irradiance bundled:sunset --normal 0.3,0.4,-1")
    np.testing.assert_array_equal(SKY.vector_irradiance(), told["vector"])
    for normal, name in [((0.3, 0.4, -1), "front"), ((-0.3, -0.4, 1), "back")]:
        np.testing.assert_array_equal(SKY.irradiance_at(normal), list(told["net"][0][name]))


def test_the_sum_over_texels_is_what_many_bands_come_to(tmp_path):
    n = directions(20)
    np.testing.assert_allclose(SKY.irradiance_at(n), SKY.project(40).convolve("cosine").eval(n), rtol=2e-2)
    brute = SKY.irradiance(width=8, height=4, method="brute-force")
    lobe_command("env irradiance bundled:sunset --method brute-force --size 4 -o", tmp_path / "e.pfm")
    np.testing.assert_array_equal(brute.texels, lobe.EnvMap.load(tmp_path / "e.pfm").texels)


@pytest.mark.parametrize("roughness", ["linear", "quadratic"])
def test_levels_are_the_map_blurred_by_the_lobe_of_their_roughness(roughness):
    cube = SKY.convert("cube", 32)
    levels = cube.prefilter(32, 4, roughness=roughness)
    assert [level.shape[1] for level in levels] == [32, 16, 8, 4]
    for k in range(1, 4):
        r = k / 3 if roughness == "linear" else 1 - np.sqrt(1 - k / 3)
        np.testing.assert_array_equal(levels[k].texels, cube.filter_lobe("ggx", r**2, levels[k].shape[1]).texels)


@pytest.mark.parametrize(
    "words, lobe_and_options",
    [
        ("--lobe phong:20", (("phong", 20.0), {})),
        ("--lobe blinn-phong:40 --tolerance 0.001", (("blinn-phong", 40.0), {"tolerance": 0.001})),
    ],
)
def test_the_command_makes_the_same_highlight_map(words, lobe_and_options, tmp_path):
    lobe_command("env prefilter bundled:sunset --size 8", words, "-o", tmp_path / "h.exr")
    (name, parameter), options = lobe_and_options
    found = SKY.filter_lobe(name, parameter, 8, **options)
    found.save(tmp_path / "found.exr")
    expected, back = (lobe.EnvMap.load(tmp_path / file) for file in ("h.exr", "found.exr"))
    np.testing.assert_array_equal(back.texels, expected.texels)


def test_the_command_finds_the_same_sun_by_the_same_criteria(tmp_path):
    criteria = {"max_radius": np.radians(4), "min_contrast": 5.0, "min_peak": 50.0}
    sun = SKY.sun(**criteria)
    told = lobe_json("env sun bundled:sunset --max-radius 4 --min-contrast 5 --min-peak 50 -o", tmp_path / "rest.pfm")
    np.testing.assert_array_equal(sun.direction, told["direction"])
    np.testing.assert_array_equal(sun.irradiance, told["irradiance"])
    np.testing.assert_array_equal(sun.radiance, told["radiance"])
    assert sun.texels == told["texels"] and np.degrees(sun.angular_diameter) == pytest.approx(told["diameter"], rel=1e-15)
    assert SKY.sun(min_peak=1e9) is None


def test_levels_of_engines_that_read_all_go_down_to_one_texel():
    levels = SKY.convert("cube", 8).prefilter(8, roughness="babylon")
    assert [level.shape[1] for level in levels] == [8, 4, 2, 1]


def test_exports_are_those_of_the_command(tmp_path):
    files = lobe.export(SKY, ["three", "blender"], tmp_path / "a", size=32, suns="none", name="bundled:sunset")
    lobe_command("export bundled:sunset --engine three,blender --size 32 --suns none -o", tmp_path / "b")
    assert len(files) == 8
    for file in files:
        other = tmp_path / "b" / file.relative_to(tmp_path / "a")
        assert file.read_bytes() == other.read_bytes(), file
    assert lobe.export(SKY, "mitsuba", tmp_path / "c", size=16)[0].name == "sky.exr"


def test_options_that_would_be_ignored_are_refused():
    for call, message in [
        (lambda: SKY.prefilter(16, roughness="cubic"), "roughness: expected linear, quadratic, babylon"),
        (lambda: SKY.prefilter(16, tolerance=1.0), "tolerance: expected 1e-06 to 0.1"),
        (lambda: SKY.filter_lobe("box", 1.0), "lobe: expected phong, blinn-phong or ggx"),
        (lambda: SKY.filter_lobe("ggx", 1.5), "parameter: expected 0.0 to 1.0"),
        (lambda: SKY.irradiance(3, method="brute-force"), "order: not of the method brute-force"),
        (lambda: SKY.irradiance(method="exact"), "method: expected sh or brute-force"),
        (lambda: lobe.export(SKY, "quake", "x"), "engine: expected one of three"),
        (lambda: lobe.export(SKY, "three", "x", size=100), "size: faces for engines have a power of two"),
        (lambda: lobe.export(SKY, "three", "x", suns="some"), "suns: expected auto"),
        (lambda: SKY.sun(max_radius=2.0), "max_radius: expected 0.0 to"),
    ]:
        with pytest.raises(ValueError, match=message):
            call()


@pytest.mark.nightly
def test_the_sheet_of_techniques_is_that_of_the_command(tmp_path):
    lobe_command("env show bundled:sunset --size 32 -o", tmp_path / "a.png")
    SKY.show(tmp_path / "b.png", 32)
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()
    panels = SKY.techniques(32)
    assert {panel.solid for panel in panels} == {"ball", "torus"}
    assert all(panel.picture.shape == (32, 32, 3) and np.isfinite(panel.picture).all() for panel in panels)
    errors = [panel.error for panel in panels if panel.error is not None]
    assert 0 < len(errors) < len(panels) and max(errors) < 1, errors
