"""Bakes on many machines, by Dask: `bake` here, or `python -m lobe.distributed SCENE --scheduler tcp://HOST:PORT -o baked.glb`; `map` for many files.

A bake is cut into shards, each a task. Dask gives them to workers, to others if a worker dies, and to those that join late; the scene is sent to
each worker once. What comes back is kept in a folder beside the output, so that a bake whose client or scheduler died goes on from there, and the
shards are put together to the bytes that one machine alone writes. Needs `pip install distributed`.

One process with one thread a machine, which is what `bake` starts without a client: a shard computes on all processors by itself, and each process
has a copy of the scene. `dask worker tcp://HOST:PORT --nthreads 1 --memory-limit 1.0` is such a worker; without the second option Dask divides the
machine's memory by its processors.
"""

from __future__ import annotations

import argparse
import os
import re
import sys
import warnings
import uuid
from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass, fields, replace
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, Any, NoReturn

from . import __version__, _lobe
from ._arrays import whole
from ._bag import GONE, Unfinished, map
from ._bake import BakeOptions, BakeReport
from ._engine import LOOK_SECONDS, Gone, NotYet, Waiting, asked, cancel, client_or_own, threads_of, value_of
from ._locked import locked
from ._scene import Path, Scene
from ._shards import Cost, shards_for
from ._tasks import Pilot, Refused, bake_shard, identity_of, measure

if TYPE_CHECKING:
    from distributed import Client

__all__ = ["Unfinished", "bake", "main", "map"]

RETRIES = 3
"""Times that a shard is tried again after an error. A worker that dies counts nothing here: Dask has a limit of its own."""

AHEAD = 4
"""Shards that are handed out for each thread of a worker at a time: one that is baked, and some that wait or whose results do, so that
none has to ask and no worker keeps more."""

SHARD = re.compile(r"[0-9a-f]{16}-[0-9]+-of-[0-9]+\.safetensors")
"""The names of shards in their folder."""

WHOLE_FILES = (".glb", ".vrm", ".ply")
"""Files that name no others, so that their bytes are the scene. Others are read by workers under the same path."""


def bake(
    scene: Path | Scene,
    output: Path,
    options: BakeOptions | None = None,
    *,
    client: Client | None = None,
    shards: int | None = None,
    progress: Callable[[int, int], object] | None = None,
) -> BakeReport:
    """Bakes on the workers of a Dask client, and writes the bytes of `lobe.bake`.

    Without a client a process of this machine is started that computes on all processors; `lobe.bake` does the same work without one. A .glb,
    .vrm or .ply is sent to the workers; of other scenes they read the files under the same path, as on a file system that they share.
    How many shards there are follows from what a worker measures that they cost, unless it is given. `progress(done, shards)` is called for each
    shard.

    A worker whose system refuses something, such as one with a full disk, gets no more shards while there is another, and is named by a warning;
    where none is left an error says what to do. Where there is no worker at all, a line on the standard error says that one is waited for.

    Shards that were done stay in the folder `OUTPUT.shards` until all are there; the same bake takes them up, with as many shards as before. While one
    bake is at work another into the same output is refused, which would take its shards away.
    """
    work = Work(scene, output, options or BakeOptions())
    with work.alone():
        with client_or_own(client) as engine, engine.as_current():
            shards = work.begun() if shards is None else shards
            parts = None if shards is None else work.parts(shards)
            if parts is None or parts.missing():
                with _ends_in_one_line(work):
                    workers = Workers(engine, work)
                    try:
                        parts = work.parts(_shards_for(workers, work)) if parts is None else parts
                        _bake_missing(workers, parts, work.pilot, progress)
                    finally:
                        workers.stop()
            elif progress is not None:
                progress(parts.count, parts.count)
        return work.merge(parts)


