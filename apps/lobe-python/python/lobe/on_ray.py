"""Bakes on the machines of a Ray cluster: the shards, files and bytes of `lobe.distributed`.

Needs `pip install ray filelock`.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from ._bake import BakeOptions, BakeReport
from ._engine import RETRIES, Engine, Work, bake_on
from ._scene import Path, Scene
from ._tasks import Refused, bake_shard

__all__ = ["bake"]


def bake(
    scene: Path | Scene,
    output: Path,
    options: BakeOptions | None = None,
    *,
    shards: int | None = None,
    progress: Callable[[int, int], object] | None = None,
) -> BakeReport:
    """Bakes on the cluster that `ray.init` has connected to, or on this machine, and writes the bytes of `lobe.bake`.

    It does what `lobe.distributed.bake` does, with the same files: a bake that was begun on one goes on with the other.
    A shard takes all processors of a machine, and there are 64 for each machine, unless `shards` says otherwise.
    Machines that join later are given shards too, if they have as many processors as the smallest of the first.
    """
    return bake_on(_connected, scene, output, options, shards, progress)


@contextmanager
def _connected(work: Work) -> Iterator[Engine]:
    """A cluster, for so long one of this machine if there is none."""
    import ray
    from ray.exceptions import LocalRayletDiedError, RayError

    is_own = not ray.is_initialized()
    if is_own:
        ray.init(include_dashboard=False, log_to_driver=False)
    try:
        machines = Machines(work)
        try:
            yield machines
        finally:
            machines.stop()
    except LocalRayletDiedError:
        fault = "the Ray cluster is gone; start one, `ray.shutdown()` and `ray.init()` here"
        raise RuntimeError(work.ended_by(fault)) from None
    except RayError as error:
        # A traceback follows.
        fault = str(error).partition("\n")[0].rstrip(".")
        raise RuntimeError(work.ended_by(f"{fault}; mend that")) from None
    finally:
        if is_own:
            ray.shutdown()


class Machines(Engine):
    """The machines of a Ray cluster."""

    kind = "machines"

    def __init__(self, work: Work) -> None:
        import ray

        super().__init__(work)
        self._processors = 1
        if not (found := self.places()):
            remedy = "start one, or `ray.shutdown()` for this machine alone"
            raise RuntimeError(f"the Ray cluster has no machine with processors: {remedy}")
        self._processors = min(_processors()[place] for place in found)
        self._scene = ray.put(work.whole_scene())
        # All processors of the smallest machine: no two tasks on one, unless another has twice as many.
        self._task: Any = ray.remote(num_cpus=self._processors, max_retries=RETRIES, retry_exceptions=True)(bake_shard)
        self._running: dict[Any, int] = {}
        self._turns = itertools.count()

    def places(self) -> dict[str, int]:
        return {place: 1 for place, processors in _processors().items() if processors >= self._processors}

    def start(self, number: int, count: int) -> None:
        from ray.util.scheduling_strategies import NodeAffinitySchedulingStrategy

        strategy: Any = "SPREAD"
        if self.refused and (left := list(self.left())):
            # On the next of those that are left, and on another should it die.
            strategy = NodeAffinitySchedulingStrategy(left[next(self._turns) % len(left)], soft=True)
        task = self._task.options(scheduling_strategy=strategy)
        self._running[task.remote(self._scene, self.work.job, number, count)] = number

    def ended(self) -> tuple[int, bytes | Refused]:
        import ray
        from ray.exceptions import RayTaskError

        [ready], _ = ray.wait(list(self._running))
        try:
            result: bytes | Refused = ray.get(ready)
        except RayTaskError as error:
            raise error.cause from None
        return self._running.pop(ready), result

    def stop(self) -> None:
        import ray

        for task in self._running:
            ray.cancel(task, force=True)


def _processors() -> dict[str, int]:
    """The processors of each machine that is there."""
    import ray

    return {node["NodeID"]: int(node["Resources"].get("CPU", 0)) for node in ray.nodes() if node["Alive"]}
