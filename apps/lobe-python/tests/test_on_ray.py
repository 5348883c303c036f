"""Bakes on a Ray cluster whose machines, which are processes of Ray on this one, join late and are killed."""

import contextlib
import os
import pathlib
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import types

import pytest

import lobe

ray = pytest.importorskip("ray", reason="ray is not installed")

import lobe.on_ray  # noqa: E402
from ray.cluster_utils import Cluster  # noqa: E402

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
def machine():
    # Two tasks at a time on this machine.
    path = {"env_vars": {"PYTHONPATH": os.environ.get("PYTHONPATH", "")}}
    ray.init(address="local", num_cpus=2, include_dashboard=False, log_to_driver=False, runtime_env=path)
    yield
    ray.shutdown()


@pytest.mark.parametrize("shards", [1, 7, None])
def test_a_bake_on_ray_has_the_bytes_of_one_machine(machine, tmp_path, whole, shards):
    told = []
    output = tmp_path / "o.safetensors"
    lobe.on_ray.bake(SCENE, output, OPTIONS, shards=shards, progress=lambda *done: told.append(done))
    assert output.read_bytes() == whole
    count = shards or 64
    assert told == [(done, count) for done in range(count + 1)]
    assert os.listdir(tmp_path) == ["o.safetensors"], "no shard is left"


def test_all_shards_are_tasks_of_one_function(machine, tmp_path, monkeypatch):
    remote, made = ray.remote, []
    monkeypatch.setattr(ray, "remote", lambda **options: made.append(options) or remote(**options))
    lobe.on_ray.bake(SCENE, tmp_path / "o.safetensors", OPTIONS, shards=5)
    assert len(made) == 1, made


def test_a_worker_that_is_killed_in_the_middle_is_replaced(machine, tmp_path, whole, monkeypatch):
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


def test_shards_that_were_done_are_taken_up(machine, tmp_path, whole):
    output = tmp_path / "o.safetensors"

    def stop(done, shards):
        if done == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        lobe.on_ray.bake(SCENE, output, OPTIONS, shards=5, progress=stop)
    assert len(os.listdir(f"{output}.shards")) == 2 and not output.exists()
    told = []
    lobe.on_ray.bake(SCENE, output, OPTIONS, progress=lambda *done: told.append(done))
    assert told[0] == (2, 5) and output.read_bytes() == whole


def test_a_worker_whose_disk_is_full_is_named(machine, tmp_path, whole, monkeypatch):
    bake_shard = lobe.on_ray.bake_shard

    def on_a_full_disk(*arguments):
        # The system refuses what a full disk refuses: files of more than a few thousand bytes.
        limits = resource.getrlimit(resource.RLIMIT_FSIZE)
        resource.setrlimit(resource.RLIMIT_FSIZE, (4096, limits[1]))
        try:
            return bake_shard(*arguments)
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, limits)

    output = tmp_path / "o.safetensors"
    with monkeypatch.context() as patched:
        patched.setattr(lobe.on_ray, "bake_shard", on_a_full_disk)
        with pytest.raises(OSError, match=r"worker of process \d+ on .*\.safetensors.*; free space") as error:
            lobe.on_ray.bake(SCENE, output, OPTIONS, shards=2)
    assert "\n" not in str(error.value) and not output.exists()
    lobe.on_ray.bake(SCENE, output, OPTIONS, shards=2)
    assert output.read_bytes() == whole


DRIVER = f"""
import os, sys
import ray, lobe, lobe.on_ray

def told(done, shards):
    print("done", done, flush=True)
    sys.stdin.readline()

address, output = sys.argv[1:]
ray.init(address=address, log_to_driver=False)
options = lobe.BakeOptions(**{{"mode": {OPTIONS.mode!r}, "order": {OPTIONS.order}, "samples": {OPTIONS.samples}}})
try:
    lobe.on_ray.bake({SCENE!r}, output, options, shards=40, progress=told)
    print("written", flush=True)
except RuntimeError as error:
    print("error:", error, flush=True)
# Ray waits for a cluster that is gone.
os._exit(0)
"""