class Work:
    """A bake for workers: a scene that can be baked and an output that can be written, before anything is sent."""

    def __init__(self, scene: Path | Scene, output: Path, options: BakeOptions) -> None:
        self.scene, self.output = Scene.of(scene), os.fspath(output)
        if options.backs:
            raise ValueError("backs: not of shards; lobe.bake bakes them")
        # All machines do the same, whatever they know of the output.
        is_split = _lobe.is_bake_split(options.job(self.scene, output=output))
        self.options = replace(options, no_split=not is_split and options.texels is None and options.grid is None)
        self._made = self.options.of(self.scene)
        self._made.check_output(self.output)
        self.identity = identity_of(self._made, self.scene, self.options)
        self.pilot: Pilot | None = None
        self.taken_up = f"which takes up the shards that are done, in {self.output}.shards"
        """What becomes of shards, in messages."""

    @contextmanager
    def alone(self) -> Iterator[None]:
        """Keeps other bakes away from the output and its shards."""
        with locked(f"{self.output}.shards.lock") as is_alone:
            if not is_alone:
                raise RuntimeError(f"{self.output}: another bake into it is at work; wait for its end, or give another output")
            yield

    def know(self, pilot: Pilot | None) -> None:
        """Takes what the pilot has found on a worker: the others and the client need not make it again."""
        if pilot is not None:
            self._made.know(pilot)
        self.pilot = pilot

    def begun(self) -> int | None:
        """Of how many shards this bake has some already; of several such numbers that of which the largest share is done."""
        folder, start, end = f"{self.output}.shards", f"{self.identity}-", ".safetensors"
        names = os.listdir(folder) if os.path.isdir(folder) else []
        ends = [name[len(start) : -len(end)].partition("-of-")[2] for name in names if name.startswith(start) and name.endswith(end)]
        counts = [int(count) for count in ends if count.isdecimal()]
        return max(counts, key=lambda count: counts.count(count) / count, default=None)

    def parts(self, shards: int) -> Parts:
        """The files of so many shards, or of fewer if there are fewer points."""
        shards = min(whole(shards, "shards", 1, 1 << 20), max(1, self._made.points))
        parts = Parts(self.output, self.identity, shards)
        if others := parts.others():
            text = "of another scene, or of other options, than now: baked anew, and removed when the output is written"
            warnings.warn(f"{parts.folder}: {len(others)} shards are {text}", stacklevel=3)
        return parts

    def leave_out(
        self, refused: Refused, left_out: set[str], left: Callable[[], Collection[str]], kind: str, stacklevel: int
    ) -> None:
        """Adds who has refused to those that get no more tasks; an error if nobody is left, a warning the first time."""
        known = refused.place in left_out
        left_out.add(refused.place)
        if not left():
            raise OSError(f"{self.output}: {refused}; {refused.remedy}, and repeat the call, {self.taken_up}")
        if not known:
            warnings.warn(f"{refused}; other {kind} bake its shards: {refused.remedy}", stacklevel=stacklevel)

    def whole_scene(self) -> bytes | None:
        """The scene as bytes to be sent; none if workers read it by themselves."""
        name = self.scene.name
        if not name.endswith(WHOLE_FILES) or name.startswith("built-in:"):
            return None
        with open(name, "rb") as file:
            return file.read()

    def arguments(self) -> tuple[Scene, dict[str, Any], str, str]:
        """What `bake_shard` takes between the bytes of the scene and the number of the shard, and `measure` after the bytes."""
        name = self.scene.name
        scene = self.scene if name.startswith("built-in:") else self.scene.at(os.path.abspath(name))
        return scene, asdict(self.options), self.identity, __version__

    def merge(self, parts: Parts) -> BakeReport:
        """Writes the output from the files of all shards, and removes those."""
        report: BakeReport = self._made.merge(parts.paths(), self.output, None)
        parts.remove()
        return report


class Parts:
    """The files of shards in a folder beside the output."""

    def __init__(self, output: str, identity: str, count: int) -> None:
        self.folder, self.identity, self.count = f"{output}.shards", identity, count
        os.makedirs(self.folder, exist_ok=True)
        # A client that was killed while it wrote a shard has left what it wrote; that of one that still does stays.
        _lobe.clear_abandoned(self.path(1))

    def path(self, number: int) -> str:
        return os.path.join(self.folder, f"{self.identity}-{number}-of-{self.count}.safetensors")

    def paths(self) -> list[str]:
        return [self.path(number) for number in range(1, self.count + 1)]

    def missing(self) -> list[int]:
        return [number for number in range(1, self.count + 1) if not os.path.exists(self.path(number))]

    def keep(self, number: int, part: bytes) -> None:
        """Writes a shard; until it is whole and on the disk nothing has its name."""
        _lobe.write_whole(self.path(number), part)

    def others(self) -> list[str]:
        """Shards of other work for the same output: of a scene that was changed since, or of other options."""
        return [name for name in os.listdir(self.folder) if SHARD.fullmatch(name) and not name.startswith(f"{self.identity}-")]

    def remove(self) -> None:
        """Takes the shards away, those of earlier work for the same output too, and the folder if nothing else is in it."""
        _lobe.clear_abandoned(self.path(1))
        for name in os.listdir(self.folder):
            if SHARD.fullmatch(name):
                os.remove(os.path.join(self.folder, name))
        if not os.listdir(self.folder):
            os.rmdir(self.folder)


