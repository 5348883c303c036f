"""One peer in a process of its own, so that its threads and its faults are its own.

    python worker.py NAME

First prints a line of JSON with the jobs, and the version or the reason why the peer is absent. Then, for each line of JSON
[job, order, seconds] on stdin, prints the nanoseconds for an item and how far its numbers are from those of `reference`.
"""

import json
import sys
import time

import peers
import reference

# A sample takes this long at least, as in `lobe-bench`.
SAMPLE_NS = 1_000_000
LEAST_SAMPLES = 3


def nanoseconds(work, seconds):
    """The least of many samples: everything that disturbs makes it slower."""
    work()
    begun = time.perf_counter_ns()
    work()
    repeats = max(1, SAMPLE_NS // max(1, time.perf_counter_ns() - begun))
    least, samples, until = float("inf"), 0, time.perf_counter_ns() + seconds * 1e9
    while samples < LEAST_SAMPLES or time.perf_counter_ns() < until:
        begun = time.perf_counter_ns()
        for _ in range(repeats):
            work()
        least = min(least, (time.perf_counter_ns() - begun) / repeats)
        samples += 1
    return least


def measure(peer, job, order, seconds):
    if hasattr(peer, "measure"):
        return peer.measure(job, order, seconds)
    prepared = getattr(peer, job.replace("-", "_"))(order)
    prepared.work()
    apart = reference.apart(prepared.found(), prepared.expected)
    call = nanoseconds(prepared.empty, seconds / 4) if prepared.empty else 0.0
    return (nanoseconds(prepared.work, seconds) - call) / prepared.items, apart


def say(answer):
    # Libraries print too: what is asked for has its own mark.
    print("\n@" + json.dumps(answer), flush=True)


def main():
    kind = next(kind for kind in peers.PEERS if kind.name == sys.argv[1])
    try:
        peer = kind()
    except Exception as error:
        say({"absent": " ".join(str(error).split()) or type(error).__name__, "jobs": kind.jobs})
        return
    say({"version": peer.version, "jobs": kind.jobs})
    for line in sys.stdin:
        job, order, seconds = json.loads(line)
        try:
            time_ns, apart = measure(peer, job, order, seconds)
            say({"nanoseconds": time_ns, "apart": apart, "allowed": getattr(kind, "allowed", {}).get(job)})
        except Exception as error:
            say({"error": f"{type(error).__name__}: {error}"})


if __name__ == "__main__":
    main()
