"""Bakes on Dask, with processes on the loopback interface that are killed, join late and have other versions."""

import concurrent.futures
import contextlib
import dataclasses
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import threading
import time
import types

import numpy as np
import pytest

import lobe

distributed = pytest.importorskip("distributed", reason="dask's distributed is not installed")

import dask  # noqa: E402
import lobe._engine as engine  # noqa: E402
import lobe._shards  # noqa: E402
import lobe._tasks as tasks  # noqa: E402
import lobe.distributed as on_dask  # noqa: E402

# Warnings of Dask about its own processes, which are killed here on purpose.
pytestmark = pytest.mark.filterwarnings("ignore")

OPTIONS = lobe.BakeOptions(mode="shadowed", order=3, samples=64)
ARGUMENTS = ["--mode", "shadowed", "--order", "3", "--samples", "64"]
SCENE = "built-in:ball"
GONE = "o.safetensors: the scheduler is gone; start one, and repeat the call, which takes up the shards that are done"

LOOK_SECONDS = 0.05
"""How often one looks whether a process has got on. None has a deadline: one waits until it has, or has ended."""


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    path = tmp_path_factory.mktemp("whole") / "o.safetensors"
    lobe.bake(SCENE, path, OPTIONS)
    return path.read_bytes()


class Processes:
    """A scheduler and workers, each a process of its own."""

    def __init__(self, folder):
        self.folder, self.all, self.file = folder, [], str(folder / "scheduler.json")
        self.start("scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard")

    def start(self, kind, *arguments, path=""):
        environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(path), os.environ.get("PYTHONPATH", "")])}
        command = [sys.executable, "-m", "distributed.cli.dask_" + kind, "--scheduler-file", self.file, *arguments]
        quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        self.all.append(subprocess.Popen(command, cwd=self.folder, env=environment, **quiet))
        return self.all[-1]

    def worker(self, **options):
        return self.start("worker", "--host", "127.0.0.1", "--nthreads", "1", "--no-dashboard", "--no-nanny", **options)

    def client(self, workers=1):
        """A client of the scheduler, when so many workers have joined."""
        while not os.path.exists(self.file):
            self.are_alive()
        client = distributed.Client(scheduler_file=self.file, set_as_default=False)
        self.joined(client, workers)
        return client

    def joined(self, client, workers):
        while len(client.nthreads()) < workers:
            self.are_alive()

    def are_alive(self):
        """Lets the processes get on for a moment; a fault if one has ended."""
        for process in self.all:
            with contextlib.suppress(subprocess.TimeoutExpired):
                status = process.wait(timeout=LOOK_SECONDS)
                raise AssertionError(f"{process.args} has ended with {status}")

    def kill(self, process):
        self.all.remove(process)
        process.kill()
        process.wait()

    def stop(self):
        for process in self.all[:]:
            self.kill(process)


@pytest.fixture
def processes(tmp_path):
    started = Processes(tmp_path)
    yield started
    started.stop()


@pytest.fixture
def soon_given_up():
    """Dask looks for a scheduler that is not there for two seconds instead of thirty."""
    with dask.config.set({"distributed.comm.timeouts.connect": "2s"}):
        yield


def at(count, act):
    """A progress that does something once so many shards are done, and all that it was told."""
    told = []

    def progress(done, shards):
        told.append((done, shards))
        if done == count:
            act()

    return progress, told


def interrupt():
    raise KeyboardInterrupt


def test_a_bake_on_two_workers_has_the_bytes_of_one_machine(processes, tmp_path, whole):
    for _ in range(2):
        processes.worker()
    with processes.client(workers=2) as client:
        for shards in [1, 3, 7]:
            progress, told = at(None, None)
            on_dask.bake(SCENE, tmp_path / "o.safetensors", OPTIONS, client=client, shards=shards, progress=progress)
            assert (tmp_path / "o.safetensors").read_bytes() == whole, f"{shards} shards"
            assert told == [(d, shards) for d in range(shards + 1)]
    assert not list(tmp_path.glob("*.shards*")), "neither shards nor locks are left"


