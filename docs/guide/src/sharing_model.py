"""What a bake on many machines takes, by simulation: the table of the chapter "Sharing work among machines".

    python docs/guide/src/sharing_model.py                     # the table
    python docs/guide/src/sharing_model.py --work 3600 --setup 2

Machines take shards one after the other, each when it is free. Efficiency is W / (N T): the time that one machine computes, over what N machines
are held until the last shard is on the client's disk. Random numbers have fixed seeds; needs Python alone.
"""

import argparse
import dataclasses
import heapq
import math
import random
import statistics

SEEDS = 5
"""Runs of each cell; the median is printed."""

MACHINES = (16, 256, 4096)
SHARDS_EACH = (1, 4, 16, 64)


@dataclasses.dataclass(frozen=True)
class Bake:
    """A bake, the machines and what is between them. Times are seconds, sizes bytes."""

    work: float = 360_000.0
    """What one machine computes, W, without what it takes to begin."""
    setup: float = 10.0
    """Scene and tree, once a machine, T₀."""
    scene: float = 5e8
    """What each machine is sent."""
    result: float = 5.2e9
    """What comes back of all shards: matrices of order 6 in float32 at a million receivers."""
    link: float = 1.25e9
    """Bytes a second of one machine's link, here 10 Gbit/s."""
    shard: float = 0.003
    """What the client spends on each shard beside its bytes: 2.4 ms of a processor, in a bake of a thousand tiny shards."""
    spread: float = 0.3
    """Standard deviation of the logarithm of what shards cost."""
    slow: bool = False
    """Whether one machine has a third of the speed of the others."""
    dies: bool = False
    """Whether one machine dies after half of W / N."""
    noticed: float = 0.0
    """Time until a death is noticed; a process that ends closes its connection at once."""


SLOWNESS = 3.0


def costs(bake: Bake, count: int, seed: int) -> list[float]:
    """What each of `count` shards costs, log-normal, W in all."""
    chance = random.Random(seed)
    drawn = [chance.lognormvariate(0.0, bake.spread) for _ in range(count)]
    scale = bake.work / math.fsum(drawn)
    return [scale * cost for cost in drawn]


def sending(bake: Bake, machines: int) -> float:
    """Until all machines have the scene: to the scheduler, to the first machine, and in rounds in which each that has it sends it to two more."""
    transfers, having = 2, 1
    while having < machines:
        transfers, having = transfers + 2, 3 * having
    return transfers * bake.scene / bake.link


def done_times(bake: Bake, machines: int, shards: list[float]) -> list[float]:
    """When each shard is done, by list scheduling: the machine that is free first takes the next."""
    begin = sending(bake, machines) + bake.setup
    # The last machine is the slow one, and the last but one the one that dies.
    slow = machines - 1 if bake.slow else None
    dying = machines - 2 if bake.dies else None
    death = begin + 0.5 * bake.work / machines
    free = [(begin, machine) for machine in range(machines)]
    waiting, lost = iter(shards), []
    done = []
    while free:
        now, machine = heapq.heappop(free)
        if machine == dying and now >= death:
            continue
        if lost and lost[0][0] <= now:
            cost = heapq.heappop(lost)[1]
        elif (following := next(waiting, None)) is not None:
            cost = following
        elif lost:
            # Nothing else is left: it waits until the death is noticed.
            noticed, cost = heapq.heappop(lost)
            now = max(now, noticed)
        else:
            continue
        end = now + cost * (SLOWNESS if machine == slow else 1.0)
        if machine == dying and end > death:
            heapq.heappush(lost, (death + bake.noticed, cost))
            continue
        done.append(end)
        heapq.heappush(free, (end, machine))
    return done


def elapsed(bake: Bake, machines: int, shards: list[float]) -> float:
    """Until the client has written the last shard; it takes one after the other."""
    each = bake.shard + bake.result / bake.link / len(shards)
    now = 0.0
    for end in sorted(done_times(bake, machines, shards)):
        now = max(now, end) + each
    return now


def efficiency(bake: Bake, machines: int, each: int) -> float:
    """W / (N T) with `each` shards a machine, the median of some seeds."""
    runs = (elapsed(bake, machines, costs(bake, each * machines, seed)) for seed in range(SEEDS))
    return statistics.median(bake.work / (machines * time) for time in runs)


CASES = {
    "alike": {"spread": 0.0},
    "uneven": {},
    "one slow": {"slow": True},
    "one dies": {"dies": True},
    "slow, dies": {"slow": True, "dies": True},
}


def main() -> None:
    parser = argparse.ArgumentParser(description="Efficiency of a bake on many machines, by simulation.")
    for field in dataclasses.fields(Bake):
        if isinstance(field.default, float):
            parser.add_argument(f"--{field.name}", type=float, default=field.default, help="[default: %(default)s]")
    bake = Bake(**vars(parser.parse_args()))
    print("| machines | shards each | " + " | ".join(CASES) + " |")
    print("|---|---|" + "---|" * len(CASES))
    for machines in MACHINES:
        for each in SHARDS_EACH:
            found = [efficiency(dataclasses.replace(bake, **case), machines, each) for case in CASES.values()]
            print(f"| {machines} | {each} | " + " | ".join(f"{value:.2f}" for value in found) + " |")


if __name__ == "__main__":
    main()
