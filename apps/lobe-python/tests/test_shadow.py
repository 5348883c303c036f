"""Files of what moves: the command's bytes, and what they hold."""

import numpy as np
import pytest

import lobe
from command import lobe_command, lobe_json

# Meshes without normals, of which their reader tells.
pytestmark = pytest.mark.filterwarnings("ignore::lobe.LoadNote")

FIELD = {"order": 3, "spheres": 3, "cells": 4, "rays": 64}


@pytest.mark.parametrize("storage", ["f32", "f16", "u8", "clustered"])
def test_the_field_is_that_of_the_command(storage, tmp_path):
    told = lobe_json("field built-in:ball --order 3 --spheres 3 --cells 4 --rays 64 --range 0.5,4 --storage", storage, "-o", tmp_path / "a.safetensors")
    report = lobe.field("built-in:ball", tmp_path / "b.safetensors", storage=storage, range=(0.5, 4), **FIELD)
    assert (tmp_path / "b.safetensors").read_bytes() == (tmp_path / "a.safetensors").read_bytes()
    assert {key: report[key] for key in ("points", "inside", "rays")} == {key: told[key] for key in ("points", "inside", "rays")}
    assert {key: report[key] for key in told["storage"]} == told["storage"]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.safetensors", "b.safetensors"], "no checkpoint is left"


def test_the_field_and_the_visibility_of_an_entity_are_those_of_the_command(tmp_path):
    figure, options = "built-in:walking-figure", "--entity figure --order 3 --rays 4"
    a, b = tmp_path / "a.safetensors", tmp_path / "b.safetensors"
    lobe_command("field", figure, options, "--spheres 3 --cells 4 -o", a)
    lobe.field(figure, b, entity="figure", order=3, spheres=3, cells=4, rays=4)
    assert b.read_bytes() == a.read_bytes()
    parts = [tmp_path / f"{number}.safetensors" for number in (1, 2)]
    for number, part in enumerate(parts, 1):
        lobe.field_shard(figure, part, (number, 2), entity="figure", order=3, spheres=3, cells=4, rays=4)
    lobe.field(figure, b, entity="figure", order=3, spheres=3, cells=4, rays=4, merge=parts)
    assert b.read_bytes() == a.read_bytes(), "of shards"
    lobe_command("field", figure, options, "--self-visibility -o", a)
    lobe.self_visibility(figure, b, entity="figure", order=3, rays=4)
    assert b.read_bytes() == a.read_bytes()
    with pytest.raises(ValueError, match="nobody"):
        lobe.field(figure, b, entity="nobody")
    with pytest.raises(TypeError, match="entity: expected a name"):
        lobe.field(figure, b, entity=3)


def test_a_field_that_was_stopped_goes_on(tmp_path):
    class Stopped(Exception):
        pass

    def stop(done, total):
        if 0 < done < total:
            raise Stopped(f"{done} of {total}")

    options = {**FIELD, "rays": 256, "spheres": 8}
    with pytest.raises(Stopped):
        lobe.field("built-in:ball", tmp_path / "a.safetensors", progress=stop, **options)
    assert [path.name for path in tmp_path.iterdir()] == ["a.safetensors.checkpoint"]
    seen = []
    lobe.field("built-in:ball", tmp_path / "a.safetensors", progress=lambda done, total: seen.append(done), **options)
    assert seen[0] > 0, "it begins with what was done"
    lobe.field("built-in:ball", tmp_path / "b.safetensors", **options)
    assert (tmp_path / "a.safetensors").read_bytes() == (tmp_path / "b.safetensors").read_bytes()


