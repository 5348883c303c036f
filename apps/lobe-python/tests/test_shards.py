"""Bakes of every kind in shards: by hand, and on Dask, with the bytes of the command alone whatever the order in which shards come."""

import os
import random
import shutil
import subprocess

import pytest

import lobe

# Meshes without normals, of which their reader tells.
pytestmark = pytest.mark.filterwarnings("ignore::lobe.LoadNote")

COMMAND = os.environ.get("LOBE") or shutil.which("lobe")

COMMON = {"order": 2, "samples": 16, "bounces": 1}

COUNTS = [1, 2, 3, 7]

# The scene, the name of the output, options, and the same as the command has them. The triangle has fewer vertices than there are shards.
KINDS = {
    "unshadowed": ("built-in:cornell", "o.glb", {"mode": "unshadowed", "no_split": True}, "--mode unshadowed --no-split"),
    "shadowed": ("built-in:cornell", "o.safetensors", {"mode": "shadowed", "seed": 3, "no_split": True}, "--mode shadowed --seed 3 --no-split"),
    "interreflected": ("built-in:cornell", "o.glb", {"energy_stop": 0.0, "no_split": True}, "--energy-stop 0 --no-split"),
    "without albedo": ("built-in:cornell", "o.safetensors", {"albedo": "none", "no_split": True}, "--albedo none --no-split"),
    "split": ("built-in:ball", "o.glb", {"max_edge": 3.0}, "--max-edge 3"),
    "glossy": ("built-in:cornell", "o.safetensors", {"mode": "glossy"}, "--mode glossy"),
    "three vertices": ("three.obj", "o.glb", {"max_vertices": 30}, "--max-vertices 30"),
    "three glossy vertices": ("three.obj", "o.safetensors", {"mode": "glossy"}, "--mode glossy"),
    "texels": ("built-in:cornell", "o.safetensors", {"texels": 16}, "--texels 16"),
    "a picture of texels": ("built-in:cornell", "o.exr", {"texels": 16, "albedo": "none"}, "--texels 16 --albedo none"),
    "a grid": ("built-in:ball", "o.safetensors", {"grid": (2, 3, 2)}, "--grid 2,3,2"),
    "a grid in a box": ("built-in:cornell", "o.safetensors", {"grid": (2, 2, 2), "grid_box": (0, 0, 1, 1, 1, 2)}, "--grid 2,2,2 --grid-box 0,0,1,1,1,2"),
}


@pytest.fixture(params=KINDS)
def kind(request, tmp_path, monkeypatch):
    """The scene, the name of the output, options, and the bytes that the command writes."""
    if COMMAND is None:
        pytest.skip("the command lobe is not built: set LOBE to it")
    monkeypatch.chdir(tmp_path)
    (tmp_path / "three.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 0 -1\nf 1 2 3\n")
    scene, name, options, arguments = KINDS[request.param]
    has_bounces = "--mode" not in arguments or "glossy" in arguments
    asked = {option: value for option, value in COMMON.items() if has_bounces or option != "bounces"}
    common = [part for option, value in asked.items() for part in (f"--{option}", str(value))]
    subprocess.run([COMMAND, "bake", scene, "-o", name, *common, *arguments.split(), "--quiet"], check=True)
    return scene, name, lobe.BakeOptions(**asked, **options), (tmp_path / name).read_bytes()


def test_every_number_of_shards_in_any_order_has_the_bytes_of_the_command(kind, tmp_path):
    scene, name, options, expected = kind
    lobe.bake(scene, f"whole-{name}", options)
    assert (tmp_path / f"whole-{name}").read_bytes() == expected
    for count in COUNTS:
        parts = [f"{number}-of-{count}.safetensors" for number in range(1, count + 1)]
        for number, part in enumerate(parts, 1):
            lobe.bake(scene, part, options, shard=(number, count))
        for order in [parts[::-1], random.Random(count).sample(parts, count)]:
            lobe.merge(scene, order, f"merged-{name}", options)
            assert (tmp_path / f"merged-{name}").read_bytes() == expected, order


@pytest.fixture(scope="module")
def client():
    distributed = pytest.importorskip("distributed", reason="dask's distributed is not installed")
    with (
        distributed.LocalCluster(n_workers=2, threads_per_worker=1, host="127.0.0.1", dashboard_address=None) as cluster,
        distributed.Client(cluster, set_as_default=False) as client,
    ):
        yield client


@pytest.mark.filterwarnings("ignore")
def test_shards_from_workers_have_these_bytes(kind, tmp_path, client):
    import lobe.distributed as on_dask

    scene, name, options, expected = kind
    for count in COUNTS:
        on_dask.bake(scene, name, options, client=client, shards=count)
        assert (tmp_path / name).read_bytes() == expected, f"{count} shards"
        assert not os.path.exists(f"{name}.shards")