def test_a_file_is_sent_to_workers_that_do_not_have_it(processes, tmp_path):
    (tmp_path / "here").mkdir()
    scene = tmp_path / "here" / "s.ply"
    scene.write_text(
        "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
        "element face 2\nproperty list uchar int vertex_indices\nend_header\n"
        "-1 -1 0\n1 -1 0\n1 1 0\n-1 1 0\n3 0 1 2\n3 0 2 3\n"
    )
    lobe.bake(scene, tmp_path / "whole.glb", OPTIONS)
    processes.worker()
    with processes.client() as client:
        progress, _ = at(0, lambda: scene.rename(tmp_path / "away.ply"))
        on_dask.bake(scene, tmp_path / "o.glb", OPTIONS, client=client, shards=2, progress=progress)
    assert (tmp_path / "o.glb").read_bytes() == (tmp_path / "whole.glb").read_bytes()


def test_a_worker_that_is_killed_in_the_middle_and_one_that_joins_late_change_no_byte(processes, tmp_path, whole):
    victim = processes.worker()
    with processes.client() as client:
        progress, _ = at(2, lambda: [processes.kill(victim), processes.worker()])
        on_dask.bake(SCENE, tmp_path / "o.safetensors", OPTIONS, client=client, shards=8, progress=progress)
    assert (tmp_path / "o.safetensors").read_bytes() == whole


def test_a_scheduler_that_dies_ends_the_bake_in_one_line_and_a_call_goes_on(processes, tmp_path, whole, soon_given_up):
    processes.worker()
    output = tmp_path / "o.safetensors"
    with processes.client() as client:
        progress, _ = at(3, processes.stop)
        with pytest.raises(RuntimeError, match=GONE) as fault:
            on_dask.bake(SCENE, output, OPTIONS, client=client, shards=40, progress=progress)
    assert "\n" not in str(fault.value)
    done = len(os.listdir(f"{output}.shards"))
    assert not output.exists() and 3 <= done < 40
    progress, told = at(None, None)
    on_dask.bake(SCENE, output, OPTIONS, progress=progress)
    assert told[0] == (done, 40) and output.read_bytes() == whole


@pytest.mark.nightly
def test_a_scheduler_without_workers_is_told_and_one_that_joins_does_the_work(processes, tmp_path, whole, capfd):
    output = tmp_path / "o.safetensors"
    with processes.client(workers=0) as client, concurrent.futures.ThreadPoolExecutor(1) as thread:
        work = thread.submit(on_dask.bake, SCENE, output, OPTIONS, client=client, shards=3)
        told = ""
        while "waiting for a worker" not in told:
            processes.are_alive()
            assert not work.done(), work.result()
            told += capfd.readouterr().err
        assert len(told.splitlines()) == 1 and told.startswith(f"{client.scheduler.address}: ")
        processes.worker()
        work.result()
    assert output.read_bytes() == whole


@pytest.mark.nightly
def test_ctrl_c_ends_the_program_in_one_line_and_the_same_command_goes_on(tmp_path):
    # Long enough that it has not ended before the signal is there.
    arguments = [*ARGUMENTS[:-1], "1024"]
    lobe.bake(SCENE, tmp_path / "whole.safetensors", dataclasses.replace(OPTIONS, samples=1024))
    command = [sys.executable, "-m", "lobe.distributed", SCENE, "-o", "o.safetensors", "--shards", "60", *arguments]
    lines = []
    # A group of its own, all of which gets the signal, as from a terminal.
    with subprocess.Popen(command, cwd=tmp_path, stderr=subprocess.PIPE, text=True, start_new_session=True) as program:
        for line in program.stderr:
            lines.append(line)
            if line.startswith("progress: 3 of"):
                os.killpg(program.pid, signal.SIGINT)
    assert program.returncode == 130, lines
    told = [line for line in lines if not line.startswith("progress: ")]
    assert told == ["error: stopped; the same command takes up the shards that are done\n"], told
    again = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert again.returncode == 0 and not again.stderr.startswith("progress: 0 "), again.stderr
    assert (tmp_path / "o.safetensors").read_bytes() == (tmp_path / "whole.safetensors").read_bytes()


def test_the_command_bakes(processes, tmp_path, whole):
    processes.worker()
    with processes.client() as client:
        address = client.scheduler.address
    output = str(tmp_path / "o.safetensors")
    assert on_dask.main([SCENE, "-o", output, "--scheduler", address, "--shards", "2", *ARGUMENTS]) == 0
    assert pathlib.Path(output).read_bytes() == whole


