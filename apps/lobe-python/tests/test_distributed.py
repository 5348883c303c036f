"""Bakes on Dask, with real processes on the loopback interface that are killed, join late and are of other versions."""

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
import types

import numpy as np
import pytest

import lobe

distributed = pytest.importorskip("distributed", reason="dask's distributed is not installed")

import dask  # noqa: E402
import lobe._shards as shards  # noqa: E402
import lobe._tasks as tasks  # noqa: E402
import lobe.distributed as on_dask  # noqa: E402

# Warnings of Dask about its own processes, which are killed here on purpose.
pytestmark = pytest.mark.filterwarnings("ignore")

OPTIONS = lobe.BakeOptions(mode="shadowed", order=3, samples=64)
SCENE = "built-in:ball"

THREADS = 4


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    path = tmp_path_factory.mktemp("whole") / "o.safetensors"
    lobe.bake(SCENE, path, OPTIONS)
    return path.read_bytes()


LOOK_SECONDS = 0.05
"""How often one looks whether a process has got on. None of them has a deadline: one waits until it has, or has ended."""


class Processes:
    """A scheduler and workers, each a process of its own."""

    def __init__(self, folder):
        self.folder, self.all = folder, []
        self.file = str(folder / "scheduler.json")
        self.scheduler = self.start("scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard")

    def start(self, kind, *arguments, path=None):
        environment = dict(os.environ)
        if path is not None:
            environment["PYTHONPATH"] = os.pathsep.join([str(path), environment.get("PYTHONPATH", "")])
        command = [sys.executable, "-m", "distributed.cli.dask_" + kind, "--scheduler-file", self.file, *arguments]
        process = subprocess.Popen(command, cwd=self.folder, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.all.append(process)
        return process

    def worker(self, **options):
        return self.start("worker", "--host", "127.0.0.1", "--nthreads", "1", "--no-dashboard", "--no-nanny", **options)

    def client(self, workers=1):
        """A client of the scheduler, when so many workers have joined."""
        while not os.path.exists(self.file):
            self.are_alive()
        client = distributed.Client(scheduler_file=self.file, set_as_default=False)
        while len(client.nthreads()) < workers:
            self.are_alive()
        return client

    def are_alive(self):
        """Lets the processes get on for a moment; a fault if one has ended."""
        for process in self.all:
            with contextlib.suppress(subprocess.TimeoutExpired):
                status = process.wait(timeout=LOOK_SECONDS)
                raise AssertionError(f"{process.args} has ended with {status}")

    def stop(self):
        for process in self.all:
            process.kill()
        for process in self.all:
            process.wait()


@pytest.fixture
def processes(tmp_path):
    started = Processes(tmp_path)
    yield started
    started.stop()


def test_a_bake_on_two_workers_has_the_bytes_of_one_machine(processes, tmp_path, whole):
    for _ in range(2):
        processes.worker()
    with processes.client(workers=2) as client:
        for shards in [1, 3, 7]:
            told = []
            on_dask.bake(SCENE, tmp_path / "o.safetensors", OPTIONS, client=client, shards=shards, progress=lambda d, n: told.append((d, n)))
            assert (tmp_path / "o.safetensors").read_bytes() == whole, f"{shards} shards"
            assert told == [(d, shards) for d in range(shards + 1)]
    assert not (tmp_path / "o.safetensors.shards").exists()


def test_a_file_is_sent_to_workers_that_do_not_have_it(processes, tmp_path):
    (tmp_path / "here").mkdir()
    scene = tmp_path / "here" / "s.ply"
    scene.write_text(
        "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face 2\n"
        "property list uchar int vertex_indices\nend_header\n-1 -1 0\n1 -1 0\n1 1 0\n-1 1 0\n3 0 1 2\n3 0 2 3\n"
    )
    lobe.bake(scene, tmp_path / "whole.glb", OPTIONS)
    processes.worker()
    with processes.client() as client:
        on_dask.bake(scene, tmp_path / "o.glb", OPTIONS, client=client, shards=2)
    assert (tmp_path / "o.glb").read_bytes() == (tmp_path / "whole.glb").read_bytes()


def test_a_worker_that_is_killed_in_the_middle_and_one_that_joins_late_change_no_byte(processes, tmp_path, whole):
    victim = processes.worker()
    with processes.client() as client:
        def disturb(done, shards):
            if done == 2:
                victim.send_signal(signal.SIGKILL)
                victim.wait()
                processes.worker()

        on_dask.bake(SCENE, tmp_path / "o.safetensors", OPTIONS, client=client, shards=8, progress=disturb)
    assert (tmp_path / "o.safetensors").read_bytes() == whole


@pytest.mark.nightly
def test_a_bake_whose_scheduler_died_goes_on_with_another(processes, tmp_path, whole):
    processes.worker()
    output = tmp_path / "o.safetensors"
    with processes.client() as client:
        def die(done, shards):
            if done == 3:
                processes.stop()
                raise ConnectionError("the scheduler is gone")

        with pytest.raises(ConnectionError):
            on_dask.bake(SCENE, output, OPTIONS, client=client, shards=6, progress=die)
    assert not output.exists() and len(list((tmp_path / "o.safetensors.shards").iterdir())) == 3
    (tmp_path / "again").mkdir()
    again = Processes(tmp_path / "again")
    try:
        again.worker()
        with again.client() as client:
            told = []
            on_dask.bake(SCENE, output, OPTIONS, client=client, shards=6, progress=lambda d, n: told.append(d))
        assert told[0] == 3, "three shards are taken up"
    finally:
        again.stop()
    assert output.read_bytes() == whole


def test_a_scheduler_that_dies_ends_the_bake_in_one_line_that_says_what_to_do(processes, tmp_path, whole):
    processes.worker()
    output = tmp_path / "o.safetensors"
    with processes.client() as client:
        def die(done, shards):
            if done == 3:
                processes.stop()

        with pytest.raises(RuntimeError, match="o.safetensors: the scheduler is gone; start one and repeat the call") as fault:
            on_dask.bake(SCENE, output, OPTIONS, client=client, shards=40, progress=die)
    assert "\n" not in str(fault.value)
    done = len(list((tmp_path / "o.safetensors.shards").iterdir()))
    assert not output.exists() and 3 <= done < 40
    told = []
    on_dask.bake(SCENE, output, OPTIONS, progress=lambda *at: told.append(at))
    assert told[0] == (done, 40) and output.read_bytes() == whole


@pytest.fixture
def soon_given_up():
    """Dask looks for a scheduler that is not there for two seconds instead of thirty."""
    with dask.config.set({"distributed.comm.timeouts.connect": "2s"}):
        yield


@pytest.mark.nightly
def test_a_scheduler_that_died_before_the_bake_is_told_in_one_line(processes, tmp_path, soon_given_up):
    processes.worker()
    output = tmp_path / "o.safetensors"
    with processes.client() as client:
        processes.stop()
        with pytest.raises(RuntimeError, match="o.safetensors: the scheduler is gone; start one and repeat the call") as fault:
            on_dask.bake(SCENE, output, OPTIONS, client=client, shards=8)
    assert "\n" not in str(fault.value) and not output.exists()


@pytest.mark.nightly
def test_a_bag_whose_scheduler_dies_keeps_what_was_returned(processes):
    processes.worker()
    with processes.client() as client:
        def die(done, count):
            if done == 3:
                processes.stop()

        with pytest.raises(on_dask.Unfinished, match="items are not done: the scheduler is gone; start one and repeat the call") as fault:
            on_dask.map(lambda number: number * number, range(500), client=client, progress=die)
    results, errors = fault.value.results, fault.value.errors
    assert "\n" not in str(fault.value) and errors and len(results) == 500
    done = [number for number in range(500) if number not in errors]
    assert len(done) >= 3 and all(results[number] == number * number for number in done)
    assert all(results[number] is None for number in errors)


@pytest.mark.nightly
@pytest.mark.parametrize("what", ["bake", "map"])
def test_a_scheduler_without_workers_is_told_and_one_that_joins_does_the_work(processes, tmp_path, whole, what, capfd):
    output = str(tmp_path / "o.safetensors")
    with processes.client(workers=0) as client, concurrent.futures.ThreadPoolExecutor(1) as thread:
        if what == "bake":
            work = thread.submit(on_dask.bake, SCENE, output, OPTIONS, client=client, shards=3)
        else:
            work = thread.submit(on_dask.map, abs, [-1, 2], client=client)
        told = ""
        while "waiting for a worker" not in told:
            processes.are_alive()
            assert not work.done(), work.result()
            told += capfd.readouterr().err
        assert len(told.splitlines()) == 1 and told.startswith(f"{client.scheduler.address}: ")
        processes.worker()
        result = work.result()
    assert result == [1, 2] if what == "map" else pathlib.Path(output).read_bytes() == whole


@pytest.mark.nightly
def test_ctrl_c_ends_the_program_in_one_line_and_the_same_command_goes_on(tmp_path):
    # Long enough that it has not ended before the signal is there.
    lengthy = lobe.BakeOptions(mode=OPTIONS.mode, order=OPTIONS.order, samples=1024)
    lobe.bake(SCENE, tmp_path / "whole.safetensors", lengthy)
    options = [part for name in ("mode", "order", "samples") for part in (f"--{name}", str(getattr(lengthy, name)))]
    command = [sys.executable, "-m", "lobe.distributed", SCENE, "-o", "o.safetensors", "--shards", "60", *options]
    lines = []
    # A group of its own, all of which gets the signal, as from a terminal.
    with subprocess.Popen(command, cwd=tmp_path, stderr=subprocess.PIPE, text=True, start_new_session=True) as program:
        for line in program.stderr:
            lines.append(line)
            if line.startswith("progress: 3 of"):
                os.killpg(program.pid, signal.SIGINT)
    assert program.returncode == 130, lines
    # Dask's page may be on another port, where a cluster beside this one has the usual one.
    told = [line for line in lines if not line.startswith(("progress: ", "warning: Port "))]
    assert told == ["error: stopped; the same command takes up the shards that are done\n"], told
    again = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert again.returncode == 0 and not again.stderr.startswith("progress: 0 "), again.stderr
    assert (tmp_path / "o.safetensors").read_bytes() == (tmp_path / "whole.safetensors").read_bytes()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], "the following arguments are required: scene, -o/--output"),
        ([SCENE, "-o", "o.glb", "--order", "many"], "argument --order: invalid int value: 'many'"),
        ([SCENE, "-o", "o.glb", "--colour"], "unrecognized arguments: --colour"),
    ],
)
def test_what_the_program_does_not_understand_is_one_line(arguments, message, tmp_path):
    command = [sys.executable, "-m", "lobe.distributed", *arguments]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert done.stderr == f"error: {message}; python -m lobe.distributed --help lists the arguments\n"


