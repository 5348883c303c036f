"""The number of shards of a bake, by what a worker measures that they cost."""

from __future__ import annotations

import math
import os
import time
from dataclasses import dataclass

from . import _lobe

SHARDS_PER_TASK = 64
"""Shards for each task that the workers do at a time: enough that neither uneven shards nor slow workers leave the others idle for long,
by the table of the chapter on sharing work. The end of the last one, of 16 for each of two workers, cost 3 % of five minutes."""

MOST_SECONDS = 30.0
"""What a shard takes at most, if the client can hand out so many: a worker that dies loses no more, and one that is slow keeps the others waiting for
some of these at the end."""

LEAST_SECONDS = 1.0
"""What a shard takes at least: the client and the network add some milliseconds to each."""

MOST_OVERHEAD = 0.05
"""The part of a shard's time that may go by before its first receiver: the whole scene is hashed for each, to be sure that it is the same."""

MOST_SHARDS = 1 << 14
"""Shards at most, unless there are more tasks: each costs the client 2.4 ms, by a thousand that were measured, thus these some 40 s."""

MOST_BYTES = 1 << 26
"""Results of a shard at most, whatever they cost: the worker has them in memory, and so has the client, one after the other."""

PLACES = 4
"""Runs of receivers that are measured, spread evenly, as neighbors cost alike and parts of a scene do not."""

MEASURED_SECONDS = 0.2
"""What each of these runs takes at least, unless all receivers take less: one thread has some receivers for milliseconds, so that all threads of a
machine are busy for most of it."""

PATIENCE_SECONDS = 5.0
"""What measuring may take where beginning a shard takes longer than its receivers."""


@dataclass(frozen=True)
class Cost:
    """Seconds of one worker, by itself, and what comes of them."""

    shard: float
    """What each shard takes beside its receivers."""
    work: float
    """What all receivers take."""
    size: int = 0
    """Bytes of the results of all receivers."""
    pilot: tuple[int, int, float] | None = None
    """What the pilot of the bake has found, which the other workers need not make again."""


def measured(made: _lobe.Bake, folder: str) -> Cost:
    """The cost of a bake, from runs of receivers that grow until they take long enough; files are written to the folder, and removed."""
    path = os.path.join(folder, f"cost-{os.getpid()}.safetensors")

    def seconds_of(number: int, count: int) -> tuple[float, int]:
        begun = time.perf_counter()
        report = made.write_shard(path, number, count, None)
        took = time.perf_counter() - begun
        os.remove(path)
        return took, report["receivers"]

    # The first shard finds the tree and the pilot. Of so many shards it has no receivers, or one of a million.
    seconds_of(1, 1 << 20)
    shard, _ = seconds_of(1, 1 << 20)
    begun, count = time.perf_counter(), min(max(made.points, PLACES), 1 << 20)
    while True:
        runs = [seconds_of(1 + (2 * place + 1) * count // (2 * PLACES), count) for place in range(PLACES)]
        seconds = sum(max(took - shard, 0.0) for took, _ in runs)
        receivers = sum(receivers for _, receivers in runs)
        is_enough = seconds >= PLACES * MEASURED_SECONDS or time.perf_counter() - begun >= PATIENCE_SECONDS
        if count == PLACES or (receivers > 0 and is_enough):
            return Cost(shard, seconds * made.points / max(receivers, 1), made.bytes, made.pilot)
        count = max(PLACES, count // 4)


def shards_for(tasks: int, cost: Cost) -> int:
    """Shards for workers that do so many tasks at a time."""
    tasks = max(1, tasks)
    seconds = min(cost.work / (SHARDS_PER_TASK * tasks), MOST_SECONDS)
    seconds = max(seconds, LEAST_SECONDS, cost.shard / MOST_OVERHEAD)
    wanted = min(max(math.ceil(cost.work / seconds), tasks), max(MOST_SHARDS, tasks))
    return max(wanted, math.ceil(cost.size / MOST_BYTES))
