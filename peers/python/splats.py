"""A file of Gaussian splats of order 3 turned in partitions on Dask: time, and what each worker needs of memory.

    pip install ./apps/lobe-python distributed
    python peers/python/splats.py --splats 10000000 --folder /somewhere/with/5/GB

Writes a .ply file as trainers of splats do (62 numbers of 4 bytes each splat), and turns it into another: positions, normals, rotations and the
coefficients of each color. A task is a range of rows, of which a worker has some at a time. Rows from everywhere are then turned in double precision
and compared; a difference ends the program with 1. Both files are removed.
"""

import argparse
import functools
import os
import resource
import sys
import tempfile
import time

import numpy as np

NAMES = [
    *"xyz", "nx", "ny", "nz", *(f"f_dc_{k}" for k in range(3)), *(f"f_rest_{k}" for k in range(45)),
    "opacity", *(f"scale_{k}" for k in range(3)), *(f"rot_{k}" for k in range(4)),
]  # fmt: skip
WIDTH = len(NAMES)

ROWS_TOGETHER = 1 << 17
"""Rows that a worker has at a time: 33 MB."""

CHECKED = 1000


def header(count):
    lines = ["ply", "format binary_little_endian 1.0", f"element vertex {count}", *(f"property float {name}" for name in NAMES), "end_header", ""]
    return "\n".join(lines).encode()


def write(path, count):
    random = np.random.default_rng(0)
    with open(path, "wb") as file:
        file.write(header(count))
        for first in range(0, count, ROWS_TOGETHER):
            rows = random.standard_normal((min(ROWS_TOGETHER, count - first), WIDTH), dtype=np.float32)
            rows[:, -4:] /= np.linalg.norm(rows[:, -4:], axis=1, keepdims=True)
            rows.tofile(file)


def read(path, start, first, count):
    """Rows from `first` on, of a file whose numbers begin at `start`."""
    return np.fromfile(path, "<f4", count * WIDTH, offset=start + first * WIDTH * 4).reshape(count, WIDTH)


def quaternion_of(r):
    """The quaternion (w, x, y, z) of a rotation by less than half a turn."""
    w = 0.5 * np.sqrt(1.0 + np.trace(r))
    return np.array([w, *(np.array([r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]]) / (4 * w))])


def turned(rows, r):
    """Splats turned by a rotation."""
    import lobe

    out = rows.copy()
    out[:, 0:3], out[:, 3:6] = rows[:, 0:3] @ r.T.astype(rows.dtype), rows[:, 3:6] @ r.T.astype(rows.dtype)
    # In the file the mean of each color is first, and then fifteen coefficients of red, of green and of blue.
    sh = np.empty((len(rows), 3, 16), rows.dtype)
    sh[:, :, 0], sh[:, :, 1:] = rows[:, 6:9], rows[:, 9:54].reshape(-1, 3, 15)
    out[:, 9:54] = lobe.Sh(sh).rotate(r).coefficients[:, :, 1:].reshape(-1, 45)
    w, v = quaternion_of(r)[0], quaternion_of(r)[1:]
    a, b = rows[:, -4:-3], rows[:, -3:]
    out[:, -4:-3], out[:, -3:] = w * a - b @ v[:, None], w * b + a * v + np.cross(v, b)
    return out


def turn_range(paths, start, r, rows):
    """The task: some rows of a file, turned, into the same place of another."""
    first, end = rows
    with open(paths[1], "r+b") as file:
        file.seek(start + first * WIDTH * 4)
        for first in range(first, end, ROWS_TOGETHER):
            turned(read(paths[0], start, first, min(ROWS_TOGETHER, end - first)), r).tofile(file)


def turn_file(paths, count, r, client, tasks):
    start = len(header(count))
    with open(paths[1], "wb") as file:
        file.write(header(count))
        file.truncate(start + count * WIDTH * 4)
    bounds = [count * k // tasks for k in range(tasks + 1)]
    work = functools.partial(turn_range, paths, start, r)
    client.gather(client.map(work, list(zip(bounds[:-1], bounds[1:])), pure=False))
    return start


def apart(paths, start, count, r):
    """How far rows of the file are from those that are turned in double precision."""
    numbers = np.linspace(0, count - 1, min(CHECKED, count)).astype(int)
    before, after = (np.concatenate([read(path, start, k, 1) for k in numbers]) for path in paths)
    return float(np.abs(turned(before.astype(np.float64), r) - after).max())


def peak():
    """The most memory that this process has had, in MB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3


def main():
    from distributed import Client, LocalCluster

    parser = argparse.ArgumentParser(description="Turn a file of splats in partitions on Dask.")
    parser.add_argument("--splats", type=int, default=1_000_000)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--tasks", type=int, default=32)
    parser.add_argument("--folder", help="where the files are written [default: that of temporary files]")
    given = parser.parse_args()
    a, b = 0.9, 0.6
    r = np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1]]) @ np.array([[1, 0, 0], [0, np.cos(b), -np.sin(b)], [0, np.sin(b), np.cos(b)]])
    os.environ["RAYON_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"
    with (
        tempfile.TemporaryDirectory(dir=given.folder) as folder,
        LocalCluster(n_workers=given.workers, threads_per_worker=1, host="127.0.0.1", dashboard_address=None) as cluster,
        Client(cluster, set_as_default=False) as client,
    ):
        paths = [os.path.join(folder, name) for name in ("splats.ply", "turned.ply")]
        write(paths[0], given.splats)
        client.run(lambda: __import__("lobe").__version__)
        before = client.run(peak)
        used = sum(client.run(time.process_time).values())
        begun = time.perf_counter()
        start = turn_file(paths, given.splats, r, client, given.tasks)
        took = time.perf_counter() - begun
        used = sum(client.run(time.process_time).values()) - used
        size = os.path.getsize(paths[0]) / 1e6
        print(f"{given.splats} splats, {size:.0f} MB: {took:.1f} s by {given.workers} processes, {used:.1f} s of processors, {size / took:.0f} MB/s")
        for worker, most in client.run(peak).items():
            print(f"worker {worker}: {before[worker]:.0f} MB before, {most:.0f} MB at most")
        off = apart(paths, start, given.splats, r)
    print(f"{min(CHECKED, given.splats)} rows are apart from double precision by {off:.1e} at most")
    if not off < 1e-5:
        print("error: the splats are not those that were to be", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
