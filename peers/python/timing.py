"""Times of jobs."""

import time


def seconds(work, least=0.5):
    """The least time of several runs."""
    work()
    best, until = float("inf"), time.perf_counter() + least
    while time.perf_counter() < until:
        begun = time.perf_counter()
        work()
        best = min(best, time.perf_counter() - begun)
    return best
