"""Bakes on the machines of a Ray cluster: the shards, files and bytes of `lobe.distributed`. Needs `pip install ray`."""

from __future__ import annotations

import socket
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from ._bake import BakeOptions, BakeReport
from ._scene import Path, Scene
from ._shards import Cost, shards_for
from ._tasks import Refused, bake_shard, measure
from .distributed import RETRIES, Parts, Work

AHEAD = 4
"""Shards that are handed out for each machine at a time: one that is baked, and some that wait, so that none has to ask."""

LOOK_SECONDS = 2.0
"""How often one looks for the head of the cluster while no shard comes."""

HEAD_SECONDS = 30.0
"""How long the head may be gone, as one that is started again is, before the bake ends: Ray ends the whole process after 60 s, and says nothing of
what to do."""


def bake(
    scene: Path | Scene,
    output: Path,
    options: BakeOptions | None = None,
    *,
    shards: int | None = None,
    progress: Callable[[int, int], object] | None = None,
) -> BakeReport:
    """Bakes on the cluster that `ray.init` has connected to, or on this machine, and writes the bytes of `lobe.bake`.

    A shard takes all processors of a machine. A .glb, .vrm or .ply is sent to each machine once; of other scenes they read the files under
    the same path. `progress(done, shards)` is called for each shard. A shard whose worker died or that failed is tried again; those that are
    done stay in the folder `OUTPUT.shards` until all are there, and the same bake takes them up, on Dask as well. Machines that join later are
    given shards too, if they have as many processors as the smallest of the first. A machine whose system refuses something, such as one with a full
    disk, gets no more while there is another, and is named by a warning. Where the cluster itself dies, an error says so in one line. While one bake is at
    work another into the same output is refused.
    """
    work = Work(scene, output, options or BakeOptions())
    with work.alone():
        with _ray() as processors:
            machines = Machines(work, processors)
            shards = work.begun() if shards is None else shards
            with _ends_in_one_line(work):
                parts = work.parts(machines.shards() if shards is None else shards)
                machines.bake_missing(parts, progress)
        return work.merge(parts)


@contextmanager
def _ray() -> Iterator[int]:
    """A cluster, for so long one of this machine if there is none; the processors of its smallest machine."""
    import ray

    own = not ray.is_initialized()
    if own:
        ray.init(include_dashboard=False, log_to_driver=False)
    try:
        processors = [count for node in _machines() if (count := node["Resources"].get("CPU", 0.0)) >= 1]
        if not processors:
            raise RuntimeError("the Ray cluster has no machine with processors: start one, or `ray.shutdown()` for this machine alone")
        yield int(min(processors))
    finally:
        if own:
            ray.shutdown()


def _machines() -> list[dict[str, Any]]:
    """The machines of the cluster that are there."""
    import ray

    return [node for node in ray.nodes() if node["Alive"]]


class _HeadIsGone(Exception):
    """The head of the cluster does not answer any more."""


class Head:
    """The head of the cluster, without which Ray hands out nothing and waits, until it ends this process."""

    def __init__(self) -> None:
        import ray

        host, _, port = ray.get_runtime_context().gcs_address.rpartition(":")
        self._address, self._seen = (host.strip("[]"), int(port)), time.monotonic()

    def answers(self) -> bool:
        """Whether it answers now; an error if it has not done so for too long."""
        try:
            socket.create_connection(self._address, timeout=LOOK_SECONDS).close()
        except OSError:
            if time.monotonic() - self._seen >= HEAD_SECONDS:
                raise _HeadIsGone from None
            return False
        self._seen = time.monotonic()
        return True


class Machines:
    """Machines that a bake is sent to, once there is something to do."""

    def __init__(self, work: Work, processors: int) -> None:
        self._work, self._processors = work, processors
        self._head = Head()
        self._arguments: tuple[Any, ...] | None = None
        self._refused: set[str] = set()
        self._turn = 0

    def _left(self) -> list[str]:
        """The identities of those that are there now, have enough processors and have refused nothing."""
        machines = [node for node in _machines() if node["NodeID"] not in self._refused]
        return [node["NodeID"] for node in machines if node["Resources"].get("CPU", 0.0) >= self._processors]

    def count(self) -> int:
        return max(1, len(self._left()))

    def shards(self) -> int:
        """Shards for these machines, by what one of them measures that they cost."""
        while True:
            task = self._start(measure)
            while not self._wait([task]):
                self._head.answers()
            cost: Cost | Refused = _result(task)
            if not isinstance(cost, Refused):
                self._work.know(cost.pilot)
                return shards_for(self.count(), cost)
            self._work.leave_out(cost, self._refused, self._left, "machines", 4)

    def bake_missing(self, parts: Parts, progress: Callable[[int, int], object] | None) -> None:
        import ray

        missing = parts.missing()[::-1]
        done = parts.count - len(missing)
        if progress is not None:
            progress(done, parts.count)
        running: dict[Any, int] = {}
        try:
            while missing or running:
                # Without a head Ray would wait for one here.
                room = AHEAD * self.count() - len(running) if self._head.answers() else 0
                for number in [missing.pop() for _ in range(min(room, len(missing)))]:
                    running[self._start(bake_shard, number, parts.count, self._work.pilot)] = number
                for ready in self._wait(list(running)):
                    number, part = running.pop(ready), _result(ready)
                    if isinstance(part, Refused):
                        self._work.leave_out(part, self._refused, self._left, "machines", 4)
                        missing.append(number)
                        continue
                    parts.keep(number, part)
                    done += 1
                    if progress is not None:
                        progress(done, parts.count)
        finally:
            for left in running:
                ray.cancel(left, force=True)

    def _wait(self, running: list[Any]) -> list[Any]:
        """One of these tasks that has ended, or none after a while."""
        import ray

        if not running:
            time.sleep(LOOK_SECONDS)
            return []
        ready, _ = ray.wait(running, timeout=LOOK_SECONDS)
        return list(ready)

    def _start(self, function: Callable[..., Any], *more: Any) -> Any:
        """A task on one of the machines, which have the scene from the first on."""
        import ray
        from ray.util.scheduling_strategies import NodeAffinitySchedulingStrategy

        if self._arguments is None:
            self._arguments = (ray.put(self._work.whole_scene()), *self._work.arguments())
        strategy: Any = "SPREAD"
        if self._refused and (left := self._left()):
            # On the next of those that are left, and on another should it die.
            self._turn += 1
            strategy = NodeAffinitySchedulingStrategy(left[self._turn % len(left)], soft=True)
        # All processors of the smallest machine: no two tasks on one, unless another has twice as many.
        task: Any = ray.remote(num_cpus=self._processors, max_retries=RETRIES, retry_exceptions=True, scheduling_strategy=strategy)(function)
        return task.remote(*self._arguments, *more)


def _result(ready: Any) -> Any:
    """What a task returned, or its error."""
    import ray
    from ray.exceptions import RayTaskError

    try:
        return ray.get(ready)
    except RayTaskError as error:
        raise error.cause from None


@contextmanager
def _ends_in_one_line(work: Work) -> Iterator[None]:
    """Says what to do where the engine, and not the work, has failed."""
    from ray.exceptions import LocalRayletDiedError, RayError

    try:
        yield
    except (_HeadIsGone, LocalRayletDiedError):
        fault = "the Ray cluster is gone; start one, `ray.shutdown()` and `ray.init()` here"
    except RayError as error:
        fault = f"{' '.join(str(error).split())} Give machines more memory"
    else:
        return
    raise RuntimeError(f"{work.output}: {fault}, and repeat the call, {work.taken_up}") from None
