"""The reader of the page of formats, which has the standard library alone, on files that the command has just written."""

import importlib.util
import itertools
import math
import os
import pathlib
import shutil
import subprocess

import pytest

READER = pathlib.Path(__file__).parents[3] / "docs/guide/src/read_by_hand.py"


@pytest.fixture(scope="module")
def reader():
    spec = importlib.util.spec_from_file_location("read_by_hand", READER)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def lobe(tmp_path):
    command = os.environ.get("LOBE") or shutil.which("lobe")
    if command is None:
        pytest.skip("the command lobe is not built: set LOBE to it")
    return lambda *arguments: subprocess.run([command, "--quiet", *map(str, arguments)], check=True, cwd=tmp_path)


def write_ball(path, rows=32):
    """A ball of radius 1, as triangles between meridians and parallels."""
    corner = lambda i, j: (math.pi * i / rows, math.pi * j / rows)
    with open(path, "w", encoding="ascii") as file:
        for i in range(rows + 1):
            for j in range(2 * rows):
                theta, phi = corner(i, j)
                x, y, z = math.sin(theta) * math.cos(phi), math.cos(theta), math.sin(theta) * math.sin(phi)
                print("v", x, y, z, file=file)
        for i in range(rows):
            for j in range(2 * rows):
                a, b = 2 * rows * i + j + 1, 2 * rows * i + (j + 1) % (2 * rows) + 1
                print("f", a, b, b + 2 * rows, a + 2 * rows, file=file)


@pytest.mark.parametrize("storage", ["f32", "f16", "u8", "clustered"])
def test_a_field_of_a_ball_hides_its_cone(reader, lobe, tmp_path, storage):
    write_ball(tmp_path / "ball.obj")
    lobe("field", "ball.obj", "-o", "f.safetensors", "--order", 3, "--spheres", 8, "--cells", 4, "--storage", storage)
    about, tensors = reader.read_safetensors(tmp_path / "f.safetensors")
    for point in [[0, 0, 3.0], [2.0, -1.5, 0.5], [-20.0, 5.0, 8.0]]:
        r = math.hypot(*point)
        found = reader.visibility(about, tensors, point)
        cosine = math.sqrt(1 - 1 / r**2)
        hidden = [2 * math.pi * x for x in (1 - cosine, (1 - cosine**2) / 2, (cosine - cosine**3) / 2)]
        y = reader.basis(3, [-c / r for c in point])
        for i, (a, b) in enumerate(zip(found, y)):
            expected = (math.sqrt(4 * math.pi) if i == 0 else 0) - hidden[math.isqrt(i)] * b
            # Rays, the interpolation of eight spheres, and the clusters of the last storage.
            assert a == pytest.approx(expected, abs=0.03 * hidden[0]), (storage, point, i)


def test_a_lamp_fills_its_solid_angle(reader, lobe, tmp_path):
    radiance = [3.0, 2.0, 1.0]
    lobe("lamp", "sphere", "--radius", 0.5, "--radiance", "3,2,1", "--order", 5, "-o", "ball.safetensors")
    lobe("lamp", "rectangle", "--size", "2,1", "--radiance", "3,2,1", "--order", 3, "-o", "rectangle.safetensors")
    for r in (1.5, 4.0, 30.0):
        ball = reader.shining(*reader.read_safetensors(tmp_path / "ball.safetensors"), [0.0, 0.6 * r, 0.8 * r])
        rectangle = reader.shining(*reader.read_safetensors(tmp_path / "rectangle.safetensors"), [1e-9, 0.0, r])
        of_ball = 2 * math.pi * (1 - math.sqrt(1 - 0.25 / r**2))
        of_rectangle = 4 * math.asin(0.5 / math.sqrt((1 + r * r) * (0.25 + r * r)))
        for c, color in enumerate(radiance):
            assert ball[c][0] == pytest.approx(color * of_ball * math.sqrt(0.25 / math.pi), rel=1e-5)
            assert rectangle[c][0] == pytest.approx(color * of_rectangle * math.sqrt(0.25 / math.pi), rel=0.01)
        behind = reader.shining(*reader.read_safetensors(tmp_path / "rectangle.safetensors"), [1e-9, 0.0, -r])
        assert all(x == 0 for color in behind for x in color), "a panel sends no light behind its plane"