def test_the_module_is_a_program(tmp_path, whole):
    options = [part for name in ("mode", "order", "samples") for part in (f"--{name}", str(getattr(OPTIONS, name)))]
    command = [sys.executable, "-m", "lobe.distributed", SCENE, "-o", "o.safetensors", "--shards", "2", *options]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "o.safetensors").read_bytes() == whole


@pytest.mark.nightly
def test_a_worker_has_few_results_however_slow_the_client_is(processes, tmp_path):
    processes.worker()
    held = []
    with processes.client() as client:
        def count(done, shards):
            held.append(sum(client.run(lambda dask_worker: len(dask_worker.data)).values()))

        on_dask.bake(SCENE, tmp_path / "o.safetensors", OPTIONS, client=client, shards=20, progress=count)
    assert max(held) <= on_dask.AHEAD, held


def test_a_worker_of_another_version_says_so_in_one_line(processes, tmp_path):
    # The package once more, with another version.
    other = tmp_path / "other" / "lobe"
    shutil.copytree(pathlib.Path(lobe.__file__).parent, other)
    init = other / "__init__.py"
    init.write_text(init.read_text() + '\n__version__ = "0.0.1"\n')
    processes.worker(path=tmp_path / "other")
    with processes.client() as client:
        with pytest.raises(RuntimeError, match=r"worker has lobe 0\.0\.1 and the client has .*: install one version"):
            on_dask.bake(SCENE, tmp_path / "o.safetensors", OPTIONS, client=client, shards=2)
    assert not (tmp_path / "o.safetensors").exists()


