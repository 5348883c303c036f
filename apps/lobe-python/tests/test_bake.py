"""Bakes against the command's bytes, closed forms, and each other."""

import itertools
import os
import shutil
import subprocess

import numpy as np
import pytest

import lobe

# Meshes without normals, of which their reader tells.
pytestmark = pytest.mark.filterwarnings("ignore::lobe.LoadNote")

QUICK = lobe.BakeOptions(mode="shadowed", order=3, samples=16)

# A square of two triangles in the plane z = 0 of a file whose y points up, and a roof over a half of it.
OBJ = """v -1 0 -1
v 1 0 -1
v 1 0 1
v -1 0 1
v 0 1 -9
v 9 1 -9
v 9 1 9
v 0 1 9
f 1 4 3
f 1 3 2
f 5 8 7
f 5 7 6
"""


@pytest.fixture
def scene(tmp_path):
    path = tmp_path / "roof.obj"
    path.write_text(OBJ)
    return path


def test_an_open_plane_has_the_cosine(tmp_path):
    flat = tmp_path / "flat.obj"
    flat.write_text("v -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\nf 1 4 3\nf 1 3 2\n")
    report = lobe.bake(flat, tmp_path / "o.safetensors", lobe.BakeOptions(mode="unshadowed", order=3))
    assert report["receivers"] == 2, "triangles, to which vertices are fitted"
    transfer = lobe.Transfer(tmp_path / "o.safetensors")
    assert transfer.order == 3 and len(transfer) == 4
    # A constant sky of radiance 1: a white surface sends 1 back, one of another albedo as much.
    sky = lobe.Sh([np.sqrt(4 * np.pi)])
    sent = transfer.exit_radiance(sky)
    assert np.ptp(sent) < 1e-6 and 0.2 < sent[0, 0] <= 1 + 1e-6
    # Under a sun straight up 17/16 of the cosine at order 3, and it is the same from transfer as from irradiance.
    sun = lobe.Sh([0, 0, 1.0, 0, 0, 0, 1.0, 0, 0])
    expected = sun.convolve("cosine").eval([0, 0, 1]) / np.pi * sent[0, 0]
    np.testing.assert_allclose(transfer.exit_radiance(sun)[:, 1], expected, rtol=1e-5)


def test_shadows_fall_under_the_roof(scene, tmp_path):
    lobe.bake(scene, tmp_path / "o.glb", lobe.BakeOptions(mode="shadowed", samples=256))
    lit = lobe.Transfer(tmp_path / "o.glb").exit_radiance(lobe.Sh([1.0]))[:, 0]
    assert lit.min() < 0.5 * lit.max()


def test_shards_that_do_not_belong_together_are_refused_by_name(scene, tmp_path):
    parts = [tmp_path / f"{i}.safetensors" for i in (1, 2, 3)]
    for i, part in enumerate(parts, 1):
        lobe.bake(scene, part, QUICK, shard=(i, 3))
    other = tmp_path / "other.safetensors"
    lobe.bake(scene, other, lobe.BakeOptions(mode="shadowed", order=3, samples=32), shard=(3, 3))
    cut = tmp_path / "cut.safetensors"
    cut.write_bytes(parts[2].read_bytes()[:-40])
    before = set(os.listdir(tmp_path))
    for given, message in [
        (parts[:2], "3"),
        ([*parts, parts[0]], "1.safetensors"),
        ([*parts[:2], other], "other.safetensors"),
        ([*parts[:2], cut], "cut.safetensors"),
        ([*parts[:2], scene], "roof.obj"),
        ([], "merge: expected paths of files, one or more"),
    ]:
        with pytest.raises((ValueError, OSError), match=message):
            lobe.merge(scene, given, tmp_path / "o.glb", QUICK)
    with pytest.raises(ValueError, match="output: .*1.safetensors is an input, which would be lost"):
        lobe.merge(scene, parts, parts[0], QUICK)
    with pytest.raises(ValueError, match="1.safetensors: this shard and the others are not of this work"):
        lobe.merge(scene, parts, tmp_path / "o.glb", lobe.BakeOptions(mode="shadowed", order=3, samples=64))
    assert set(os.listdir(tmp_path)) == before, "nothing is written"


def test_a_bake_that_was_stopped_goes_on(tmp_path):
    options = lobe.BakeOptions(mode="shadowed", order=3, samples=256)
    scene = "built-in:ball"
    lobe.bake(scene, tmp_path / "whole.safetensors", options)

    class Enough(Exception):
        pass

    calls = itertools.count()

    def stop(done, total):
        assert 0 <= done <= total
        if next(calls) > 1:
            raise Enough

    with pytest.raises(Enough):
        lobe.bake(scene, tmp_path / "o.safetensors", options, progress=stop)
    assert not (tmp_path / "o.safetensors").exists() and (tmp_path / "o.safetensors.checkpoint").exists()
    lobe.bake(scene, tmp_path / "o.safetensors", options)
    assert (tmp_path / "o.safetensors").read_bytes() == (tmp_path / "whole.safetensors").read_bytes()
    assert not (tmp_path / "o.safetensors.checkpoint").exists()


