"""Compressed transfer and lobes: the command's bytes, and what is left of the light."""

import copy
import pickle

import numpy as np
import pytest

import lobe
from command import lobe_command, lobe_json

# Meshes without normals, of which their reader tells.
pytestmark = pytest.mark.filterwarnings("ignore::lobe.LoadNote")

SKY = lobe.EnvMap.bundled("sunset").project(4)
BAKE = lobe.BakeOptions(order=4, samples=32, mode="shadowed")


@pytest.fixture(scope="module")
def baked(tmp_path_factory):
    path = tmp_path_factory.mktemp("baked") / "b.glb"
    lobe.bake("built-in:ball", path, BAKE)
    return path


def test_compressed_transfer_is_that_of_the_command(baked, tmp_path):
    told = lobe_json("compress", baked, "--clusters 8 --components 3 --weights 8 -o", tmp_path / "a.safetensors")
    found = lobe.compress(baked, tmp_path / "b.safetensors", clusters=8, components=3, weights=8)
    assert (tmp_path / "a.safetensors").read_bytes() == (tmp_path / "b.safetensors").read_bytes()
    assert found == told


def test_transfer_in_16_bits_is_that_of_the_command_and_lights_as_the_nearest_numbers_do(baked, tmp_path):
    told = lobe_json("compress", baked, "--f16 -o", tmp_path / "a.safetensors")
    found = lobe.compress_f16(baked, tmp_path / "b.safetensors")
    assert (tmp_path / "a.safetensors").read_bytes() == (tmp_path / "b.safetensors").read_bytes()
    assert found == told and found["ratio"] == 2 and 0 < found["relative_error"] < 2**-11
    halves = lobe.Transfer(tmp_path / "b.safetensors")
    rounded = lobe.Transfer(baked).coefficients.astype(np.float16).astype(np.float32)
    np.testing.assert_array_equal(halves.coefficients, rounded)
    lit = np.einsum("vci,ic->vc" if rounded.ndim == 3 else "vi,ic->vc", rounded, SKY.coefficients)
    np.testing.assert_allclose(halves.exit_radiance(SKY), lit, rtol=1e-5, atol=1e-6)


def test_coefficients_that_16_bits_cannot_hold_are_refused_by_the_name_of_their_file(tmp_path):
    path = tmp_path / "large.safetensors"
    lobe.bake("built-in:ball", path, lobe.BakeOptions(order=2, samples=1, mode="unshadowed"))
    # The last number.
    path.write_bytes(path.read_bytes()[:-4] + np.float32(-70000).tobytes())
    with pytest.raises(ValueError, match=r"large\.safetensors: transfer of 16 bits: expected coefficients below 65520 in size, found -70000"):
        lobe.compress_f16(path, tmp_path / "o.safetensors")
    assert [file.name for file in tmp_path.iterdir()] == ["large.safetensors"], "nothing is left behind"


def test_the_error_is_that_of_the_light_and_falls_with_more_components(baked, tmp_path):
    exact = lobe.Transfer(baked)
    errors = []
    for components in (1, 4, 12):
        report = lobe.compress(baked, tmp_path / "c.safetensors", clusters=2, components=components, weights=32)
        short = lobe.Transfer(tmp_path / "c.safetensors")
        assert len(short) == len(exact) == report["receivers"] and short.coefficients is None
        off = short.exit_radiance(SKY) - exact.exit_radiance(SKY)
        errors.append((report["relative_error"], float(np.sqrt(np.mean(off**2)))))
    assert errors[0] > errors[1] > errors[2], errors
    assert errors[2][1] < 0.1 * errors[0][1], errors


@pytest.mark.nightly
def test_the_curve_is_that_of_the_command(baked, tmp_path):
    told = lobe_json("compress", baked, "--clusters 4 --components 2 --curve -o", tmp_path / "a.safetensors")["curve"]
    points = lobe.error_curve(baked, (1, 4), (0, 1, 2))
    assert [vars(point) for point in points] == told


@pytest.mark.parametrize("words, options", [("--lobes 2", {"lobes": 2}), ("--closed-form", {"closed_form": True})])
def test_lobes_are_those_of_the_command(words, options, baked, tmp_path):
    told = lobe_json("fit-lobes", baked, words, "-o", tmp_path / "a.safetensors")
    assert lobe.fit_lobes(baked, tmp_path / "b.safetensors", **options) == told
    assert (tmp_path / "a.safetensors").read_bytes() == (tmp_path / "b.safetensors").read_bytes()


@pytest.mark.parametrize("name", ["o.glb", "o.safetensors"])
def test_a_bake_that_is_compressed_has_the_bytes_of_the_command(name, tmp_path):
    (tmp_path / "a").mkdir()
    words = "--order 3 --samples 16 --mode shadowed --clusters 4 --components 2"
    lobe_command("bake built-in:ball", words, "-o", tmp_path / "a" / name)
    options = lobe.BakeOptions(order=3, samples=16, mode="shadowed", clusters=4, components=2)
    report = lobe.bake("built-in:ball", tmp_path / name, options)
    assert (tmp_path / name).read_bytes() == (tmp_path / "a" / name).read_bytes()
    assert report["compression"]["clusters"] == 4 and 0 < report["compression"]["relative_error"] < 1