def on_a_full_disk(folder):
    """A path by which workers are refused what a full disk refuses: files of more than a few thousand bytes."""
    full = folder / "full"
    full.mkdir()
    limit = "import resource\nresource.setrlimit(resource.RLIMIT_FSIZE, (4096, resource.RLIM_INFINITY))\n"
    (full / "sitecustomize.py").write_text(limit)
    return full


@pytest.mark.nightly
@pytest.mark.parametrize("shards", [12, None])
def test_a_worker_whose_disk_is_full_is_named_and_the_other_bakes_its_shards(processes, tmp_path, whole, shards):
    processes.worker(path=on_a_full_disk(tmp_path))
    with processes.client() as client:
        processes.worker()
        while len(client.nthreads()) < 2:
            processes.are_alive()
        # Each of the two workers has a shard, or is the first that has nothing to do.
        with pytest.warns(UserWarning, match=r"worker tcp://127\.0\.0\.1:.*\.safetensors: .*; other workers bake its shards: free space there") as told:
            on_dask.bake(SCENE, tmp_path / "o.safetensors", OPTIONS, client=client, shards=shards)
    assert (tmp_path / "o.safetensors").read_bytes() == whole
    assert len([warning for warning in told if "other workers" in str(warning.message)]) == 1


@pytest.mark.nightly
def test_where_no_worker_has_room_the_bake_says_what_to_do_and_goes_on_when_it_is_done(processes, tmp_path, whole):
    output = tmp_path / "o.safetensors"
    good = processes.worker()
    with processes.client() as client:
        def fill(done, shards):
            if done == 3:
                processes.worker(path=on_a_full_disk(tmp_path))
                while len(client.nthreads()) < 2:
                    processes.are_alive()
                good.kill()
                processes.all.remove(good)
                good.wait()

        with pytest.raises(OSError, match=r"o\.safetensors: worker tcp://.*\.safetensors: .*; free space there, or stop that worker, and repeat the call") as fault:
            on_dask.bake(SCENE, output, OPTIONS, client=client, shards=40, progress=fill)
        assert "\n" not in str(fault.value) and str(fault.value).endswith(f"which takes up the shards that are done, in {output}.shards")
        done = len(os.listdir(f"{output}.shards"))
        assert not output.exists() and 3 <= done < 40
        processes.all.pop().kill()
        processes.worker()
        told = []
        on_dask.bake(SCENE, output, OPTIONS, client=client, shards=40, progress=lambda *at: told.append(at))
    assert told[0] == (done, 40) and output.read_bytes() == whole


