"""High orders beside ducc0 and SHTns, one thread, in one run; prints a table of milliseconds and ratios.

    pip install numpy ducc0 shtns          # shtns is compiled: it needs FFTW (apt install libfftw3-dev)
    cargo build --release -p lobe-bench
    python peers/speed/high_orders.py target/release/lobe-bench

Lobe's figures are those of `lobe-bench`, which projects and reconstructs 2048 x 1024 texels of three channels in f32 and rotates a
scalar function in f64. ducc0 does the same in f32 and f64, a channel at a time, on the same grid (F1, middles of equal parts):
its adjoint synthesis sums samples, which is what projection costs without the integrals over texels. The least of many runs each.
"""

import json
import os
import subprocess
import sys
import time

os.environ["OMP_NUM_THREADS"] = "1"
import ducc0
import numpy as np

try:
    import shtns
except ImportError:
    shtns = None

ORDERS = (64, 128, 256)
WIDTH, HEIGHT = 2048, 1024
ANGLES = (0.3, 1.1, -2.0)


def least(work, seconds=2.0):
    """The least time of a call, in milliseconds."""
    best, end = float("inf"), time.perf_counter() + seconds
    while time.perf_counter() < end:
        start = time.perf_counter()
        work()
        best = min(best, time.perf_counter() - start)
    return 1e3 * best


def of_lobe(program):
    """Milliseconds of `lobe-bench` by job and order."""
    words = ["project", "reconstruct", "rotation-one-f64"]
    printed = subprocess.run([program, *words, "--seconds", "2", "--json"], check=True, capture_output=True, text=True)
    texels = WIDTH * HEIGHT
    return {
        (row["job"], row["order"]): row["nanoseconds"] * 1e-6 * (texels if row["item"] == "texel" else 1)
        for row in json.loads(printed.stdout)["jobs"]
    }


def of_ducc0(order):
    last, random = order - 1, np.random.default_rng(1)
    places = order * (order + 1) // 2
    alm = random.standard_normal((3, 1, places)) + 1j * random.standard_normal((3, 1, places))
    alm[..., :order] = alm[..., :order].real
    maps = random.standard_normal((3, 1, HEIGHT, WIDTH))
    common = {"spin": 0, "lmax": last, "geometry": "F1", "nthreads": 1}
    found = {}
    for bits, real, complex_ in ((32, np.float32, np.complex64), (64, np.float64, np.complex128)):
        m, a = maps.astype(real), alm.astype(complex_)
        found["project", bits] = least(lambda: [ducc0.sht.adjoint_synthesis_2d(map=c, **common) for c in m])
        found["reconstruct", bits] = least(
            lambda: [ducc0.sht.synthesis_2d(alm=c, ntheta=HEIGHT, nphi=WIDTH, **common) for c in a]
        )
    found["rotation-one-f64", 64] = least(lambda: ducc0.sht.rotate_alm(alm[0, 0], last, *ANGLES, nthreads=1))
    return found


def of_shtns(order):
    if shtns is None:
        return None
    coefficients = shtns.sht(order - 1, order - 1).spec_array()
    coefficients[:] = np.random.default_rng(1).standard_normal(len(coefficients))
    rotation = shtns.rotation(order - 1)
    rotation.set_angles_ZYZ(*ANGLES)
    return least(lambda: rotation.apply_real(coefficients))


def main():
    lobe = of_lobe(sys.argv[1])
    print(f"{'job':<16} {'order':>5} {'lobe':>8} {'ducc0 f32':>16} {'ducc0 f64':>16} {'SHTns':>16}   ms, lobe / peer")
    for order in ORDERS:
        peer = of_ducc0(order)
        for job in ("project", "reconstruct", "rotation-one-f64"):
            own = lobe[job, order]
            others = [peer.get((job, 32)), peer.get((job, 64)), of_shtns(order) if job == "rotation-one-f64" else None]
            cells = ["" if other is None else f"{other:.3g} ({own / other:.2f})" for other in others]
            print(f"{job:<16} {order:>5} {own:>8.3g} {cells[0]:>16} {cells[1]:>16} {cells[2]:>16}")


if __name__ == "__main__":
    main()
