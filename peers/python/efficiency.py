"""How well bakes in shards use 16, 256 and 4096 workers: the model of the guide, and the same with stragglers, by simulation.

    python peers/python/efficiency.py

A shard goes to the worker that is free first. A worker reads the scene once, which takes T0; shards differ, as interiors cost more than a
plane under the sky; some workers are slow; some die, and what they did last is done again. Efficiency is the work of one machine by the time
of all. Python's own random numbers, seeded: the same table everywhere.
"""

import argparse
import heapq
import random

WORK = 100 * 3600.0
"""Seconds of the bake on one worker: a hundred hours."""

READING = 60.0
"""Seconds until a worker has the scene and its tree: some ten million triangles."""

SPREAD = 0.5
"""Standard deviation of the logarithm of a shard's time: two shards in three are within a factor of 1.6 of the middle one."""

MERGE_RATE = 500e6
"""Bytes a second that the merging process copies."""

OUTPUT = 4e9
"""Bytes of the output: a million receivers of glossy matrices at order 5 and some more."""

SLOW_SHARE, SLOWNESS = 0.05, 3.0
"""One worker in twenty takes three times as long, as machines do that others use."""

LOST_SHARE = 0.02
"""Workers that die in the middle of a shard, once."""


def shards_of(count, spread, seed):
    """Times of shards that sum to WORK."""
    numbers = random.Random(seed)
    times = [numbers.lognormvariate(0.0, spread) for _ in range(count)]
    scale = WORK / sum(times)
    return [scale * t for t in times]


def time_of(shards, workers, *, reading=READING, slow=0.0, lost=0.0, seed=1):
    """Seconds until the last shard is done, in the order in which shards are given."""
    numbers = random.Random(seed)
    speed = [SLOWNESS if numbers.random() < slow else 1.0 for _ in range(workers)]
    dies = [numbers.random() < lost for _ in range(workers)]
    waiting = list(reversed(shards))
    free = [(reading * speed[w], w) for w in range(workers)]
    heapq.heapify(free)
    end = 0.0
    while waiting:
        now, w = heapq.heappop(free)
        shard = waiting.pop()
        if dies[w]:
            # It is lost half-way; another worker gets it as soon as one is free, and this one starts again with reading.
            dies[w] = False
            waiting.append(shard)
            heapq.heappush(free, (now + (0.5 * shard + reading) * speed[w], w))
            continue
        done = now + shard * speed[w]
        end = max(end, done)
        heapq.heappush(free, (done, w))
    return end


RUNS = 20
"""Bakes that are averaged."""


def efficiency(workers, per_worker, *, slow, lost):
    """The mean of several bakes."""
    seconds = 0.0
    for seed in range(RUNS):
        shards = shards_of(workers * per_worker, SPREAD, seed)
        seconds += (time_of(shards, workers, slow=slow, lost=lost, seed=seed) + OUTPUT / MERGE_RATE) / RUNS
    return WORK / (workers * seconds)


def model(workers, per_worker):
    """The guide's formula: reading, an equal share of the work, half a shard of tail, and the merge."""
    share = WORK / workers
    return share / (READING + share + 0.5 * share / per_worker + OUTPUT / MERGE_RATE)


def check():
    """Cases with known answers."""
    assert time_of([1.0] * 8, 4, reading=0.0) == 2.0, "equal shards in two rounds"
    assert time_of([1.0] * 9, 4, reading=0.0) == 3.0, "one more has a round of its own"
    assert time_of([3.0, 1.0, 1.0, 1.0], 2, reading=5.0) == 8.0, "the long one first, the others beside it"
    assert time_of([2.0], 1, reading=1.0, lost=1.0) == 1.0 + (1.0 + 1.0) + 2.0, "half a shard, reading, and all of it again"
    assert time_of([2.0], 1, reading=1.0, slow=1.0) == SLOWNESS * 3.0, "slow in everything"


def main():
    argparse.ArgumentParser(description="Simulate bakes in shards on many workers.").parse_args()
    check()
    print(f"{'workers':>8} {'shards each':>12} {'model':>7} {'uneven':>7} {'+ slow':>7} {'+ lost':>7}")
    for workers in [16, 256, 4096]:
        for per_worker in [1, 4, 16, 64]:
            kinds = [(0.0, 0.0), (SLOW_SHARE, 0.0), (SLOW_SHARE, LOST_SHARE)]
            found = [efficiency(workers, per_worker, slow=slow, lost=lost) for slow, lost in kinds]
            columns = " ".join(f"{100 * e:>6.0f}%" for e in [model(workers, per_worker), *found])
            print(f"{workers:>8} {per_worker:>12} {columns}")


if __name__ == "__main__":
    main()
