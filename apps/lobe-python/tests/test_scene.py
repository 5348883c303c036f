"""How scenes are read: as the command reads them by its options, and in words where a file is not what was thought."""

import json

import numpy as np
import pytest

import lobe
from command import lobe_command

BAKE = {"mode": "shadowed", "order": 2, "samples": 16}
OPTIONS = "--mode shadowed --order 2 --samples 16"

# A roof of two triangles, of which the second is missing a normal.
ROOF = "v 0 0 0\nv 1 0 0\nv 1 1 1\nv 0 1 1\nf 1 2 3\nf 1 3 4\n"


def glass(folder, name="glass.gltf"):
    """A pane over a floor, blended and half opaque."""
    corners = np.array([[-1, 0, -1], [-1, 0, 1], [1, 0, 1], [1, 0, -1]], dtype="<f4")
    (folder / "glass.bin").write_bytes(corners.tobytes() + (corners + [0, 0.5, 0]).astype("<f4").tobytes() + np.array([0, 1, 2, 0, 2, 3], dtype="<u2").tobytes())
    bounds = [([-1, y, -1], [1, y, 1]) for y in (0, 0.5)]
    primitive = lambda k, **more: {"attributes": {"POSITION": k}, "indices": 2, **more}
    document = {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [primitive(0), primitive(1, material=0)]}],
        "materials": [{"alphaMode": "BLEND", "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 0.5], "metallicFactor": 0}, "doubleSided": True}],
        "accessors": [
            *({"bufferView": k, "componentType": 5126, "count": 4, "type": "VEC3", "min": low, "max": high} for k, (low, high) in enumerate(bounds)),
            {"bufferView": 2, "componentType": 5123, "count": 6, "type": "SCALAR"},
        ],
        "bufferViews": [{"buffer": 0, "byteOffset": 48 * k, "byteLength": 48} for k in (0, 1)] + [{"buffer": 0, "byteOffset": 96, "byteLength": 12}],
        "buffers": [{"uri": "glass.bin", "byteLength": 108}],
    }
    (folder / name).write_text(json.dumps(document))
    return folder / name


@pytest.mark.filterwarnings("ignore::lobe.LoadNote")
@pytest.mark.parametrize(
    ("reading", "arguments"),
    [
        ({}, ""),
        ({"up": "z"}, "--up z"),
        ({"missing_normals": "flat"}, "--missing-normals flat"),
        ({"missing_normals": "smooth", "up": "z"}, "--missing-normals smooth --up z"),
    ],
)
def test_a_mesh_is_read_as_by_the_command(tmp_path, reading, arguments):
    (tmp_path / "roof.obj").write_text(ROOF)
    lobe_command("bake", tmp_path / "roof.obj", OPTIONS, arguments, "-o", tmp_path / "a.glb")
    lobe.bake(lobe.Scene(tmp_path / "roof.obj", **reading), tmp_path / "b.glb", lobe.BakeOptions(**BAKE))
    assert (tmp_path / "b.glb").read_bytes() == (tmp_path / "a.glb").read_bytes()


@pytest.mark.filterwarnings("ignore::lobe.LoadNote")
@pytest.mark.parametrize(
    ("reading", "arguments"),
    [({}, ""), ({"transparency": True}, "--transparency"), ({"default_material": "gltf"}, "--default-material gltf")],
)
def test_a_gltf_is_read_as_by_the_command(tmp_path, reading, arguments):
    scene = glass(tmp_path)
    lobe_command("bake", scene, OPTIONS, arguments, "-o", tmp_path / "a.glb")
    lobe.bake(lobe.Scene(scene, **reading), tmp_path / "b.glb", lobe.BakeOptions(**BAKE))
    assert (tmp_path / "b.glb").read_bytes() == (tmp_path / "a.glb").read_bytes()


@pytest.mark.filterwarnings("ignore::lobe.LoadNote")
def test_light_goes_through_glass_where_asked(tmp_path):
    scene = glass(tmp_path)
    white = lobe.Sh(np.array([[2 * np.sqrt(np.pi)] * 3]))
    floor = {}
    for transparency in (False, True):
        lobe.bake(lobe.Scene(scene, transparency=transparency), tmp_path / "o.glb", lobe.BakeOptions(mode="shadowed", order=1, samples=4096, no_split=True))
        floor[transparency] = lobe.Transfer(tmp_path / "o.glb").exit_radiance(white)[:4].mean()
    # What a corner of the floor does not see past the pane, it sees through it by half.
    assert floor[True] - floor[False] == pytest.approx((1 - floor[False]) / 2, abs=0.01)
    camera = lobe.Camera(eye=(0, 0, 3), target=(0, 0, 0), fov=20)
    picture = {"camera": camera, "width": 4, "height": 4, "samples": 256, "bounces": 0}
    seen = {flag: lobe.trace(lobe.Scene(scene, transparency=flag), white, **picture).mean.mean() for flag in (False, True)}
    assert seen[False] == pytest.approx(1.0, abs=0.02), "the pane itself, under the whole sky"
    assert seen[True] < 0.95, "and half of it, over a floor that it shades"


def test_what_the_reader_found_is_warned_of_where_a_scene_is_read(tmp_path):
    (tmp_path / "roof.obj").write_text(ROOF)
    scene = tmp_path / "roof.obj"
    light = lobe.Sh(np.ones((1, 3)))
    for work in [
        lambda: lobe.bake(scene, tmp_path / "o.glb", lobe.BakeOptions(**BAKE)),
        lambda: lobe.render(scene, light, mode="irradiance", width=2, height=2),
        lambda: lobe.trace(scene, light, width=2, height=2, samples=2),
        lambda: lobe.field(scene, tmp_path / "f.safetensors", order=1, spheres=2, cells=2, rays=1),
        lambda: lobe.field_shard(scene, tmp_path / "p.safetensors", (1, 2), order=1, spheres=2, cells=2, rays=1),
        lambda: lobe.self_visibility(scene, tmp_path / "v.safetensors", order=1, rays=1),
        lambda: lobe.MovingScene(scene),
    ]:
        with pytest.warns(lobe.LoadNote) as told:
            work()
        expected = "roof.obj: normals missing or zero: 4 of 4, made from the triangles"
        assert any(expected in str(warning.message) for warning in told)


@pytest.mark.parametrize(
    ("make", "error", "message"),
    [
        (lambda: lobe.Scene("a.glb", up="z"), ValueError, "up: only .obj or .ply files"),
        (lambda: lobe.Scene("a.obj", up="x"), ValueError, 'up: expected y or z, found "x"'),
        (lambda: lobe.Scene("a.obj", default_material="gltf"), ValueError, "default_material: only of glTF files"),
        (lambda: lobe.Scene("a.glb", missing_normals="round"), ValueError, "missing_normals: expected flat or smooth"),
        (lambda: lobe.Scene("built-in:ball", transparency=True), ValueError, "transparency: only of scenes in files"),
        (lambda: lobe.Scene("a.glb", max_texels=0), ValueError, "max_texels: expected a number of texels from 1 to"),
        (lambda: lobe.Scene("a.obj", time=1.0), ValueError, "time and animation: only what a glTF file moves"),
        (lambda: lobe.Scene("a.glb", time=float("nan")), ValueError, "time: expected a finite number, found"),
        (lambda: lobe.Scene("a.glb", animation=1.5), TypeError, "animation: expected a name or a number"),
        (lambda: lobe.Scene(3), TypeError, "path|str"),
        (lambda: lobe.bake(3, "o.glb"), TypeError, "scene: expected the path of a file or a lobe.Scene, found int"),
        (lambda: lobe.trace("built-in:ball", lobe.Sh(np.ones((1, 3))), surfaces="chrome"), ValueError, "surfaces: expected matte, gltf or gltf-separable"),
        (lambda: lobe.render("built-in:ball", lobe.Sh(np.ones((1, 3))), surfaces="chrome"), ValueError, "surfaces: expected matte, gltf or gltf-separable"),
        (lambda: lobe.render("built-in:ball", lobe.Sh(np.ones((1, 3))), mode="irradiance", surfaces="gltf"), ValueError, "surfaces: matte in the mode"),
    ],
)
def test_what_cannot_be_read_so_is_refused_in_words(make, error, message):
    with pytest.raises(error, match=message):
        make()


@pytest.mark.filterwarnings("ignore::lobe.LoadNote")
def test_limits_are_kept(tmp_path):
    (tmp_path / "roof.obj").write_text(ROOF)
    for limits, message in [({"max_triangles": 1}, "at most 1 triangles|triangles"), ({"max_bytes": 100}, "at most 100 bytes")]:
        with pytest.raises(ValueError, match=message):
            lobe.bake(lobe.Scene(tmp_path / "roof.obj", **limits), tmp_path / "o.glb", lobe.BakeOptions(**BAKE))


@pytest.mark.filterwarnings("ignore::lobe.LoadNote")
def test_surfaces_are_those_of_the_command(tmp_path):
    lobe.EnvMap.bundled("sunset").save(tmp_path / "sky.exr")
    light = lobe.EnvMap.load(tmp_path / "sky.exr")
    for surfaces in ("matte", "gltf", "gltf-separable"):
        lobe_command(f"render trace built-in:still-life --surfaces {surfaces} --size 8x4 --samples 16 --bounces 1 --env", tmp_path / "sky.exr", "-o", tmp_path / "a.exr")
        expected = lobe.EnvMap.load(tmp_path / "a.exr").texels
        found = lobe.trace("built-in:still-life", light, surfaces=surfaces, width=8, height=4, samples=16, bounces=1)
        np.testing.assert_array_equal(found.mean, expected)