def test_what_cannot_be_baked_says_so(scene, tmp_path):
    (tmp_path / "bad.glb").write_bytes(b"glTF")
    for call, error, message in [
        (lambda: lobe.bake(tmp_path / "none.glb", tmp_path / "o.glb"), OSError, "none.glb"),
        (lambda: lobe.bake(tmp_path / "bad.glb", tmp_path / "o.glb"), ValueError, "bad.glb"),
        (lambda: lobe.bake("built-in:moon", tmp_path / "o.glb"), ValueError, "still-life"),
        (lambda: lobe.bake(scene, tmp_path / "o.png", QUICK), ValueError, "o.png"),
        (lambda: lobe.bake(scene, tmp_path / "no/o.glb", QUICK), OSError, "no"),
        (lambda: lobe.bake(scene, tmp_path / "o.glb", lobe.BakeOptions(mode="glossy", order=2, samples=4)), ValueError, "safetensors"),
        (lambda: lobe.bake(scene, tmp_path / "o.safetensors", QUICK, shard=(4, 3)), ValueError, "shard"),
        (lambda: lobe.BakeOptions(mode="magic"), ValueError, "interreflected"),
        (lambda: lobe.BakeOptions(order=9), ValueError, "order: expected an order .* from 1 to 8, found 9"),
        (lambda: lobe.BakeOptions(samples=0), ValueError, "samples"),
        (lambda: lobe.BakeOptions(energy_stop=2.0), ValueError, "energy"),
        (lambda: lobe.BakeOptions(albedo="full"), ValueError, "albedo"),
        (lambda: lobe.Transfer(scene), ValueError, "roof.obj"),
    ]:
        with pytest.raises(error, match=message):
            call()
    assert sorted(os.listdir(tmp_path)) == ["bad.glb", "roof.obj"], "nothing is left behind"


def test_no_result_replaces_the_scene(scene, tmp_path):
    baked = tmp_path / "baked.glb"
    lobe.bake(scene, baked, QUICK)
    before = baked.read_bytes()
    for write in [lobe.bake, lambda source, output, options: lobe.merge(source, [tmp_path / "part"], output, options)]:
        with pytest.raises(ValueError, match="which would be lost"):
            write(baked, baked, QUICK)
    assert baked.read_bytes() == before


def test_shards_of_another_bake_leave_a_stopped_one_alone(scene, tmp_path):
    lobe.bake(scene, tmp_path / "part.safetensors", QUICK, shard=(1, 1))
    (tmp_path / "o.safetensors.checkpoint").write_bytes(b"hours of rays")
    with pytest.raises(ValueError, match="not of this work"):
        lobe.merge("built-in:ball", [tmp_path / "part.safetensors"], tmp_path / "o.safetensors", QUICK)
    assert (tmp_path / "o.safetensors.checkpoint").read_bytes() == b"hours of rays"
    assert sorted(os.listdir(tmp_path)) == ["o.safetensors.checkpoint", "part.safetensors", "roof.obj"]


def test_what_progress_raises_at_the_end_reaches_the_caller(scene, tmp_path):
    def raises(done, total):
        if done == total:
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        lobe.bake(scene, tmp_path / "o.safetensors", QUICK, progress=raises)


def test_the_command_writes_the_same_bytes(scene, tmp_path):
    command = os.environ.get("LOBE") or shutil.which("lobe")
    if command is None:
        pytest.skip("the command lobe is not built: set LOBE to it")
    for name in ["a.glb", "a.safetensors"]:
        run = [command, "bake", scene.name, "-o", name, "--mode", "interreflected", "--order", "3", "--samples", "32", "--bounces", "2", "--quiet"]
        subprocess.run(run, check=True, cwd=tmp_path)
        expected = (tmp_path / name).read_bytes()
        lobe.bake(scene, tmp_path / f"b{name}", lobe.BakeOptions(order=3, samples=32, bounces=2))
        assert (tmp_path / f"b{name}").read_bytes() == expected, name


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (dict(max_edge=float("nan")), "max_edge: expected a number above 0, found"),
        (dict(texels=0), "texels: expected a number of texels from 1"),
        (dict(grid=(1, 2, 2)), "grid: expected 3 whole numbers from 2"),
        (dict(grid=(2, 2)), "grid: expected 3 whole numbers"),
        (dict(grid=(2, 2, 2), texels=4), "grid: not with texels"),
        (dict(grid=(2, 2, 2), grid_box=(0.0, 1.0)), "grid_box: expected 6 finite numbers"),
        (dict(grid_box=(0.0, 0.0, 0.0, 1.0, 1.0, 1.0)), "grid_box: only with grid"),
        (dict(texels=4, max_edge=1.0), "not at vertices"),
        (dict(mode="glossy", texels=4), "at vertices only"),
        (dict(mode="glossy", albedo="none"), "matrices never have the albedo"),
    ],
)
def test_options_that_do_not_fit_are_refused_before_anything_is_read(options, message):
    with pytest.raises(ValueError, match=message):
        lobe.BakeOptions(**options)