def table(folder):
    """A floor with a board over a corner of it: where its shadow ends, transfer changes along edges."""
    corners = [
        (m + x, height, m + z) for m, half, height in ((0, 4, 0), (3.5, 1, 1)) for x in (-half, half) for z in (-half, half)
    ]
    lines = [f"v {x} {y} {z}" for x, y, z in corners] + ["f 1 2 4 3", "f 5 6 8 7"]
    (folder / "table.obj").write_text("\n".join(lines))
    return folder / "table.obj"


def test_a_bake_that_splits_where_transfer_changes_has_the_bytes_of_the_command(tmp_path):
    words = "--order 2 --samples 16 --mode shadowed --adaptive 0.01 --min-edge 0.3 --max-vertices 5000"
    scene = table(tmp_path)
    told = lobe_json("bake", scene, words, "-o", tmp_path / "a.glb")
    options = lobe.BakeOptions(order=2, samples=16, mode="shadowed", adaptive=0.01, min_edge=0.3, max_vertices=5000)
    report = lobe.bake(scene, tmp_path / "b.glb", options)
    assert (tmp_path / "b.glb").read_bytes() == (tmp_path / "a.glb").read_bytes()
    assert told["vertices"] == report["adaptive"]["vertices"] > report["adaptive"]["vertices_before"]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.glb", "b.glb", "table.obj"], "no checkpoint is left"


def test_splitting_that_was_stopped_goes_on(tmp_path):
    class Stopped(Exception):
        pass

    def stop(done, total):
        if 0 < done < total:
            raise Stopped

    scene = table(tmp_path)
    options = lobe.BakeOptions(order=2, samples=16, mode="shadowed", max_vertices=3000)
    with pytest.raises(Stopped):
        lobe.bake(scene, tmp_path / "a.glb", options, progress=stop)
    assert (tmp_path / "a.glb.checkpoint.split-0").exists() and not (tmp_path / "a.glb").exists()
    seen = []
    lobe.bake(scene, tmp_path / "a.glb", options, progress=lambda done, total: seen.append(done))
    assert seen[0] > 0, "it begins with what was done"
    lobe.bake(scene, tmp_path / "b.glb", options)
    assert (tmp_path / "a.glb").read_bytes() == (tmp_path / "b.glb").read_bytes()


def test_what_contradicts_itself_is_refused(baked, tmp_path):
    out = tmp_path / "o.safetensors"
    adaptive = lobe.BakeOptions(adaptive=0.1, max_vertices=3)
    for call, error, message in [
        (lambda: lobe.compress(baked, tmp_path / "o.glb"), ValueError, "expected a name that ends in .safetensors"),
        (lambda: lobe.compress_f16(baked, tmp_path / "o.glb"), ValueError, "expected a name that ends in .safetensors"),
        (lambda: lobe.compress(tmp_path / "none.glb", out), OSError, "none.glb"),
        (lambda: lobe.compress(baked, out, weights=4), ValueError, "weights: expected 8, 16 or 32 bits"),
        (lambda: lobe.compress(baked, out, clusters=0), ValueError, "clusters: expected 1 to 65536"),
        (lambda: lobe.fit_lobes(baked, out, lobes=9), ValueError, "lobes: expected 1 to 8"),
        (lambda: lobe.bake("built-in:ball", out, adaptive, shard=(1, 2)), ValueError, "max_vertices: expected at least the"),
        (lambda: lobe.BakeOptions(no_split=True, max_vertices=9), ValueError, "max_vertices: not with no_split"),
        (lambda: lobe.bake("built-in:ball", out, adaptive), ValueError, "max_vertices: expected at least the"),
        (lambda: lobe.BakeOptions(adaptive=-0.1), ValueError, "adaptive: expected a number above 0"),
        (lambda: lobe.BakeOptions(adaptive=0.1, texels=8), ValueError, "light is not at vertices"),
        (lambda: lobe.BakeOptions(mode="glossy", clusters=4), ValueError, "of transfer vectors only"),
    ]:
        with pytest.raises(error, match=message):
            call()
    assert not list(tmp_path.iterdir()), "nothing is left behind"


def test_transfer_of_every_form_is_sent_to_other_processes(baked, tmp_path):
    lobe.compress(baked, tmp_path / "c.safetensors", clusters=8, components=3, weights=8)
    lobe.compress_f16(baked, tmp_path / "h.safetensors")
    lobe.fit_lobes(baked, tmp_path / "z.safetensors", closed_form=True)
    for path in [baked, *(tmp_path / name for name in ("c.safetensors", "h.safetensors", "z.safetensors"))]:
        transfer = lobe.Transfer(path)
        sent = pickle.dumps(transfer)
        for again in [pickle.loads(sent), copy.deepcopy(transfer)]:
            assert (again.order, len(again), repr(again)) == (transfer.order, len(transfer), repr(transfer))
            np.testing.assert_array_equal(again.exit_radiance(SKY), transfer.exit_radiance(SKY), err_msg=str(path))
            if transfer.coefficients is not None:
                np.testing.assert_array_equal(again.coefficients, transfer.coefficients)