@pytest.mark.nightly
def test_shards_for_workers_that_are_left_go_to_others_when_those_die(processes, tmp_path, whole):
    processes.worker(path=on_a_full_disk(tmp_path))
    with processes.client() as client:
        good = processes.worker()
        while len(client.nthreads()) < 2:
            processes.are_alive()

        def die(done, shards):
            # The last of the shards are for the one worker that is left.
            if done == 12:
                processes.worker()
                while len(client.nthreads()) < 3:
                    processes.are_alive()
                good.kill()
                processes.all.remove(good)
                good.wait()

        with pytest.warns(UserWarning, match="other workers bake its shards"):
            on_dask.bake(SCENE, tmp_path / "o.safetensors", OPTIONS, client=client, shards=16, progress=die)
    assert (tmp_path / "o.safetensors").read_bytes() == whole


@pytest.mark.nightly
def test_a_grid_and_split_triangles_are_shared_like_vertices(processes, tmp_path):
    processes.worker()
    with processes.client() as client:
        for name, options in [
            ("o.safetensors", lobe.BakeOptions(order=2, samples=16, grid=(2, 3, 2))),
            ("o.glb", lobe.BakeOptions(order=2, samples=16, max_edge=3.0)),
        ]:
            lobe.bake(SCENE, tmp_path / f"whole-{name}", options)
            on_dask.bake(SCENE, tmp_path / name, options, client=client, shards=3)
            assert (tmp_path / name).read_bytes() == (tmp_path / f"whole-{name}").read_bytes(), name


