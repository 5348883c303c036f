"""Transfer matrices against numpy, the command, and closed forms."""

import json
import os
import pickle
import subprocess

import numpy as np
import pytest

import lobe

SCENE = "built-in:ball"


def sky():
    return lobe.EnvMap.bundled("sunset").project(3)


def test_the_light_that_arrives_is_matrix_times_light(tmp_path):
    options = lobe.BakeOptions(mode="glossy", order=3, samples=64, bounces=1)
    lobe.bake(SCENE, tmp_path / "m.safetensors", options)
    matrices, light = lobe.Matrices(tmp_path / "m.safetensors"), sky()
    c = matrices.coefficients.astype(np.float64)
    assert matrices.order == 3 and len(matrices) == len(c) and matrices.grid is None
    c = c[:, None] if c.ndim == 3 else c
    expected = np.einsum("pcij,jc->pic", np.broadcast_to(c, (len(c), 3, 9, 9)), np.asarray(light))
    found = np.asarray(matrices.incident(light))
    np.testing.assert_allclose(found, expected, rtol=1e-4, atol=1e-4 * np.abs(expected).max())
    with pytest.raises(ValueError, match="expected matrices of a grid"):
        matrices.incident_at(light, [0, 0, 0])
    again = pickle.loads(pickle.dumps(matrices))
    assert again.grid is None and repr(again) == repr(matrices), "sent to another process"
    np.testing.assert_array_equal(again.coefficients, matrices.coefficients)


def test_far_from_everything_the_light_arrives_as_it_is(tmp_path):
    box = (-2000, -2000, 1000, 2000, 2000, 3000)
    lobe.bake(SCENE, tmp_path / "g.safetensors", lobe.BakeOptions(order=3, samples=4096, grid=(2, 2, 2), grid_box=box))
    grid, light = lobe.Matrices(tmp_path / "g.safetensors", grid=True), sky()
    counts, corners = grid.grid
    assert tuple(counts) == (2, 2, 2) and corners.ravel().tolist() == list(box)
    places = np.random.default_rng(0).uniform(corners[0], corners[1], (4, 5, 3))
    found = grid.incident_at(light, places)
    assert found.shape == (4, 5) and found.order == 3
    # Quadrature by 4096 directions, of functions of order 5.
    scale = np.abs(np.asarray(light)).max()
    np.testing.assert_allclose(np.asarray(found), np.broadcast_to(np.asarray(light), (4, 5, 9, 3)), atol=0.01 * scale)
    again = pickle.loads(pickle.dumps(grid))
    np.testing.assert_array_equal(again.incident_at(light, places).coefficients, found.coefficients, err_msg="sent to another process")
    at_a_point = np.asarray(grid.incident_at(light, corners[0]))
    np.testing.assert_allclose(at_a_point, np.asarray(grid.incident(light))[0], rtol=1e-5, atol=1e-5 * scale)


def test_a_file_of_another_kind_is_refused(tmp_path):
    lobe.bake(SCENE, tmp_path / "t.safetensors", lobe.BakeOptions(order=2, samples=16))
    for grid in [False, True]:
        with pytest.raises(ValueError, match="t.safetensors: "):
            lobe.Matrices(tmp_path / "t.safetensors", grid=grid)


def test_peaks_are_those_of_the_command(tmp_path):
    f = sky()
    f_json = {"format": "lobe-sh", "version": 1, "order": 3, "quantity": "radiance", "coefficients": np.asarray(f).tolist()}
    (tmp_path / "f.sh.json").write_text(json.dumps(f_json))
    lobe_command = os.environ.get("LOBE")
    if lobe_command is None:
        pytest.skip("LOBE names no command to compare with")
    printed = subprocess.run([lobe_command, "sh", "peaks", tmp_path / "f.sh.json", "--json"], capture_output=True, check=True).stdout
    expected = json.loads(printed)["peaks"]
    directions, values = f.peaks()
    assert len(values) == len(expected) > 0
    np.testing.assert_allclose(values, [peak["value"] for peak in expected], rtol=1e-6)
    np.testing.assert_allclose(directions, [peak["dir"] for peak in expected], atol=1e-5)
    _, of_paper = f.peaks("paper")
    np.testing.assert_allclose(of_paper[0], values[0], rtol=1e-6)
    along_z = lobe.Sh(np.array([0.0, 0.0, 1.0, 0.0]))
    np.testing.assert_allclose(along_z.peaks()[0], [[0, 0, 1]], atol=1e-7)
    assert lobe.Sh(np.ones(1)).peaks()[1].shape == (0,), "the same everywhere"


