"""Bakes on the machines of a Ray cluster: the shards, files and bytes of `lobe.distributed`. Needs `pip install ray`."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ._bake import BakeOptions, BakeReport, Path
from ._shards import Cost, shards_for
from ._tasks import bake_shard, measure
from .distributed import RETRIES, Parts, Work

AHEAD = 4
"""Shards that are handed out for each machine at a time: one that is baked, and some that wait, so that none has to ask."""


def bake(
    scene: Path,
    output: Path,
    options: BakeOptions | None = None,
    *,
    shards: int | None = None,
    progress: Callable[[int, int], object] | None = None,
) -> BakeReport:
    """Bakes on the cluster that `ray.init` has connected to, or on this machine, and writes the bytes of `lobe.bake`.

    A shard takes all processors of a machine. A .glb, .vrm or .ply is sent to each machine once; of other scenes they read the files under
    the same path. `progress(done, shards)` is called for each shard. A shard whose worker died or that failed is tried again; those that are
    done stay in the folder `OUTPUT.shards` until all are there, and the same bake takes them up, on Dask as well.
    """
    import ray

    work = Work(scene, output, options or BakeOptions())
    own = not ray.is_initialized()
    if own:
        ray.init(include_dashboard=False, log_to_driver=False)
    try:
        processors = [node["Resources"].get("CPU", 0.0) for node in ray.nodes() if node["Alive"]]
        processors = [count for count in processors if count >= 1]
        if not processors:
            raise RuntimeError("the Ray cluster has no machine with processors: start one, or `ray.shutdown()` for this machine alone")
        machines = Machines(work, int(min(processors)), len(processors))
        shards = work.begun() if shards is None else shards
        parts = work.parts(machines.shards() if shards is None else shards)
        machines.bake_missing(parts, progress)
    finally:
        if own:
            ray.shutdown()
    return work.merge(parts)


class Machines:
    """Machines that a bake is sent to, once there is something to do."""

    def __init__(self, work: Work, processors: int, count: int) -> None:
        self._work, self._processors, self._count = work, processors, count
        self._arguments: tuple[Any, ...] | None = None

    def shards(self) -> int:
        """Shards for these machines, by what one of them measures that they cost."""
        cost: Cost = _result(self._start(measure), "the cost of shards")
        self._work.know(cost.pilot)
        return shards_for(self._count, cost)

    def bake_missing(self, parts: Parts, progress: Callable[[int, int], object] | None) -> None:
        import ray

        missing = parts.missing()[::-1]
        done = parts.count - len(missing)
        if progress is not None:
            progress(done, parts.count)
        running: dict[Any, int] = {}
        try:
            while missing or running:
                while missing and len(running) < AHEAD * self._count:
                    number = missing.pop()
                    running[self._start(bake_shard, number, parts.count, self._work.pilot)] = number
                [ready], _ = ray.wait(list(running))
                part = _result(ready, f"shard {running[ready]} of {parts.count}")
                parts.keep(running.pop(ready), part)
                done += 1
                if progress is not None:
                    progress(done, parts.count)
        finally:
            for left in running:
                ray.cancel(left, force=True)

    def _start(self, function: Callable[..., Any], *more: Any) -> Any:
        """A task on one of the machines, which have the scene from the first on."""
        import ray

        if self._arguments is None:
            self._arguments = (ray.put(self._work.whole_scene()), *self._work.arguments())
        # All processors of the smallest machine: no two tasks on one, unless another has twice as many.
        task: Any = ray.remote(num_cpus=self._processors, max_retries=RETRIES, retry_exceptions=True, scheduling_strategy="SPREAD")(function)
        return task.remote(*self._arguments, *more)


def _result(ready: Any, what: str) -> Any:
    """What a task returned; its error, or one line about its end."""
    import ray
    from ray.exceptions import RayError, RayTaskError

    try:
        return ray.get(ready)
    except RayTaskError as error:
        raise error.cause from None
    except RayError as error:
        raise RuntimeError(f"{what}: {' '.join(str(error).split())}") from None