def test_the_command_bakes_and_refuses_in_one_line(processes, tmp_path, whole):
    processes.worker()
    with processes.client() as client:
        address = client.scheduler.address
    options = ["--mode", "shadowed", "--order", "3", "--samples", "64"]
    output = str(tmp_path / "o.safetensors")
    assert on_dask.main([SCENE, "-o", output, "--scheduler", address, "--shards", "2", *options]) == 0
    assert pathlib.Path(output).read_bytes() == whole


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["built-in:moon", "-o", "o.glb"], "error: built-in:moon: there is no such scene in the program; there are built-in:ball"),
        (["none.glb", "-o", "o.glb"], "none.glb"),
        (["built-in:ball", "-o", "o.png"], "o.png: expected a name"),
        (["built-in:ball", "-o", "o.glb", "--order", "9"], "order: expected an order (number of bands) from 1 to 8"),
        # Ten seconds until the scheduler is given up.
        pytest.param(
            ["built-in:ball", "-o", "o.glb", "--scheduler", "tcp://127.0.0.1:1"], "127.0.0.1:1", marks=pytest.mark.nightly
        ),
    ],
)
def test_errors_of_the_command_are_one_line(arguments, message, tmp_path, monkeypatch, capsys, soon_given_up):
    monkeypatch.chdir(tmp_path)
    assert on_dask.main(arguments) == 2
    lines = capsys.readouterr().err.strip().splitlines()
    assert len(lines) == 1 and message in lines[0], lines
    assert os.listdir(tmp_path) == [], "nothing is left behind"


def test_without_a_client_one_process_with_one_thread_and_the_memory_of_the_machine_bakes(tmp_path, whole):
    def look(done, shards):
        workers = distributed.get_client().scheduler_info()["workers"].values()
        assert [worker["nthreads"] for worker in workers] == [1]
        assert [worker["memory_limit"] for worker in workers] == [distributed.system.MEMORY_LIMIT]

    on_dask.bake(SCENE, tmp_path / "o.safetensors", OPTIONS, progress=look)
    assert (tmp_path / "o.safetensors").read_bytes() == whole


