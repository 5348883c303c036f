"""Pictures by every mode of the command, and by files of transfer alone."""

import numpy as np
import pytest

import lobe
from command import lobe_command

SKY = lobe.EnvMap.bundled("sunset").project(3).dering()
# Twice as wide as high, so that a picture is read back as a lat-long map.
SIZE = {"width": 32, "height": 16}
VIEW = "--size 32x16 --fov 40 --samples 4"


@pytest.fixture(scope="module")
def light(tmp_path_factory):
    path = tmp_path_factory.mktemp("light") / "sky.sh.json"
    SKY.save(path)
    return path


def commanded(scene, light, words, folder):
    lobe_command("render", words, scene, "--env", light, VIEW, "-o", folder / "p.exr")
    return lobe.EnvMap.load(folder / "p.exr", mapping="lat-long").texels


@pytest.mark.parametrize(
    "words, options",
    [
        ("irradiance", {"mode": "irradiance"}),
        ("baked --mode unshadowed --order 2 --bake-samples 16", {"mode": "unshadowed", "order": 2, "bake_samples": 16}),
        ("baked --mode shadowed --bake-samples 16", {"mode": "shadowed", "bake_samples": 16}),
        ("baked --mode interreflected --bake-samples 16 --bounces 1", {"mode": "interreflected", "bake_samples": 16, "bounces": 1}),
        (
            "baked --mode interreflected --bake-samples 16 --bounces 1 --surfaces gltf",
            {"mode": "interreflected", "bake_samples": 16, "bounces": 1, "surfaces": "gltf"},
        ),
        ("baked --mode glossy --order 2 --bake-samples 16", {"mode": "glossy", "order": 2, "bake_samples": 16}),
        ("baked --mode glossy --order 2 --bake-samples 16 --lobe phong:9", {"mode": "glossy", "order": 2, "bake_samples": 16, "lobe": "phong:9"}),
    ],
)
def test_every_mode_makes_the_picture_of_the_command(words, options, light, tmp_path):
    found = lobe.render("built-in:ball", SKY, **options, **SIZE)
    np.testing.assert_array_equal(found, commanded("built-in:ball", light, words, tmp_path))


@pytest.mark.nightly
def test_transfer_alone_lights_the_scene_that_it_was_baked_for(light, tmp_path):
    options = lobe.BakeOptions(order=3, samples=16, mode="shadowed", no_split=True)
    lobe.bake("built-in:ball", tmp_path / "b.glb", options)
    lobe.bake("built-in:ball", tmp_path / "b.safetensors", options)
    by_scene = lobe.render(tmp_path / "b.glb", SKY, **SIZE)
    by_file = lobe.render("built-in:ball", SKY, transfer=tmp_path / "b.safetensors", **SIZE)
    np.testing.assert_allclose(by_file, by_scene, rtol=1e-4, atol=1e-5)
    lobe.compress(tmp_path / "b.glb", tmp_path / "c.safetensors", clusters=16, components=9)
    compressed = lobe.render("built-in:ball", SKY, transfer=tmp_path / "c.safetensors", **SIZE)
    assert lobe.compare(compressed, by_scene).psnr > 40
    words = f"baked --mode shadowed --transfer {tmp_path / 'c.safetensors'}"
    np.testing.assert_array_equal(compressed, commanded("built-in:ball", light, words, tmp_path))


def test_matrices_and_lightmaps_make_the_pictures_of_the_command(light, tmp_path):
    lobe.bake("built-in:ball", tmp_path / "g.safetensors", lobe.BakeOptions(mode="glossy", order=2, samples=16))
    glossy = lobe.render("built-in:ball", SKY, mode="glossy", transfer=tmp_path / "g.safetensors", lobe="ggx:0.5", **SIZE)
    words = f"baked --mode glossy --lobe ggx:0.5 --transfer {tmp_path / 'g.safetensors'}"
    np.testing.assert_array_equal(glossy, commanded("built-in:ball", light, words, tmp_path))
    for name in ("l.exr", "l.safetensors"):
        lobe.bake("built-in:cornell", tmp_path / name, lobe.BakeOptions(texels=32, order=2, samples=8))
        lit = lobe.render("built-in:cornell", SKY, transfer=tmp_path / name, **SIZE)
        words = f"baked --mode interreflected --transfer {tmp_path / name}"
        np.testing.assert_array_equal(lit, commanded("built-in:cornell", light, words, tmp_path))


def test_what_contradicts_a_bake_is_refused(tmp_path):
    baked = tmp_path / "b.glb"
    lobe.bake("built-in:ball", baked, lobe.BakeOptions(order=2, samples=8, mode="shadowed"))
    for call, message in [
        (lambda: lobe.render(baked, SKY, mode="interreflected"), "b.glb was baked as shadowed, not as interreflected"),
        (lambda: lobe.render(baked, SKY, mode="shadowed", bake_samples=16), "b.glb is baked with 8, not with 16"),
        (lambda: lobe.render(baked, SKY, mode="shadowed", order=3), "b.glb was baked to order 2, not 3"),
        (lambda: lobe.render(baked, SKY, mode="truth"), "mode: expected unshadowed, shadowed"),
        (lambda: lobe.render(baked, SKY, mode="irradiance", order=2), "order, bake_samples and bounces: only of a mode with transfer"),
        (lambda: lobe.render(baked, SKY, mode="shadowed", lobe="ggx:0.3"), "lobe: only of mode glossy"),
        (lambda: lobe.render(baked, SKY, mode="glossy", lobe="box:1"), "lobe: expected phong:E"),
        (lambda: lobe.render(baked, SKY, mode="irradiance", transfer=baked), "only of a mode with transfer"),
    ]:
        with pytest.raises(ValueError, match=message):
            call()