@pytest.mark.parametrize("kind", [1, 5, 12, 16])
def test_skies_of_the_cie_are_those_of_the_command(kind, tmp_path):
    lobe_command = os.environ.get("LOBE")
    if lobe_command is None:
        pytest.skip("LOBE names no command to compare with")
    sun, out = "0.5,0.1,0.8", tmp_path / "s.exr"
    subprocess.run(
        [lobe_command, "-q", "env", "sky", "--model", "cie", "--type", str(kind), "--sun", sun, "--size", "32", "-o", out], check=True
    )
    made = lobe.EnvMap.cie_sky(kind, [0.5, 0.1, 0.8], height=32)
    np.testing.assert_allclose(made.texels, lobe.EnvMap.load(out).texels, rtol=1e-6)


# What a cropped panorama shows is noted.
@pytest.mark.filterwarnings("ignore::lobe.LoadNote")
def test_a_file_is_read_as_the_options_say(tmp_path):
    texels = np.random.default_rng(0).random((8, 8, 3), dtype=np.float32)
    lobe.EnvMap(texels, "octahedral").save(tmp_path / "o.exr")
    assert lobe.EnvMap.load(tmp_path / "o.exr").mapping == "octahedral", "the file tells"
    assert lobe.EnvMap.load(tmp_path / "o.exr", mapping="equal-area").mapping == "equal-area", "the caller knows better"
    with pytest.raises(ValueError, match="8 x 8, more than the limit of 63 texels"):
        lobe.EnvMap.load(tmp_path / "o.exr", max_texels=63)
    with pytest.raises(ValueError, match="more than the limit of 700"):
        lobe.EnvMap.load(tmp_path / "o.exr", max_bytes=700)
    cropped = lobe.EnvMap.load(tmp_path / "o.exr", elevations=(-np.pi / 6, np.pi / 6), padding="edge")
    assert cropped.mapping == "lat-long" and cropped.radiance([0, 0, 1]).min() > 0
    black = lobe.EnvMap.load(tmp_path / "o.exr", elevations=(-np.pi / 6, np.pi / 6))
    assert black.radiance([0, 0, 1]).max() == 0
    lobe.EnvMap(texels, "octahedral").save(tmp_path / "round.pfm")
    sky = lobe.EnvMap.load(tmp_path / "round.pfm", fisheye="equisolid", fisheye_circle=(4, 4, 3.5))
    assert sky.mapping == "lat-long" and sky.radiance([0, 0, 1]).min() > 0 and sky.radiance([0, 0, -1]).max() == 0
    ground = lobe.EnvMap.load(tmp_path / "round.pfm", fisheye="equisolid", fisheye_axis=(0, 0, -1), padding="edge")
    assert ground.radiance([0, 0, 1]).min() > 0
    with pytest.raises(ValueError, match="at most 180°"):
        lobe.EnvMap.load(tmp_path / "round.pfm", fisheye="orthographic", fisheye_fov=4.0)
    with pytest.raises(ValueError, match="is octahedral"):
        lobe.EnvMap.load(tmp_path / "o.exr", fisheye="equisolid")
    for name, value in [("fisheye_fov", 2.0), ("fisheye_axis", (1, 0, 0)), ("fisheye_circle", (4, 4, 3.5))]:
        with pytest.raises(ValueError, match=f"{name}: only with fisheye"):
            lobe.EnvMap.load(tmp_path / "round.pfm", **{name: value})
    for circle in [(4, 4), (4, 4, 3, 5), 4]:
        with pytest.raises(ValueError, match="fisheye_circle: expected column, row and radius"):
            lobe.EnvMap.load(tmp_path / "round.pfm", fisheye="equisolid", fisheye_circle=circle)
    with pytest.raises(ValueError, match="expected one of equidistant, equisolid"):
        lobe.EnvMap.load(tmp_path / "o.exr", fisheye="round")
    with pytest.raises(ValueError, match="padding: expected black or edge"):
        lobe.EnvMap.load(tmp_path / "o.exr", padding="white")