@contextmanager
def _ends_in_one_line(work: Work) -> Iterator[None]:
    """Says what to do where the engine, and not the work, has failed."""
    from distributed import KilledWorker

    try:
        yield
    except Gone:
        fault = f"{GONE}; start one and repeat the call"
    except KilledWorker as error:
        fault = f"{' '.join(str(error).split())} Give workers more memory, or repeat the call with more shards"
    else:
        return
    raise RuntimeError(f"{work.output}: {fault}, {work.taken_up}") from None


@dataclass(frozen=True)
class Task:
    """What a worker does, beside the arguments that all tasks of a bake have."""

    function: Callable[..., Any]
    name: str
    more: tuple[Any, ...] = ()


class Workers:
    """The workers of a client, those that have a bake's scene, without those whose system has refused a task of it."""

    def __init__(self, client: Client, work: Work) -> None:
        self._client, self._work = client, work
        self._refused: set[str] = set()
        self._ended: SimpleQueue[Any] = SimpleQueue()
        self._tries: dict[Any, int] = {}
        self.running: dict[Any, tuple[Task, list[str]]] = {}
        """Tasks that were given out, by their futures, and the workers that each was given to; none if to any."""
        self._waiting = Waiting(client)
        # Nothing can be sent to none.
        self._waiting.wait()
        scene = work.whole_scene()
        with asked():
            # None if workers read it by themselves.
            sent: Any = None if scene is None else client.scatter(scene, broadcast=True, hash=True)
        self._arguments = (sent, *work.arguments())

    def threads(self) -> int:
        """The threads of those that tasks are given to."""
        return sum(self._left().values())

    def _left(self) -> dict[str, int]:
        return {worker: count for worker, count in threads_of(self._client).items() if worker not in self._refused}

    def start(self, task: Task) -> None:
        # On any worker, also one that joins later; but where one has refused, on those that are left.
        chosen = list(self._left()) if self._refused else []
        # A call that was stopped may still be cancelling tasks of these names.
        key = f"lobe-{self._work.identity}-{task.name}-{uuid.uuid4().hex}"
        with asked():
            future = self._client.submit(
                task.function, *self._arguments, *task.more, key=key, pure=False, retries=RETRIES, workers=chosen or None
            )
        self.running[future] = (task, chosen)
        future.add_done_callback(self._ended.put)

    def ended(self) -> tuple[Task, Any]:
        """The next task that has ended on a worker that did not refuse it, and what it returned."""
        while True:
            try:
                future = self._ended.get(timeout=LOOK_SECONDS)
            except Empty:
                if self._waiting.look():
                    self._start_again()
                continue
            if future not in self.running:
                continue
            task, _ = self.running[future]
            tries = self._tries.get(future, 0)
            try:
                # What is long on its way gets more time from try to try.
                result = value_of(future, LOOK_SECONDS * 2**tries)
            except NotYet:
                # The worker that had the result may have died with it, and the task be for that one alone.
                self._tries[future] = tries + 1
                if self._waiting.look():
                    self._start_again()
                self._ended.put(future)
                continue
            # What the worker has is here now, and it may forget it.
            del self.running[future]
            future.release()
            if not isinstance(result, Refused):
                return task, result
            self._work.leave_out(result, self._refused, self._left, "workers", 5)
            self.start(task)

    def _start_again(self) -> None:
        """Gives to others what was for workers that are gone since."""
        there = threads_of(self._client)
        for future, (task, chosen) in list(self.running.items()):
            if chosen and not any(worker in there for worker in chosen):
                del self.running[future]
                cancel(self._client, [future])
                self.start(task)

    def stop(self) -> None:
        """Takes back what is not done."""
        cancel(self._client, [future for future in self.running if not future.done()])


def _shards_for(workers: Workers, work: Work) -> int:
    """Shards for the workers that are there when one of them has measured the cost."""
    workers.start(Task(measure, "cost"))
    cost: Cost = workers.ended()[1]
    work.know(cost.pilot)
    return shards_for(workers.threads(), cost)