HELP = "; python -m lobe.distributed --help lists the arguments"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], f"error: the following arguments are required: scene, -o/--output{HELP}"),
        ([SCENE, "-o", "o.glb", "--order", "many"], f"error: argument --order: invalid int value: 'many'{HELP}"),
        ([SCENE, "-o", "o.glb", "--colour"], f"error: unrecognized arguments: --colour{HELP}"),
        (["built-in:moon", "-o", "o.glb"], "error: built-in:moon: there is no such scene in the program; there are "),
        (["none.glb", "-o", "o.glb"], "error: none.glb: "),
        ([SCENE, "-o", "o.png"], "error: output: o.png: expected a name"),
        ([SCENE, "-o", "o.glb", "--order", "9"], "error: order: expected an order (number of bands) from 1 to 8"),
        # Ten seconds until the scheduler is given up.
        pytest.param([SCENE, "-o", "o.glb", "--scheduler", "tcp://127.0.0.1:1"], "error: ", marks=pytest.mark.nightly),
    ],
)
def test_errors_of_the_command_are_one_line(arguments, message, tmp_path):
    command = [sys.executable, "-m", "lobe.distributed", *arguments]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    lines = done.stderr.splitlines()
    assert done.returncode == 2 and len(lines) == 1 and lines[0].startswith(message), lines
    assert os.listdir(tmp_path) == [], "nothing is left behind"


@pytest.mark.nightly
def test_a_worker_has_few_results_however_slow_the_client_is(processes, tmp_path):
    processes.worker()
    held = []
    with processes.client() as client:
        def count(done, shards):
            held.append(sum(client.run(lambda dask_worker: len(dask_worker.data)).values()))

        on_dask.bake(SCENE, tmp_path / "o.safetensors", OPTIONS, client=client, shards=20, progress=count)
    assert max(held) <= engine.AHEAD, held


def of_another_version(folder):
    """A path by which workers have the package once more, with another version."""
    shutil.copytree(pathlib.Path(lobe.__file__).parent, folder / "other" / "lobe")
    with open(folder / "other" / "lobe" / "__init__.py", "a") as init:
        init.write('\n__version__ = "0.0.1"\n')
    return folder / "other"


def without_the_package(folder):
    """A path by which workers find no package."""
    (folder / "without" / "lobe").mkdir(parents=True)
    (folder / "without" / "lobe" / "__init__.py").write_text("raise ModuleNotFoundError(\"No module named 'lobe'\")")
    return folder / "without"


def on_a_full_disk(folder):
    """A path by which workers are refused what a full disk refuses: files of more than a few thousand bytes."""
    (folder / "full").mkdir()
    limit = "import resource\nresource.setrlimit(resource.RLIMIT_FSIZE, (4096, resource.RLIM_INFINITY))\n"
    (folder / "full" / "sitecustomize.py").write_text(limit)
    return folder / "full"


@pytest.mark.parametrize(
    ("bad", "fault"),
    [
        (of_another_version, r"has lobe 0\.0\.1; install lobe .* there"),
        (without_the_package, ".*No module named 'lobe'.*; install lobe .* there"),
        (on_a_full_disk, r".*\.safetensors: .*; free space or mend that there, or stop that worker"),
    ],
)
def test_a_worker_that_cannot_bake_is_named_and_another_bakes_its_shards(processes, tmp_path, whole, bad, fault):
    fault = rf"worker tcp://127\.0\.0\.1:\d+: {fault}"
    output = tmp_path / "o.safetensors"
    processes.worker(path=bad(tmp_path))
    with processes.client() as client:
        with pytest.raises(OSError, match=rf"o\.safetensors: {fault}, and repeat the call, which takes up") as error:
            on_dask.bake(SCENE, output, OPTIONS, client=client, shards=12)
        assert "\n" not in str(error.value) and not output.exists()
        processes.worker()
        processes.joined(client, 2)
        with pytest.warns(UserWarning, match=f"{fault}; other workers bake its shards") as told:
            on_dask.bake(SCENE, output, OPTIONS, client=client, shards=12)
    assert output.read_bytes() == whole
    assert len([warning for warning in told if "other workers" in str(warning.message)]) == 1