@pytest.mark.parametrize("storage", ["f16", "u8", "clustered"])
@pytest.mark.parametrize("shape", ["still", "sequence"])
def test_a_lamp_of_any_storage_is_that_of_single_precision(reader, lobe, tmp_path, storage, shape):
    options = ["--size", "2,1", "--order", 3, "--spheres", 5, "--cells", 4]
    if shape == "sequence":
        for k, brightness in enumerate([b"\x00\x00\x00\x3f", b"\x00\x00\x00\x40"]):
            (tmp_path / f"{k}.pfm").write_bytes(b"PF\n1 1\n-1.0\n" + 3 * brightness)
        options += ["--pictures", "0.pfm", "1.pfm", "--patches", "2,1"]
    lobe("lamp", "rectangle", *options, "-o", "whole.safetensors")
    lobe("lamp", "rectangle", *options, "--storage", storage, "-o", "stored.safetensors")
    for point in [[0.1, 0.2, 1.5], [-3.0, 1.0, 2.0], [4.0, 20.0, 9.0]]:
        whole, stored = (
            reader.shining(*reader.read_safetensors(tmp_path / f"{name}.safetensors"), point, 0.0)
            for name in ("whole", "stored")
        )
        for a, b in zip(whole, stored):
            # Eight bits of the range of each number, or four components of it.
            assert b == pytest.approx(a, abs=0.05 * max(map(abs, a))), (storage, point)


CUBE = """
v -1 -1 -1
v 1 -1 -1
v -1 1 -1
v 1 1 -1
v -1 -1 1
v 1 -1 1
v -1 1 1
v 1 1 1
f 1 3 4 2
f 5 6 8 7
f 1 2 6 5
f 3 7 8 4
f 1 5 7 3
f 2 4 8 6
"""


@pytest.mark.parametrize("storage", ["f32", "f16", "u8", "clustered"])
def test_corners_of_a_cube_see_what_its_faces_see(reader, lobe, tmp_path, storage):
    (tmp_path / "cube.obj").write_text(CUBE)
    options = ["--self-visibility", "--order", 2, "--rays", 1024, "--storage", storage]
    lobe("field", "cube.obj", *options, "-o", "own.safetensors")
    about, tensors = reader.read_safetensors(tmp_path / "own.safetensors")
    rows = reader.own_visibility(about, tensors)
    assert about["format"] == "lobe-visibility" and len(rows) == 8
    for row in rows:
        # Each face sees half of the sphere.
        assert row[0] == pytest.approx(2 * math.pi * math.sqrt(0.25 / math.pi), rel=0.01)
    for values in list(zip(*rows, strict=True))[1:]:
        # Of y_1m two faces see pi either way, the other four 0: the nearest linear function has 3/5 of it at their corners.
        # Diagonals of faces, which differ, move some of it from corner to corner.
        mean = sum(map(abs, values)) / 8
        assert mean == pytest.approx(0.6 * math.pi * math.sqrt(0.75 / math.pi), rel=0.1)
    assert {tuple(value > 0 for value in row[1:]) for row in rows} == set(itertools.product([False, True], repeat=3))


def test_spheres_are_where_the_command_says(reader, lobe, tmp_path):
    write_ball(tmp_path / "ball.obj", rows=8)
    lobe("spheres", "ball.obj", "-n", 4, "-o", "s.safetensors")
    found = reader.spheres(*reader.read_safetensors(tmp_path / "s.safetensors"))
    assert len(found) == 4
    # Each point of the ball is in one of them.
    for point in [[0.0, 0.0, 1.0], [0.0, -1.0, 0.0], [0.3, 0.2, 0.1]]:
        assert min(math.dist(center, point) - radius for center, radius in found) < 1e-5


@pytest.mark.nightly
def test_transfer_is_the_same_in_a_scene_in_a_table_and_compressed(reader, lobe, tmp_path):
    bake = ["bake", "built-in:ball", "--mode", "shadowed", "--order", 3, "--samples", 16]
    for out in ("b.glb", "b.safetensors"):
        lobe(*bake, "-o", out)
    components = ["--clusters", 2, "--components", 9, "--weights", 32]
    lobe("compress", "b.glb", "-o", "c.safetensors", *components)
    lobe(*bake, "-o", "c.glb", *components)
    rows = {}
    for name in ("b.glb", "b.safetensors", "c.glb", "c.safetensors"):
        about, tensors = (reader.read_glb if name.endswith("glb") else reader.read_safetensors)(tmp_path / name)
        rows[name] = [list(row) for row in reader.transfer_of(about, tensors)]
    assert rows["b.glb"] == rows["b.safetensors"] and len(rows["b.glb"]) > 100
    for name in ("c.glb", "c.safetensors"):
        assert len(rows[name]) == len(rows["b.glb"])
        for row, compressed in zip(rows["b.glb"], rows[name]):
            assert compressed == pytest.approx(row, abs=1e-4), "nine components are all of nine numbers"
