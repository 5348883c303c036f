"""Projection of OpenEXR files beside OpenEXR's own reader, in turns; prints a table of seconds, ratios and memory.

    pip install numpy OpenEXR
    cargo build --release
    python peers/speed/reading.py target/release/lobe [WIDTH]

Lobe reads a lat-long map and projects it onto order 3; OpenEXR, in C++, only reads it, on its one thread. Both are programs of their
own: of the second the time that Python takes to start and import the module is taken away. The least of some turns each.
"""

import os
import subprocess
import sys
import tempfile
import time

TURNS = 9
COMPRESSIONS = {"ZIP": "ZIP_COMPRESSION", "PIZ": "PIZ_COMPRESSION", "none": "NO_COMPRESSION"}
WRITE = "--write"
START = [sys.executable, "-c", "import OpenEXR"]
READ = [sys.executable, "-c", "import OpenEXR, sys; OpenEXR.File(sys.argv[1])"]


def run(command, threads=None):
    """The seconds and the MiB that a program takes."""
    environment = os.environ | ({"RAYON_NUM_THREADS": str(threads)} if threads else {})
    begin = time.perf_counter()
    process = subprocess.Popen(command, env=environment, stderr=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    if status != 0:
        sys.exit(f"{' '.join(command)} failed")
    return time.perf_counter() - begin, usage.ru_maxrss / 1024


def write(path, compression, kind, width):
    """A process of its own writes the map: the memory of a program counts from that of the one which starts it."""
    import OpenEXR

    header = {"compression": getattr(OpenEXR, compression), "type": OpenEXR.scanlineimage}
    OpenEXR.File(header, {"RGB": sky(int(width)).astype(kind)}).write(path)


def sky(width):
    """A map with detail at all scales and grain, as photographs have."""
    import numpy as np

    height, random = width // 2, np.random.default_rng(1)
    y, x = np.mgrid[0:height, 0:width].astype(np.float32) / height
    waves = sum(np.sin(2.0**k * (3 * x + 2 * y) + k) / 2.0**k for k in range(9))
    light = np.exp(waves)[..., None] * np.array([1.0, 0.8, 0.6], np.float32)
    return (light * random.normal(1, 0.02, light.shape)).astype(np.float32)


def main():
    lobe, width = sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 4096
    print(f"{width} x {width // 2}, s and MiB: the least of {TURNS} turns")
    print("| file | Lobe | one thread | OpenEXR | ratio | one thread | MiB | OpenEXR |")
    print("|---|---|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        path, out = os.path.join(folder, "m.exr"), os.path.join(folder, "a.sh.json")
        project = [lobe, "project", path, "-o", out]
        for name, compression in COMPRESSIONS.items():
            for kind in ("float16", "float32"):
                subprocess.run([sys.executable, __file__, WRITE, path, compression, kind, str(width)], check=True)
                turns = [(run(project), run(project, 1), run([*READ, path]), run(START)) for _ in range(TURNS)]
                (all_, memory), (one, _), (read, peer_memory), (start, _) = (min(column) for column in zip(*turns))
                peer = read - start
                print(
                    f"| {name}, {kind} | {all_:.3f} | {one:.3f} | {peer:.3f} | {all_ / peer:.2f} | {one / peer:.2f} "
                    f"| {memory:.0f} | {peer_memory:.0f} |"
                )


if __name__ == "__main__":
    write(*sys.argv[2:]) if sys.argv[1] == WRITE else main()