@pytest.mark.parametrize("storage", ["f32", "f16", "u8", "clustered"])
def test_self_visibility_is_that_of_the_command(storage, tmp_path):
    mesh = octahedron(tmp_path)
    told = lobe_json("field", mesh, "--self-visibility --order 3 --rays 64 --seed 2 --storage", storage, "-o", tmp_path / "a.safetensors")
    report = lobe.self_visibility(mesh, tmp_path / "b.safetensors", order=3, rays=64, seed=2, storage=storage)
    assert (tmp_path / "b.safetensors").read_bytes() == (tmp_path / "a.safetensors").read_bytes()
    assert {key: report[key] for key in ("vertices", "rays")} == {key: told[key] for key in ("vertices", "rays")}
    assert {key: report[key] for key in told["storage"]} == told["storage"]
    assert len(list(tmp_path.iterdir())) == 3, "no checkpoint is left beside the mesh and both files"


@pytest.mark.parametrize("storage", ["f16", "u8", "clustered"])
def test_a_lamp_is_stored_as_by_the_command(storage, tmp_path):
    options = "--size 2,1 --order 2 --spheres 3 --cells 4 --storage"
    told = lobe_json("lamp rectangle", options, storage, "-o", tmp_path / "a.safetensors")
    size = lobe.lamp("rectangle", tmp_path / "b.safetensors", size=(2, 1), order=2, spheres=3, cells=4, storage=storage)
    assert (tmp_path / "b.safetensors").read_bytes() == (tmp_path / "a.safetensors").read_bytes()
    assert size == told["bytes"]


def octahedron(folder):
    """A closed mesh, stretched."""
    corners = [(2, 0, 0), (-2, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)]
    faces = [(a, b, c) if sign > 0 else (b, a, c) for a, b, c, sign in OCTANTS]
    lines = [f"v {x} {y} {z}" for x, y, z in corners] + [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in faces]
    (folder / "o.obj").write_text("\n".join(lines))
    return folder / "o.obj"


OCTANTS = [(x, 2 + y, 4 + z, (-1) ** (x + y + z)) for x in (0, 1) for y in (0, 1) for z in (0, 1)]


@pytest.mark.parametrize("method", ["variational", "medial-axis"])
def test_the_spheres_are_those_of_the_command(method, tmp_path):
    mesh = octahedron(tmp_path)
    told = lobe_json("spheres", mesh, "-n 4 --points 600 --seed 3 --method", method, "-o", tmp_path / "a.safetensors")
    found = lobe.spheres(mesh, 4, tmp_path / "b.safetensors", points=600, seed=3, method=method)
    # A third of the product of the half axes, four times.
    assert abs(found.solid_volume - 4 / 3 * 2) < 1e-6, found
    assert (tmp_path / "b.safetensors").read_bytes() == (tmp_path / "a.safetensors").read_bytes()
    np.testing.assert_allclose(found.centers, [sphere["center"] for sphere in told["spheres"]], rtol=1e-6, atol=1e-7)
    np.testing.assert_allclose(found.radii, [sphere["radius"] for sphere in told["spheres"]], rtol=1e-6)
    for name in ("outside_volume", "union_volume", "solid_volume", "history", "certainty"):
        np.testing.assert_array_equal(getattr(found, name), told[name], err_msg=name)
    alone = lobe.spheres(mesh, 4, points=600, seed=3, method=method)
    np.testing.assert_array_equal(alone.centers, found.centers)


def test_the_spheres_of_an_entity_follow_its_joints(tmp_path):
    lobe_command("spheres built-in:walking-figure --entity figure -n 6 --points 600 -o", tmp_path / "a.safetensors")
    lobe.spheres("built-in:walking-figure", 6, tmp_path / "b.safetensors", entity="figure", points=600)
    assert (tmp_path / "b.safetensors").read_bytes() == (tmp_path / "a.safetensors").read_bytes()


def test_the_table_is_that_of_the_command(tmp_path):
    lobe_command("spheres table --order 3 --window 6 --clamp 0.05 -o", tmp_path / "a.safetensors")
    rows = lobe.sphere_table(tmp_path / "b.safetensors", order=3, window=6.0, clamp=0.05)
    assert (tmp_path / "b.safetensors").read_bytes() == (tmp_path / "a.safetensors").read_bytes() and rows > 0


