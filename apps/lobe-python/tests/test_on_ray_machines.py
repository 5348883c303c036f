"""Bakes on a Ray cluster whose machines, which are processes of Ray on this one, join late, are killed and are of another version."""

import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile

import pytest

import lobe

cluster_utils = pytest.importorskip("ray.cluster_utils", reason="ray is not installed")

# Warnings of Ray about what it will change, and about its processes, which are killed here on purpose.
pytestmark = [pytest.mark.filterwarnings("ignore"), pytest.mark.nightly]

OPTIONS = lobe.BakeOptions(mode="shadowed", order=3, samples=64)
SCENE = "built-in:ball"

DRIVER = f"""
import os, pathlib, sys, time
import ray, lobe, lobe.on_ray

address, output, shards, at = sys.argv[1:]
ray.init(address=address, log_to_driver=False)
# What a head has to be gone for; nothing else of these tests depends on it.
lobe.on_ray.LOOK_SECONDS, lobe.on_ray.HEAD_SECONDS = 0.2, 1.0
bake_shard, at = lobe.on_ray.bake_shard, pathlib.Path(at)

def noted(*arguments):
    # Once another machine is asked for, the first ones wait until it has had a shard.
    node = ray.get_runtime_context().get_node_id()
    (at / node).touch()
    while (at / "wait").exists() and len(list(at.iterdir())) < 3:
        time.sleep(0.05)
    return bake_shard(*arguments)

def told(done, shards):
    print(done, shards, flush=True)
    sys.stdin.readline()

lobe.on_ray.bake_shard = noted
options = lobe.BakeOptions(**{{"mode": {OPTIONS.mode!r}, "order": {OPTIONS.order}, "samples": {OPTIONS.samples}}})
try:
    lobe.on_ray.bake({SCENE!r}, output, options, shards=int(shards), progress=told)
    print("written", flush=True)
except (OSError, RuntimeError) as error:
    print("error:", error, flush=True)
# Ray waits for a cluster that is gone.
os._exit(0)
"""


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    path = tmp_path_factory.mktemp("whole") / "o.safetensors"
    lobe.bake(SCENE, path, OPTIONS)
    return path.read_bytes()


class Processes:
    """Clusters and bakes."""

    def __init__(self):
        self._clusters, self._bakes = [], []

    def cluster(self, processors=1):
        # Where it notes the last cluster, in a folder that only some of its ways to start make.
        pathlib.Path(tempfile.gettempdir(), "ray").mkdir(exist_ok=True)
        # Ray puts sockets there, whose paths have to be short.
        folder = tempfile.mkdtemp(prefix="lobe-ray-")
        head = {"num_cpus": processors, "include_dashboard": False, "temp_dir": folder}
        self._clusters.append((cluster_utils.Cluster(initialize_head=True, head_node_args=head), folder))
        return self._clusters[-1][0]

    def bake(self, cluster, output, shards):
        self._bakes.append(Bake(cluster, output, shards))
        return self._bakes[-1]

    def stop(self):
        for bake in self._bakes:
            bake.stop()
        for cluster, folder in self._clusters:
            cluster.shutdown()
            shutil.rmtree(folder, ignore_errors=True)


@pytest.fixture
def processes():
    """Clusters and bakes, which are gone with all that they leave at the end of the test."""
    started = Processes()
    yield started
    started.stop()


class Bake:
    """A bake in a process of its own, which Ray may end, and that goes on when it is told to."""

    def __init__(self, cluster, output, shards):
        self.notes = output.with_suffix(".notes")
        self.notes.mkdir(exist_ok=True)
        command = [sys.executable, "-c", DRIVER, cluster.address, str(output), str(shards), str(self.notes)]
        self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        self._waits = False

    def _next(self):
        """Lets it go on if it waits: what it says next, nothing if it has ended."""
        if self._waits:
            print(file=self._process.stdin, flush=True)
        # Ray writes there as well.
        said = (line for line in self._process.stdout if re.match(r"\d+ \d+$|written$|error: ", line))
        line = next(said, "").rstrip("\n")
        self._waits = line[:1].isdigit()
        return line

    def until(self, count):
        """Lets it go on until so many shards are done, or more when it began: how many."""
        while (line := self._next())[:1].isdigit():
            done = int(line.split()[0])
            if done >= count:
                return done
        raise AssertionError(f"the bake has ended: {line}")

    def end(self):
        """Lets it go on to its end: what it says last."""
        last = ""
        while line := self._next():
            last = line
        return last

    def stop(self):
        self._process.kill()
        self._process.communicate()