@pytest.mark.nightly
@pytest.mark.parametrize("joins", [True, False])
def test_shards_for_workers_that_are_left_go_to_others_when_those_die(processes, tmp_path, whole, joins):
    output = tmp_path / "o.safetensors"
    processes.worker(path=on_a_full_disk(tmp_path))
    with processes.client() as client:
        good = processes.worker()
        processes.joined(client, 2)

        def die():
            # The last of the shards are for the one worker that is left.
            if joins:
                processes.worker()
                processes.joined(client, 3)
            processes.kill(good)

        ends = contextlib.nullcontext() if joins else pytest.raises(OSError, match="free space or mend that there")
        with ends, pytest.warns(UserWarning, match="other workers bake its shards"):
            on_dask.bake(SCENE, output, OPTIONS, client=client, shards=16, progress=at(12, die)[0])
    assert output.read_bytes() == whole if joins else len(os.listdir(f"{output}.shards")) >= 12


def test_a_task_of_another_version_is_left_to_other_workers():
    job = tasks.Job(lobe.Scene(SCENE), {}, "", "0.0.1")
    refused = tasks.bake_shard(None, job, 1, 1)
    assert isinstance(refused, tasks.Refused) and str(refused).endswith(f"has lobe {lobe.__version__}; install lobe 0.0.1 there")


def test_without_a_client_one_process_with_one_thread_and_the_memory_of_the_machine_bakes(tmp_path, whole):
    with on_dask._own() as client:
        [worker] = client.scheduler_info()["workers"].values()
        assert (worker["nthreads"], worker["memory_limit"]) == (1, distributed.system.MEMORY_LIMIT)
    on_dask.bake(SCENE, tmp_path / "o.safetensors", OPTIONS)
    assert (tmp_path / "o.safetensors").read_bytes() == whole


def test_a_worker_of_several_threads_reads_the_scene_once(monkeypatch):
    read, start, of = [], threading.Barrier(4), lobe.BakeOptions.of
    monkeypatch.setattr(lobe.BakeOptions, "of", lambda options, scene: read.append(scene) or of(options, scene))
    scene, options = lobe.Scene(SCENE), dataclasses.replace(OPTIONS, no_split=True)
    identity = tasks.identity_of(options.of(scene), scene, options)
    job = tasks.Job(scene, dataclasses.asdict(options), identity, lobe.__version__)
    read.clear()

    def shard(number):
        # No thread takes two of them.
        start.wait()
        return tasks.bake_shard(None, job, number, 4)

    with concurrent.futures.ThreadPoolExecutor(4) as threads:
        parts = list(threads.map(shard, range(1, 5)))
    assert read == [scene] and len({*parts}) == 4


@pytest.mark.parametrize("changed", ["s.mtl", "s.png"])
def test_shards_of_a_scene_whose_files_have_changed_are_baked_anew(processes, tmp_path, changed):
    def textured(color):
        lobe.EnvMap(np.broadcast_to(np.float32(color), (2, 4, 3))).save(tmp_path / "s.png")

    corners = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nv 0 0 1\nvt 0 0\nvt 1 0\nvt 1 1\n"
    faces = "usemtl a\nf 1/1 2/2 3/3\nf 1/1 3/3 4/2\nf 1/1 2/2 5/3\n"
    (tmp_path / "s.obj").write_text("mtllib s.mtl\n" + corners + faces)
    (tmp_path / "s.mtl").write_text("newmtl a\nKd 1 0.5 0.25\nmap_Kd s.png\n")
    textured([1.0, 0.1, 0.1])
    options, output = lobe.BakeOptions(order=2, samples=64), tmp_path / "o.safetensors"
    processes.worker()
    with processes.client() as client:
        with pytest.raises(KeyboardInterrupt):
            progress, _ = at(1, interrupt)
            on_dask.bake(tmp_path / "s.obj", output, options, client=client, shards=3, progress=progress)
        if changed == "s.mtl":
            (tmp_path / "s.mtl").write_text("newmtl a\nKd 0.2 0.5 0.9\nmap_Kd s.png\n")
        else:
            textured([0.1, 0.1, 1.0])
        with pytest.warns(UserWarning, match="1 shards are of another scene, or of other options, than now"):
            on_dask.bake(tmp_path / "s.obj", output, options, client=client, shards=3)
    lobe.bake(tmp_path / "s.obj", tmp_path / "fresh.safetensors", options)
    assert output.read_bytes() == (tmp_path / "fresh.safetensors").read_bytes()
    assert not list(tmp_path.glob("*.shards*")), "those of before are gone too"