def test_lamps_are_those_of_the_command(tmp_path):
    a, b = tmp_path / "a.safetensors", tmp_path / "b.safetensors"
    lobe_command("lamp sphere --radius 0.5 --radiance 1,2,3 --order 3 -o", a)
    assert lobe.lamp("sphere", b, radius=0.5, radiance=(1, 2, 3), order=3) == 0
    assert a.read_bytes() == b.read_bytes()
    lobe_command("lamp rectangle --size 2,1 --two-sided --order 2 --spheres 3 --cells 4 --range 0.5,4 -o", a)
    lobe.lamp("rectangle", b, size=(2, 1), two_sided=True, order=2, spheres=3, cells=4, range=(0.5, 4))
    assert a.read_bytes() == b.read_bytes()


@pytest.mark.parametrize("count", [1, 3])
def test_lamps_show_the_pictures_of_the_command(count, tmp_path):
    a, b = tmp_path / "a.safetensors", tmp_path / "b.safetensors"
    pictures = [np.random.default_rng(k).random((6, 12, 3)).astype(np.float32) for k in range(count)]
    for k, picture in enumerate(pictures):
        lobe.EnvMap(picture).save(tmp_path / f"{k}.pfm")
    files = [tmp_path / f"{k}.pfm" for k in range(count)]
    fps = "--fps 5" if count > 1 else ""
    told = lobe_json(
        "lamp rectangle --size 2,1 --order 2 --spheres 3 --cells 4 --patches 4,2 --radiance 2,1,0.5", fps, "-o", a, "--pictures", *files
    )
    bytes_of_numbers = lobe.lamp(
        "rectangle", b, size=(2, 1), order=2, spheres=3, cells=4, patches=(4, 2), radiance=(2, 1, 0.5), pictures=pictures, fps=5
    )
    assert a.read_bytes() == b.read_bytes() and told["bytes"] == bytes_of_numbers


def test_what_cannot_be_made_is_refused(tmp_path):
    out = tmp_path / "o.safetensors"
    for call, error, message in [
        (lambda: lobe.field("built-in:ball", tmp_path / "o.glb"), ValueError, "output: expected a name that ends in .safetensors"),
        (lambda: lobe.field("built-in:moon", out), ValueError, "there is no such scene"),
        (lambda: lobe.field("built-in:ball", out, cells=3), ValueError, "cells: expected an even number"),
        (lambda: lobe.field("built-in:ball", out, range=(2, 1)), ValueError, "range: expected radii above 0 that rise"),
        (lambda: lobe.field("built-in:ball", out, storage="f8"), ValueError, "storage: expected f32"),
        (lambda: lobe.field("built-in:ball", tmp_path / "none" / "o.safetensors"), OSError, "o.safetensors"),
        (lambda: lobe.spheres("built-in:ball", 4), ValueError, "built-in:ball: expected a mesh around a volume"),
        (lambda: lobe.spheres("built-in:ball", 0), ValueError, "count: expected a number of spheres from 1 to 4096"),
        (lambda: lobe.spheres("built-in:ball", 4, rounds=3, method="medial-axis"), ValueError, "rounds: only of method variational"),
        (lambda: lobe.spheres("built-in:walking-figure", 4, entity="nobody"), ValueError, "nobody"),
        (lambda: lobe.sphere_table(out, order=9), ValueError, "order: expected 1 to 8"),
        (lambda: lobe.lamp("sphere", out), ValueError, "sphere: expected a radius alone"),
        (lambda: lobe.lamp("rectangle", out, radius=1.0, size=(1, 1)), ValueError, "rectangle: expected a size alone"),
        (lambda: lobe.lamp("rectangle", out, size=(1, 0)), ValueError, "size: expected a number above 0"),
        (lambda: lobe.lamp("rectangle", out, size=(1, 1), pictures=[np.ones((2, 2))]), ValueError, "picture: expected an array of shape"),
        (lambda: lobe.lamp("cone", out, radius=1.0), ValueError, "shape: expected sphere or rectangle"),
    ]:
        with pytest.raises(error, match=message):
            call()
    assert not list(tmp_path.iterdir()), "nothing is left behind"