def _bake_missing(workers: Workers, parts: Parts, pilot: Pilot | None, progress: Callable[[int, int], object] | None) -> None:
    missing = parts.missing()[::-1]
    left = len(missing)
    if progress is not None:
        progress(parts.count - left, parts.count)

    def start() -> None:
        room = AHEAD * max(1, workers.threads()) - len(workers.running)
        for _ in range(min(len(missing), max(0, room))):
            number = missing.pop()
            workers.start(Task(bake_shard, f"{number}-of-{parts.count}", (number, parts.count, pilot)))

    start()
    while left:
        task, part = workers.ended()
        parts.keep(task.more[0], part)
        left -= 1
        start()
        if progress is not None:
            progress(parts.count - left, parts.count)


def _numbers(kind: Callable[[str], float]) -> Callable[[str], tuple[float, ...]]:
    def numbers(text: str) -> tuple[float, ...]:
        return tuple(kind(part) for part in text.split(","))

    return numbers


def _switch(text: str) -> bool:
    return bool(("off", "on").index(text))


TYPES: dict[str, Callable[[str], Any]] = {"bool": _switch, "int": int, "float": float, "str": str, "tuple[int": _numbers(int), "tuple[float": _numbers(float)}
"""How options are read, by how their types begin."""


class _Parser(argparse.ArgumentParser):
    """Says in one line what it does not understand, and not the usage of all options."""

    def error(self, message: str) -> NoReturn:
        self.exit(2, f"error: {' '.join(message.split())}; {self.prog} --help lists the arguments\n")


def _bake_by(scheduler: str | None, scene: Scene, output: str, options: BakeOptions, shards: int | None) -> None:
    """A bake of the command, whose progress is told."""
    from distributed import Client

    def tell(done: int, count: int) -> None:
        print(f"progress: {done} of {count} shards", file=sys.stderr)

    client = None if scheduler is None else Client(scheduler, timeout=10, set_as_default=False)
    try:
        bake(scene, output, options, client=client, shards=shards, progress=tell)
    finally:
        if client is not None:
            client.close()


STOPPED = 130
"""The exit code of what Ctrl-C has stopped."""


def main(arguments: list[str] | None = None) -> int:
    """The command; errors are one line, and exit code 2."""
    parser = _Parser(prog="python -m lobe.distributed", description="Bake a scene on the workers of a Dask scheduler.")
    parser.add_argument("scene", help="a .glb, .gltf, .obj or .ply file, or built-in:NAME")
    parser.add_argument("-o", "--output", required=True, help="a .glb or .safetensors file")
    parser.add_argument("--scheduler", help="its address, such as tcp://10.0.0.1:8786 [default: a process on this machine]")
    parser.add_argument("--shards", type=int, help="parts of the work [default: by what a worker measures that they cost]")
    shared = fields(BakeOptions)
    for field in shared:
        name = "--" + field.name.replace("_", "-")
        if field.default is False:
            parser.add_argument(name, action="store_true", help="see lobe.BakeOptions")
            continue
        kind = TYPES[str(field.type).split(" |")[0].split(",")[0]]
        parser.add_argument(name, type=kind, default=field.default, help=f"[default: {field.default}]")
    read = [field for field in fields(Scene) if field.name != "path"]
    for field in read:
        name = "--" + field.name.replace("_", "-")
        if isinstance(field.default, bool):
            parser.add_argument(name, action="store_true", help="see lobe.Scene")
        else:
            parser.add_argument(name, type=int if field.name.startswith("max_") else str, default=field.default, help="see lobe.Scene")
    given = parser.parse_args(arguments)
    options = {field.name: getattr(given, field.name) for field in shared}
    reading = {field.name: getattr(given, field.name) for field in read}

    def warn(message: Warning | str, *_: object, **__: object) -> None:
        print(f"warning: {' '.join(str(message).split())}", file=sys.stderr)

    try:
        with warnings.catch_warnings():
            warnings.showwarning = warn
            _bake_by(given.scheduler, Scene(given.scene, **reading), given.output, BakeOptions(**options), given.shards)
    except ModuleNotFoundError as error:
        print(f"error: {error}; pip install distributed", file=sys.stderr)
        return 2
    except (OSError, RuntimeError, TypeError, ValueError) as error:
        print(f"error: {' '.join(str(error).split())}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("error: stopped; the same command takes up the shards that are done", file=sys.stderr)
        return STOPPED
    return 0


if __name__ == "__main__":
    sys.exit(main())
