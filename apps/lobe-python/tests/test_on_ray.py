"""Bakes on Ray, with real processes that are killed."""

import os
import resource
import signal

import pytest

import lobe

ray = pytest.importorskip("ray", reason="ray is not installed")

import lobe.on_ray  # noqa: E402

# Ray is large and its processes take long to start; its warnings are about what it will change.
pytestmark = [pytest.mark.nightly, pytest.mark.filterwarnings("ignore")]

OPTIONS = lobe.BakeOptions(mode="shadowed", order=3, samples=64)
SCENE = "built-in:ball"


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    path = tmp_path_factory.mktemp("whole") / "o.safetensors"
    lobe.bake(SCENE, path, OPTIONS)
    return path.read_bytes()


@pytest.fixture(scope="module")
def cluster():
    # Two tasks at a time on this machine.
    ray.init(address="local", num_cpus=2, include_dashboard=False, log_to_driver=False, runtime_env={"env_vars": {"PYTHONPATH": os.environ.get("PYTHONPATH", "")}})
    yield
    ray.shutdown()


@pytest.mark.parametrize("shards", [3, *(pytest.param(shards, marks=pytest.mark.nightly) for shards in [1, 7, None])])
def test_a_bake_on_ray_has_the_bytes_of_one_machine(cluster, tmp_path, whole, shards):
    told = []
    output = tmp_path / "o.safetensors"
    lobe.on_ray.bake(SCENE, output, OPTIONS, shards=shards, progress=lambda *done: told.append(done))
    assert output.read_bytes() == whole
    assert told[0][0] == 0 and told[-1][0] == told[-1][1] == len(told) - 1
    assert os.listdir(tmp_path) == ["o.safetensors"], "no shard is left"


def test_a_worker_that_is_killed_in_the_middle_is_replaced(cluster, tmp_path, whole, monkeypatch):
    bake_shard, killed = lobe.on_ray.bake_shard, str(tmp_path / "killed")

    def dies_once(*arguments):
        if not os.path.exists(killed):
            open(killed, "x").close()
            os.kill(os.getpid(), signal.SIGKILL)
        return bake_shard(*arguments)

    monkeypatch.setattr(lobe.on_ray, "bake_shard", dies_once)
    output = tmp_path / "o.safetensors"
    lobe.on_ray.bake(SCENE, output, OPTIONS, shards=4)
    assert os.path.exists(killed) and output.read_bytes() == whole


def test_shards_that_were_done_are_taken_up(cluster, tmp_path, whole):
    output = tmp_path / "o.safetensors"

    def stop(done, shards):
        if done == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        lobe.on_ray.bake(SCENE, output, OPTIONS, shards=5, progress=stop)
    assert len(os.listdir(f"{output}.shards")) == 2 and not output.exists()
    told = []
    lobe.on_ray.bake(SCENE, output, OPTIONS, shards=5, progress=lambda *done: told.append(done))
    assert told[0] == (2, 5) and output.read_bytes() == whole


def test_what_a_worker_refuses_is_one_line(cluster, tmp_path):
    scene = tmp_path / "scene.obj"
    scene.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")

    def lose(done, shards):
        scene.unlink(missing_ok=True)

    with pytest.raises(OSError, match="scene.obj") as error:
        lobe.on_ray.bake(scene, tmp_path / "o.safetensors", OPTIONS, shards=1, progress=lose)
    assert "\n" not in str(error.value)


def test_a_worker_whose_disk_is_full_is_named(cluster, tmp_path, whole, monkeypatch):
    bake_shard = lobe.on_ray.bake_shard

    def on_a_full_disk(*arguments):
        # The system refuses what a full disk refuses: files of more than a few thousand bytes.
        limits = resource.getrlimit(resource.RLIMIT_FSIZE)
        resource.setrlimit(resource.RLIMIT_FSIZE, (4096, limits[1]))
        try:
            return bake_shard(*arguments)
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, limits)

    monkeypatch.setattr(lobe.on_ray, "bake_shard", on_a_full_disk)
    output = tmp_path / "o.safetensors"
    with pytest.raises(OSError, match=r"worker of process \d+ on .*\.safetensors") as error:
        lobe.on_ray.bake(SCENE, output, OPTIONS, shards=2)
    assert "\n" not in str(error.value) and not output.exists()
    # With room again the same call ends.
    monkeypatch.setattr(lobe.on_ray, "bake_shard", bake_shard)
    lobe.on_ray.bake(SCENE, output, OPTIONS, shards=2)
    assert output.read_bytes() == whole
