"""The package `lobe` beside Rust: the same jobs on batches of 100 000 and a million, and the ratios of their times.

    cargo build --release -p lobe-python --example rust_jobs
    pip install ./apps/lobe-python
    python peers/python/rust.py target/release/examples/rust_jobs

Both in one profile of cargo, and one after the other, round after round; of each job the least time counts. A ratio above the bound ends the program
with 1.
"""

import argparse
import subprocess
import sys

import numpy as np

import lobe
from timing import seconds

ORDER = 4

BOUND = 1.1
"""What Python may take of Rust's time: checks of shapes, and the array of the result."""


def turn():
    z = lambda a: np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1]])  # noqa: E731
    y = np.array([[np.cos(1.1), 0, np.sin(1.1)], [0, 1, 0], [-np.sin(1.1), 0, np.cos(1.1)]])
    return z(0.3) @ y @ z(-2.0)


def jobs(batch, dtype):
    """Names of jobs and what does them, on numbers between -1 and 1."""
    random = np.random.default_rng(0)
    a, b = (random.uniform(-1, 1, (batch, ORDER**2)).astype(dtype) for _ in range(2))
    d = random.uniform(-1, 1, (batch, 3)).astype(dtype)
    f, g, one, r = lobe.Sh(a), lobe.Sh(b), lobe.Sh(a[0]), turn()
    yield "eval", lambda: one.eval(d)
    yield "rotate", lambda: f.rotate(r)
    yield "product", lambda: f.product(g)
    yield "convolve", lambda: f.convolve("cosine")
    if dtype == np.float32:
        height = int(np.sqrt(batch / 2))
        texels = random.uniform(-1, 1, (height, 2 * height, 3)).astype(dtype)
        yield "project", lambda: lobe.project(texels, ORDER)


def python_times(times):
    for batch in [100_000, 1_000_000]:
        for name, dtype in [("f32", np.float32), ("f64", np.float64)]:
            for job, work in jobs(batch, dtype):
                key = (job, name, batch)
                times[key] = min(times.get(key, np.inf), seconds(work, 1.0))


def rust_times(program, times):
    told = subprocess.run([program], check=True, capture_output=True, text=True).stdout
    for job, name, batch, took in (line.split() for line in told.splitlines()):
        key = (job, name, int(batch))
        times[key] = min(times.get(key, np.inf), float(took))


def main():
    parser = argparse.ArgumentParser(description="Time the package beside the same jobs in Rust.")
    parser.add_argument("program", help="the built example rust_jobs")
    parser.add_argument("--rounds", type=int, default=3)
    given = parser.parse_args()
    python, rust = {}, {}
    for _ in range(given.rounds):
        python_times(python)
        rust_times(given.program, rust)
    print("| job | numbers | batch | Python ms | Rust ms | ratio |")
    print("|---|---|---|---|---|---|")
    slow = []
    for key, took in python.items():
        ratio = took / rust[key]
        print(f"| {key[0]} | {key[1]} | {key[2]} | {1e3 * took:.2f} | {1e3 * rust[key]:.2f} | {ratio:.2f} |")
        if ratio > BOUND:
            slow.append(f"{' '.join(map(str, key))}: {ratio:.2f}")
    for text in slow:
        print(f"error: above {BOUND} of Rust: {text}", file=sys.stderr)
    return int(bool(slow))


if __name__ == "__main__":
    sys.exit(main())
