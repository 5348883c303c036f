"""A bake in shards on the workers of an engine: all that does not depend on whether it is Dask or Ray."""

from __future__ import annotations

import math
import os
import warnings
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, suppress
from dataclasses import asdict, replace

from . import __version__, _lobe
from ._arrays import whole
from ._bake import BakeOptions, BakeReport
from ._scene import Path, Progress, Scene
from ._shards import Shards, begun, found_in
from ._tasks import Job, Refused, identity_of

RETRIES = 3
"""Times that a shard is tried again after an error."""

AHEAD = 4
"""Shards that are handed out for each thread of a worker at a time: one that is baked, and some that wait or whose
results do. No worker has to ask for work, and none keeps more results."""

SHARDS_EACH = 64
"""Shards for each thread of a worker: enough that neither uneven shards nor slow workers leave the others idle for
long, by the table of the chapter on sharing work."""

MOST_SHARDS = 1 << 20
"""Shards of a bake at most, each of which is a file."""

MOST_BYTES = 1 << 26
"""Results of a shard at most: the worker has them in memory, and so has the client, one after the other."""

WHOLE_FILES = (".glb", ".vrm", ".ply")
"""Files that name no others, so that their bytes are the scene. Others are read by workers under the same path."""


class Work:
    """A bake for workers: a scene that can be baked and an output that can be written, before anything is sent."""

    def __init__(self, scene: Path | Scene, output: Path, options: BakeOptions) -> None:
        self.scene, self.output = Scene.of(scene), os.fspath(output)
        if options.backs:
            raise ValueError("backs: not of shards; lobe.bake bakes them")
        # All machines do the same, whatever they know of the output.
        is_split = _lobe.is_bake_split(options.job(self.scene, output=output))
        options = replace(options, no_split=not is_split and options.texels is None and options.grid is None)
        self._made = options.of(self.scene)
        self._made.check_output(self.output)
        self.identity = identity_of(self._made, self.scene, options)
        name = self.scene.name
        found = self.scene if name.startswith("built-in:") else self.scene.at(os.path.abspath(name))
        self.job = Job(found, asdict(options), self.identity, __version__)
        self.folder = f"{self.output}.shards"

    @contextmanager
    def alone(self) -> Iterator[None]:
        """Keeps other bakes away from the output and its shards."""
        from filelock import FileLock, Timeout

        try:
            with FileLock(f"{self.folder}.lock", timeout=0) as lock:
                yield
                # Who opened it meanwhile finds out that it is gone: `filelock` looks, from 4.0 on. Windows keeps it.
                with suppress(OSError):
                    os.remove(lock.lock_file)
        except Timeout:
            fault = "another bake into it is at work; wait for its end, or give another output"
            raise RuntimeError(f"{self.output}: {fault}") from None

    def whole_scene(self) -> bytes | None:
        """The scene as bytes to be sent; none if workers read it by themselves."""
        name = self.scene.name
        if not name.endswith(WHOLE_FILES) or name.startswith("built-in:"):
            return None
        with open(name, "rb") as file:
            return file.read()

    def shards(self, count: int) -> Shards:
        """The files of so many shards, or of fewer if there are fewer points."""
        count = min(whole(count, "shards", 1, MOST_SHARDS), max(1, self._made.points))
        others = sum(found[1] != self.identity for found in found_in(self.folder))
        if others:
            text = "of another scene, or of other options, than now: baked anew, and removed when the output is written"
            warnings.warn(f"{self.folder}: {others} shards are {text}", stacklevel=4)
        return Shards(self.folder, self.identity, count)

    def shards_for(self, threads: int) -> int:
        """How many shards there are for workers with so many threads, unless it is given."""
        return min(MOST_SHARDS, max(SHARDS_EACH * max(1, threads), math.ceil(self._made.bytes / MOST_BYTES)))

    def merge(self, shards: Shards) -> BakeReport:
        """Writes the output from the files of all shards, and removes those."""
        report: BakeReport = self._made.merge(shards.paths, self.output, None)
        shards.remove()
        return report

    def ended_by(self, fault: str) -> str:
        """The message of a bake that ends before all shards are there."""
        return f"{self.output}: {fault}, and repeat the call, which takes up the shards that are done, in {self.folder}"


class Engine(ABC):
    """The workers of Dask or Ray, without those whose system has refused something."""

    kind = "workers"

    def __init__(self, work: Work) -> None:
        self.work = work
        self.refused: set[str] = set()

    @abstractmethod
    def places(self) -> dict[str, int]:
        """The workers that are there, and how many shards each bakes at a time."""

    @abstractmethod
    def start(self, number: int, count: int) -> None:
        """Hands out a shard: to any worker, but where one has refused, to those that are left."""

    @abstractmethod
    def ended(self) -> tuple[int, bytes | Refused]:
        """Waits for one of the shards that were handed out: its number, and what its task returned."""

    @abstractmethod
    def stop(self) -> None:
        """Takes back what is not done."""

    def unfit(self) -> list[Refused]:
        """Workers that cannot bake, as far as the engine knows."""
        return []

    def left(self) -> dict[str, int]:
        return {place: count for place, count in self.places().items() if place not in self.refused}

    def leave_out(self, refused: Refused) -> None:
        """Gives this worker no more shards: an error if nobody is left, a warning the first time."""
        is_known = refused.place in self.refused
        self.refused.add(refused.place)
        if not self.left():
            raise OSError(self.work.ended_by(str(refused)))
        if not is_known:
            warnings.warn(f"{refused}; other {self.kind} bake its shards", stacklevel=5)

    def bake(self, shards: Shards, progress: Progress) -> None:
        """Bakes the shards that are missing."""
        for unfit in self.unfit():
            self.leave_out(unfit)
        waiting = shards.missing()[::-1]
        left, running = len(waiting), 0
        progress(shards.count - left, shards.count)
        while left:
            room = AHEAD * max(1, sum(self.left().values())) - running
            for _ in range(min(room, len(waiting))):
                self.start(waiting.pop(), shards.count)
                running += 1
            number, result = self.ended()
            running -= 1
            if isinstance(result, Refused):
                self.leave_out(result)
                waiting.append(number)
                continue
            shards.keep(number, result)
            left -= 1
            progress(shards.count - left, shards.count)


def bake_on(
    connect: Callable[[Work], AbstractContextManager[Engine]],
    scene: Path | Scene,
    output: Path,
    options: BakeOptions | None,
    count: int | None,
    progress: Progress | None,
) -> BakeReport:
    """A bake on an engine, which is connected to if there is something to do."""
    work, tell = Work(scene, output, options or BakeOptions()), progress or (lambda done, count: None)
    with work.alone():
        count = begun(work.folder, work.identity) if count is None else count
        shards = None if count is None else work.shards(count)
        if shards is None or shards.missing():
            with connect(work) as engine:
                shards = shards or work.shards(work.shards_for(sum(engine.places().values())))
                engine.bake(shards, tell)
        else:
            tell(shards.count, shards.count)
        return work.merge(shards)