def test_a_worker_of_several_threads_reads_the_scene_once(monkeypatch):
    read, come, all_have_come = [], set(), threading.Event()
    of, reading = lobe.BakeOptions.of, tasks._reading

    def comes():
        """The thread wants the scene, whether it waits for another that reads it or reads it by itself."""
        come.add(threading.get_ident())
        if len(come) == THREADS:
            all_have_come.set()

    class Lock:
        def __enter__(self):
            comes()
            return reading.__enter__()

        def __exit__(self, *error):
            return reading.__exit__(*error)

    def slowly(options, scene):
        comes()
        all_have_come.wait()
        read.append(scene)
        return of(options, scene)

    scene = lobe.Scene(SCENE)
    identity = tasks.identity_of(OPTIONS.of(scene), scene, OPTIONS)
    tasks._read.clear()
    monkeypatch.setattr(tasks, "_reading", Lock())
    monkeypatch.setattr(lobe.BakeOptions, "of", slowly)
    arguments = (None, scene, dataclasses.asdict(OPTIONS), identity, lobe.__version__)
    start = threading.Barrier(THREADS)

    def shard(number):
        # No thread takes two of them.
        start.wait()
        return on_dask.bake_shard(*arguments, number, THREADS)

    with concurrent.futures.ThreadPoolExecutor(THREADS) as threads:
        parts = list(threads.map(shard, range(1, THREADS + 1)))
    assert read == [scene] and len({*parts}) == THREADS


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

    def die(done, shards):
        if done == 1:
            raise KeyboardInterrupt

    with processes.client() as client:
        with pytest.raises(KeyboardInterrupt):
            on_dask.bake(tmp_path / "s.obj", output, options, client=client, shards=3, progress=die)
        if changed == "s.mtl":
            (tmp_path / "s.mtl").write_text("newmtl a\nKd 0.2 0.5 0.9\nmap_Kd s.png\n")
        else:
            textured([0.1, 0.1, 1.0])
        with pytest.warns(UserWarning, match="1 shards are of another scene, or of other options, than now: baked anew"):
            on_dask.bake(tmp_path / "s.obj", output, options, client=client, shards=3)
    lobe.bake(tmp_path / "s.obj", tmp_path / "fresh.safetensors", options)
    assert output.read_bytes() == (tmp_path / "fresh.safetensors").read_bytes()
    assert not (tmp_path / "o.safetensors.shards").exists(), "those of before are gone too"


def test_a_bake_without_a_number_of_shards_goes_on_with_those_that_are_there(processes, tmp_path, whole):
    processes.worker()
    output = tmp_path / "o.safetensors"

    def stop(done, shards):
        if done == 2:
            raise KeyboardInterrupt

    told = []
    with processes.client() as client:
        with pytest.raises(KeyboardInterrupt):
            on_dask.bake(SCENE, output, OPTIONS, client=client, shards=5, progress=stop)
        on_dask.bake(SCENE, output, OPTIONS, client=client, progress=lambda *done: told.append(done))
    assert told[0] == (2, 5) and output.read_bytes() == whole


def test_another_bake_into_the_same_output_is_refused_and_takes_nothing_away(processes, tmp_path, whole):
    processes.worker()
    output, others = tmp_path / "o.safetensors", dataclasses.replace(OPTIONS, seed=7)
    with processes.client() as client:
        def bake_too(done, shards):
            if done == 2:
                for options in [OPTIONS, others]:
                    with pytest.raises(RuntimeError, match=r"o\.safetensors: another bake into it is at work; wait for its end") as fault:
                        on_dask.bake(SCENE, output, options, client=client, shards=3)
                    assert "\n" not in str(fault.value)
                assert len(os.listdir(f"{output}.shards")) == 2, "the shards of the first are there"
                on_dask.bake(SCENE, tmp_path / "other.safetensors", others, client=client, shards=1)

        on_dask.bake(SCENE, output, OPTIONS, client=client, shards=4, progress=bake_too)
        assert output.read_bytes() == whole
        on_dask.bake(SCENE, output, others, client=client, shards=1)
    assert output.read_bytes() == (tmp_path / "other.safetensors").read_bytes() != whole
    assert not list(tmp_path.glob("*.shards*")), "neither shards nor locks are left"