def test_another_bake_into_the_same_output_is_refused_and_takes_nothing_away(processes, tmp_path, whole):
    processes.worker()
    output, others = tmp_path / "o.safetensors", dataclasses.replace(OPTIONS, seed=7)
    with processes.client() as client:
        def bake_too():
            for options in [OPTIONS, others]:
                with pytest.raises(RuntimeError, match=r"o\.safetensors: another bake into it is at work") as fault:
                    on_dask.bake(SCENE, output, options, client=client, shards=3)
                assert "\n" not in str(fault.value)
            assert len(os.listdir(f"{output}.shards")) == 2, "the shards of the first are there"
            on_dask.bake(SCENE, tmp_path / "other.safetensors", others, client=client, shards=1)

        on_dask.bake(SCENE, output, OPTIONS, client=client, shards=4, progress=at(2, bake_too)[0])
        assert output.read_bytes() == whole
        on_dask.bake(SCENE, output, others, client=client, shards=1)
    assert output.read_bytes() == (tmp_path / "other.safetensors").read_bytes() != whole
    assert not list(tmp_path.glob("*.shards*")), "neither shards nor locks are left"


def test_many_that_want_the_same_output_are_never_two_at_once(tmp_path):
    work = engine.Work(SCENE, tmp_path / "o.safetensors", OPTIONS)
    inside, most, turns = [], [0], []

    def take_turns():
        while len(turns) < 200:
            with contextlib.suppress(RuntimeError), work.alone():
                inside.append(None)
                most[0] = max(most[0], len(inside))
                # Others have a turn meanwhile, if they are let in.
                time.sleep(2e-4)
                turns.append(inside.pop())

    with concurrent.futures.ThreadPoolExecutor(4) as threads:
        for done in [threads.submit(take_turns) for _ in range(4)]:
            done.result()
    assert most == [1] and os.listdir(tmp_path) == []


def test_there_are_64_shards_for_each_thread_and_each_has_room_in_memory(tmp_path):
    work = engine.Work(SCENE, tmp_path / "o.safetensors", lobe.BakeOptions(mode="glossy", order=6))
    assert [work.shards_for(threads) for threads in (0, 1, 20)] == [64, 64, 1280]
    # A million receivers, order 6, glossy.
    work._made = types.SimpleNamespace(bytes=5_184_000_000)
    assert work.shards_for(1) == 78 and 5_184_000_000 / 78 <= engine.MOST_BYTES


KILLED_WHILE_IT_WRITES = """
import resource, signal, sys
import lobe, lobe.distributed, distributed

def die(done, shards):
    # By the system, in the middle of the shard that is written next.
    if done == 2:
        signal.signal(signal.SIGXFSZ, signal.SIG_DFL)
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))

options = lobe.BakeOptions(mode="shadowed", order=3, samples=64)
with distributed.Client(scheduler_file=sys.argv[1], set_as_default=False) as client:
    lobe.distributed.bake(sys.argv[2], sys.argv[3], options, client=client, shards=6, progress=die)
"""


@pytest.mark.nightly
@pytest.mark.skipif(sys.platform == "win32", reason="it has no limits of files")
def test_a_client_that_is_killed_leaves_whole_shards_and_keeps_nobody_out(processes, tmp_path, whole):
    processes.worker()
    output, (progress, told) = tmp_path / "o.safetensors", at(None, None)
    with processes.client() as client:
        command = [sys.executable, "-c", KILLED_WHILE_IT_WRITES, processes.file, SCENE, str(output)]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        assert done.returncode == -signal.SIGXFSZ, done.stderr
        left = os.listdir(f"{output}.shards")
        assert len([name for name in left if lobe._shards.SHARD.fullmatch(name)]) == 2 and len(left) == 3, left
        on_dask.bake(SCENE, output, OPTIONS, client=client, progress=progress)
    assert told[0] == (2, 6), "the shards that were done are taken up"
    assert output.read_bytes() == whole
    assert not list(tmp_path.glob("*.shards*")), "nothing of it is left"