def test_a_machine_that_joins_late_bakes_and_one_that_is_killed_is_replaced(processes, tmp_path, whole):
    cluster, output = processes.cluster(), tmp_path / "o.safetensors"
    bake = processes.bake(cluster, output, 24)
    bake.until(2)
    (bake.notes / "wait").touch()
    late = cluster.add_node(num_cpus=1)
    done = bake.until(8)
    assert len(list(bake.notes.iterdir())) == 3, "two machines, and the note to wait"
    assert done < 24
    cluster.remove_node(late, allow_graceful=False)
    assert bake.end() == "written"
    assert output.read_bytes() == whole


@pytest.mark.parametrize("dies", ["gcs_server", "raylet"])
def test_a_head_that_dies_ends_the_bake_in_one_line_and_another_takes_it_up(processes, tmp_path, whole, dies):
    cluster, output = processes.cluster(), tmp_path / "o.safetensors"
    bake = processes.bake(cluster, output, 40)
    bake.until(3)
    [process] = cluster.head_node.all_processes[dies]
    process.process.send_signal(signal.SIGKILL)
    process.process.wait()
    assert bake.end().startswith(f"error: {output}: the Ray cluster is gone; start one, ")
    kept = len(os.listdir(f"{output}.shards"))
    assert not output.exists() and 3 <= kept < 40
    again = processes.bake(processes.cluster(), output, 40)
    assert again.until(0) == kept, "those that were done are taken up"
    assert again.end() == "written"
    assert output.read_bytes() == whole


def test_a_machine_of_another_version_says_so_in_one_line(processes, tmp_path, monkeypatch):
    other = tmp_path / "other" / "lobe"
    shutil.copytree(pathlib.Path(lobe.__file__).parent, other)
    init = other / "__init__.py"
    init.write_text(init.read_text() + '\n__version__ = "0.0.1"\n')
    cluster, output = processes.cluster(processors=0), tmp_path / "o.safetensors"
    with monkeypatch.context() as environment:
        environment.setenv("PYTHONPATH", os.pathsep.join([str(other.parent), os.environ.get("PYTHONPATH", "")]))
        cluster.add_node(num_cpus=1)
    bake = processes.bake(cluster, output, 2)
    bake.until(0)
    said = bake.end()
    assert said.startswith("error: this worker has lobe 0.0.1 and the client has ") and said.endswith(": install one version on all machines")
    assert not output.exists()


def test_a_machine_whose_disk_is_full_gives_its_shards_to_another(processes, tmp_path, whole, monkeypatch):
    # The system refuses what a full disk refuses: files of more than a few thousand bytes. Only in Lobe's tasks: Ray writes files, too.
    full = tmp_path / "full" / "lobe"
    shutil.copytree(pathlib.Path(lobe.__file__).parent, full)
    tasks = full / "_tasks.py"
    limit = "\nimport resource\n_in = _in_a_folder\ndef _in_a_folder(version, work):\n    def limited(folder):\n"
    limit += "        before = resource.getrlimit(resource.RLIMIT_FSIZE)\n        resource.setrlimit(resource.RLIMIT_FSIZE, (4096, before[1]))\n"
    limit += "        try:\n            return work(folder)\n        finally:\n            resource.setrlimit(resource.RLIMIT_FSIZE, before)\n"
    tasks.write_text(tasks.read_text() + limit + "    return _in(version, limited)\n")
    cluster, output = processes.cluster(processors=0), tmp_path / "o.safetensors"
    with monkeypatch.context() as environment:
        environment.setenv("PYTHONPATH", os.pathsep.join([str(full.parent), os.environ.get("PYTHONPATH", "")]))
        cluster.add_node(num_cpus=1)
    bake = processes.bake(cluster, output, 24)
    bake.until(0)
    said = bake.end()
    assert re.fullmatch(r"error: .*o\.safetensors: worker of process \d+ on .*; free space there, or stop that worker, and repeat the call, .*", said), said
    cluster.add_node(num_cpus=1)
    again = processes.bake(cluster, output, 24)
    assert again.end() == "written"
    assert output.read_bytes() == whole