class Bake:
    """A bake in a process of its own, which Ray may end, and that goes on when it is told to."""

    def __init__(self, cluster, output):
        pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.DEVNULL}
        # Ray ends a process whose head is gone for so long.
        environment = {**os.environ, "RAY_gcs_rpc_server_reconnect_timeout_s": "2"}
        command = [sys.executable, "-c", DRIVER, cluster.address, str(output)]
        self.process = subprocess.Popen(command, env=environment, text=True, **pipes)

    def until(self, count):
        """Lets it go on until so many shards are done: what it says then, or last."""
        said = ""
        for line in self.process.stdout:
            # Ray writes there as well.
            if line.startswith(("done ", "written", "error: ")):
                said = line.strip()
                if said == f"done {count}" or not said.startswith("done "):
                    break
                self.go_on()
        return said

    def go_on(self):
        print(file=self.process.stdin, flush=True)

    def end(self):
        """Lets it go on to its end: what it says last."""
        self.go_on()
        return self.until(None)


@pytest.fixture
def start():
    """Starts clusters and bakes, which are gone with all that they leave at the end of the test."""
    with contextlib.ExitStack() as started:

        def cluster(processors):
            # Where it notes the last cluster, in a folder that only some of its ways to start make.
            pathlib.Path(tempfile.gettempdir(), "ray").mkdir(exist_ok=True)
            # Ray puts sockets there, whose paths have to be short.
            folder = tempfile.mkdtemp(prefix="lobe-ray-")
            started.callback(shutil.rmtree, folder, ignore_errors=True)
            head = {"num_cpus": processors, "include_dashboard": False, "temp_dir": folder}
            made = Cluster(initialize_head=True, head_node_args=head)
            started.callback(made.shutdown)
            return made

        def bake(cluster, output):
            made = Bake(cluster, output)
            started.callback(made.process.communicate)
            started.callback(made.process.kill)
            return made

        yield types.SimpleNamespace(cluster=cluster, bake=bake)


def test_a_machine_that_joins_late_bakes_what_one_that_is_killed_has_left(start, tmp_path, whole):
    cluster, output = start.cluster(processors=0), tmp_path / "o.safetensors"
    first = cluster.add_node(num_cpus=1)
    bake = start.bake(cluster, output)
    assert bake.until(3) == "done 3"
    cluster.add_node(num_cpus=1)
    cluster.remove_node(first, allow_graceful=False)
    assert bake.end() == "written"
    assert output.read_bytes() == whole


@pytest.mark.parametrize("dies", ["gcs_server", "raylet"])
def test_a_head_that_dies_ends_the_bake_and_another_takes_it_up(start, tmp_path, whole, dies):
    cluster, output = start.cluster(processors=1), tmp_path / "o.safetensors"
    bake = start.bake(cluster, output)
    assert bake.until(3) == "done 3"
    [process] = cluster.head_node.all_processes[dies]
    process.process.send_signal(signal.SIGKILL)
    process.process.wait()
    said = bake.end()
    assert dies != "raylet" or said.startswith(f"error: {output}: the Ray cluster is gone; start one, "), said
    kept = len(os.listdir(f"{output}.shards"))
    assert not output.exists() and 3 <= kept < 40
    again = start.bake(start.cluster(processors=1), output)
    assert again.until(kept) == f"done {kept}", "those that were done are taken up"
    assert again.end() == "written"
    assert output.read_bytes() == whole


def test_machines_without_the_package_are_told_in_one_line(start, tmp_path, monkeypatch):
    (tmp_path / "without" / "lobe").mkdir(parents=True)
    (tmp_path / "without" / "lobe" / "__init__.py").write_text("raise ModuleNotFoundError(\"No module named 'lobe'\")")
    with monkeypatch.context() as environment:
        environment.setenv("PYTHONPATH", os.pathsep.join([str(tmp_path / "without"), os.environ.get("PYTHONPATH", "")]))
        cluster = start.cluster(processors=1)
    bake = start.bake(cluster, tmp_path / "o.safetensors")
    assert bake.until(0) == "done 0"
    said, output = bake.end(), tmp_path / "o.safetensors"
    assert said.startswith(f"error: {output}: System error: No module named 'lobe'; mend that, "), said
