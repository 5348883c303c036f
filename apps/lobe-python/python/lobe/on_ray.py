"""Bakes on the machines of a Ray cluster: the shards, files and bytes of `lobe.distributed`. Needs `pip install ray`."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ._bake import BakeOptions, BakeReport, Path
from .distributed import RETRIES, Parts, Work, bake_shard, shards_for

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
        parts = work.parts(shards_for(len(processors)) if shards is None else shards)
        _bake_missing(work, parts, int(min(processors)), AHEAD * len(processors), progress)
    finally:
        if own:
            ray.shutdown()
    return work.merge(parts)


def _bake_missing(
    work: Work, parts: Parts, processors: int, at_most: int, progress: Callable[[int, int], object] | None
) -> None:
    import ray
    from ray.exceptions import RayError, RayTaskError

    # All processors of the smallest machine: no two shards on one, unless another has twice as many.
    task: Any = ray.remote(num_cpus=processors, max_retries=RETRIES, retry_exceptions=True, scheduling_strategy="SPREAD")(bake_shard)
    missing = parts.missing()[::-1]
    done = parts.count - len(missing)
    if progress is not None:
        progress(done, parts.count)
    if not missing:
        return
    arguments = (ray.put(work.whole_scene()), *work.arguments(parts))
    running: dict[Any, int] = {}
    try:
        while missing or running:
            while missing and len(running) < at_most:
                number = missing.pop()
                running[task.remote(*arguments, number, parts.count)] = number
            [ready], _ = ray.wait(list(running))
            try:
                part = ray.get(ready)
            except RayTaskError as error:
                raise error.cause from None
            except RayError as error:
                raise RuntimeError(f"shard {running[ready]} of {parts.count}: {' '.join(str(error).split())}") from None
            parts.keep(running.pop(ready), part)
            done += 1
            if progress is not None:
                progress(done, parts.count)
    finally:
        for left in running:
            ray.cancel(left, force=True)