class Timed:
    """A bake whose shards take times that are known, on a clock of its own."""

    points, bytes, pilot = 6400, 123, (2, 0.5)

    def __init__(self, scale):
        self.now, self.scale = 0.0, scale

    def write_shard(self, path, number, count, progress):
        receivers = range((number - 1) * self.points // count, number * self.points // count)
        pathlib.Path(path).write_bytes(b"")
        self.now += 0.5 + sum(self.scale * (1 + receiver / self.points) for receiver in receivers)
        return {"receivers": len(receivers)}


def test_what_is_measured_is_what_receivers_take_in_all(tmp_path, monkeypatch):
    costs = []
    for scale in [1e-3, 1.0]:
        bake = Timed(scale)
        monkeypatch.setattr(shards, "time", types.SimpleNamespace(perf_counter=lambda bake=bake: bake.now))
        cost = shards.measured(bake, str(tmp_path))
        # Receivers cost from one to two times the scale, evenly, and four runs of them are measured.
        assert cost.shard == 0.5 and cost.work == pytest.approx(1.5 * scale * bake.points, rel=1e-2)
        assert (cost.size, cost.pilot) == (bake.bytes, bake.pilot)
        costs.append(cost)
    assert shards.shards_for(2, costs[1]) > shards.shards_for(2, costs[0]) >= 1, "what is costly is cut smaller"
    assert os.listdir(tmp_path) == [], "nothing is left behind"


def test_a_bake_is_measured_by_shards_of_it(tmp_path):
    made = OPTIONS.of(SCENE)
    cost = shards.measured(made, str(tmp_path))
    assert cost.shard > 0 and cost.work > 0 and cost.size == made.bytes and cost.pilot == made.pilot
    assert os.listdir(tmp_path) == [], "nothing is left behind"


@pytest.mark.parametrize(
    ("tasks", "work", "shard", "expected"),
    [
        (2, 600.0, 0.0, 128),  # a sixty-fourth of what each has to do
        (16, 360_000.0, 0.0, 12_000),  # of 30 s, less than a sixty-fourth
        (2, 8.0, 0.0, 8),  # of a second, more than a sixty-fourth
        (2, 0.1, 0.0, 2),  # none is idle
        (2, 600.0, 2.0, 15),  # of 40 s, of which 2 s go by before the first receiver
        (0, 64.0, 0.0, 64),  # workers that are to come
        (4096, 1e9, 0.0, 1 << 14),  # what a client hands out
        (100_000, 1e9, 0.0, 100_000),
    ],
)
def test_shards_take_their_time_within_bounds(tasks, work, shard, expected):
    assert shards.shards_for(tasks, shards.Cost(shard, work)) == expected


def test_a_shard_has_room_in_memory_however_cheap_it_is():
    # A million receivers, order 6, glossy.
    count = shards.shards_for(1, shards.Cost(10.0, 0.1, 5_184_000_000))
    assert count == 78 and 5_184_000_000 / count <= shards.MOST_BYTES
    made = lobe.BakeOptions(mode="glossy", order=6).of(SCENE)
    # Of each triangle six moments of weights, the variance, and moments of matrices of three colors for each corner.
    assert made.bytes == made.points * 4 * (7 + 3 * 3 * 36 * 36)


KILLED_WHILE_IT_WRITES = """
import resource, signal
import lobe, lobe.distributed, distributed

def die(done, shards):
    # By the system, in the middle of the shard that is written next.
    if done == 2:
        signal.signal(signal.SIGXFSZ, signal.SIG_DFL)
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))

options = lobe.BakeOptions(mode="shadowed", order=3, samples=64)
with distributed.Client(scheduler_file={file!r}, set_as_default=False) as client:
    lobe.distributed.bake({scene!r}, {output!r}, options, client=client, shards=6, progress=die)
"""


@pytest.mark.nightly
@pytest.mark.skipif(sys.platform == "win32", reason="it has no limits of files")
def test_what_a_client_that_is_killed_has_begun_to_write_is_cleared_and_what_it_wrote_taken_up(processes, tmp_path, whole):
    processes.worker()
    output = tmp_path / "o.safetensors"
    with processes.client() as client:
        program = KILLED_WHILE_IT_WRITES.format(file=processes.file, scene=SCENE, output=str(output))
        done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
        assert done.returncode == -signal.SIGXFSZ, done.stderr
        left = os.listdir(f"{output}.shards")
        whole_ones = [name for name in left if on_dask.SHARD.fullmatch(name)]
        assert len(whole_ones) == 2 and len(left) == 3, left
        told = []
        on_dask.bake(SCENE, output, OPTIONS, client=client, progress=lambda done, shards: told.append((done, shards)))
    assert told[0] == (2, 6), "the shards that were done are taken up"
    assert output.read_bytes() == whole
    assert not pathlib.Path(f"{output}.shards").exists(), "nothing of it is left"
