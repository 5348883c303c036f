"""The package `lobe` beside pyshtools, healpy, sphericart and the code that programs paste: the same jobs, their times in one run, and how far the results are apart.

    pip install ./apps/lobe-python pyshtools healpy scipy sphericart
    python peers/python/compare.py

Every result of a peer is first brought to Lobe's convention and compared; a difference above the bound of its row ends the program with 1.
"""

import sys

import healpy
import numpy as np
import pyshtools
import sphericart

import lobe
import pasted
from timing import seconds


def directions(count):
    v = np.random.default_rng(0).normal(size=(count, 3))
    return v / np.linalg.norm(v, axis=1, keepdims=True)


def of_pyshtools(c):
    """Coefficients as pyshtools has them, orthonormal with the phase (-1)^m: [cosine or sine, l, m]."""
    order = int(np.sqrt(len(c)))
    out = np.zeros((2, order, order))
    for l in range(order):
        for m in range(-l, l + 1):
            out[int(m < 0), l, abs(m)] = c[l * l + l + m]
    return out


def from_pyshtools(cilm):
    order = cilm.shape[1]
    return np.array([cilm[int(m < 0), l, abs(m)] for l in range(order) for m in range(-l, l + 1)])


def of_healpy(c):
    """The complex coefficients with m >= 0 of a real function, as healpy has them."""
    order = int(np.sqrt(len(c)))
    alm = np.zeros(healpy.Alm.getsize(order - 1), complex)
    for l in range(order):
        for m in range(l + 1):
            k = healpy.Alm.getidx(order - 1, l, m)
            alm[k] = c[l * l + l] if m == 0 else (c[l * l + l + m] - 1j * c[l * l + l - m]) / np.sqrt(2)
    return alm


def from_healpy(alm, order):
    c = np.zeros(order * order)
    for l in range(order):
        for m in range(l + 1):
            a = alm[healpy.Alm.getidx(order - 1, l, m)]
            if m == 0:
                c[l * l + l] = a.real
            else:
                c[l * l + l + m], c[l * l + l - m] = np.sqrt(2) * a.real, -np.sqrt(2) * a.imag
    return c


FAULTS = []

TURNS, TURN = 5, 0.2
"""How often each side of a row has its turn, and for how many seconds at least."""


def check(job, found, expected, bound):
    """How far ours is from what it should be, where the peer's numbers are others."""
    off = float(np.abs(found - expected).max() / np.abs(expected).max())
    if not off <= bound:
        FAULTS.append(f"{job}, lobe: {off} off")


def row(job, ours, peer, theirs, found, expected, bound):
    off = float(np.abs(found - expected).max() / np.abs(expected).max())
    # In turns, so that whatever else the machine does falls on both.
    times = [(seconds(ours, TURN), seconds(theirs, TURN)) for _ in range(TURNS)]
    a, b = (min(column) for column in zip(*times, strict=True))
    print(f"{job:<68} {peer:<11} {1e3 * a:>9.3f} {1e3 * b:>9.3f} {a / b:>7.3f} {off:>9.1e}")
    if not off <= bound:
        FAULTS.append(f"{job}, {peer}: {off} apart")


def evaluation():
    for order, count, functions in [(4, 100_000, 1), (10, 100_000, 1), (10, 10_000, 100), (16, 100_000, 1), (64, 10_000, 1)]:
        # Of 64 bands sphericart has numbers in double precision only.
        for dtype, bound in [(np.float64, 1e-12), (np.float32, 2e-5)][: 1 if order > 32 else 2]:
            d = directions(count).astype(dtype)
            c = np.random.default_rng(1).normal(size=(functions, order**2)).astype(dtype)
            f, peer = lobe.Sh(c), sphericart.SphericalHarmonics(order - 1)
            # sphericart has no phase (-1)^m.
            phase = np.array([(-1.0) ** m for l in range(order) for m in range(-l, l + 1)], dtype)
            theirs = lambda: (c * phase) @ peer.compute(d).T  # noqa: E731
            name = f"values of {functions} functions, order {order}, {count} directions, {dtype.__name__}"
            row(name, lambda: f.eval(d), "sphericart", theirs, theirs(), f.eval(d), bound)


def evaluation_pasted():
    d = directions(100_000)
    for order, basis, name in [(3, pasted.nine, "nine terms"), (10, lambda d: pasted.by_scipy(10, d), "scipy, loop")]:
        c = np.random.default_rng(5).normal(size=order**2)
        f = lobe.Sh(c)
        job = f"values of 1 functions, order {order}, {len(d)} directions, float64"
        row(job, lambda: f.eval(d), name, lambda: basis(d) @ c, basis(d) @ c, f.eval(d), 1e-12)


def rotation():
    for order in [4, 10, 32]:
        c = np.random.default_rng(2).normal(size=order**2)
        alpha, beta, gamma = 0.3, 1.1, -0.7
        z = lambda a: np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1]])  # noqa: E731
        y = np.array([[np.cos(beta), 0, np.sin(beta)], [0, 1, 0], [-np.sin(beta), 0, np.cos(beta)]])
        r = z(alpha) @ y @ z(gamma)
        expected = lobe.Sh(c).rotate(r).coefficients
        ours = lambda: lobe.Sh(c).rotate(r)  # noqa: E731
        coefficients = pyshtools.SHCoeffs.from_array(of_pyshtools(c), normalization="ortho", csphase=-1)
        # The body turns here, as with us.
        turned = lambda: coefficients.rotate(alpha, beta, gamma, degrees=False, convention="y", body=True)  # noqa: E731
        row(f"rotation of one function, order {order}", ours, "pyshtools", turned, from_pyshtools(turned().coeffs), expected, 1e-9)
        alm = of_healpy(c)

        def healpy_turned():
            a = alm.copy()
            healpy.rotate_alm(a, gamma, beta, alpha)
            return a

        row(f"rotation of one function, order {order}", ours, "healpy", healpy_turned, from_healpy(healpy_turned(), order), expected, 1e-9)
    order, count = 4, 10_000
    c = np.random.default_rng(3).normal(size=(count, order**2))
    alms = np.stack([of_healpy(row) for row in c])
    r = z(alpha) @ y @ z(gamma)

    def healpy_many():
        for a in alms.copy():
            healpy.rotate_alm(a, gamma, beta, alpha)

    last = alms[-1].copy()
    healpy.rotate_alm(last, gamma, beta, alpha)
    ours = lambda: lobe.Sh(c).rotate(r)  # noqa: E731
    row(f"rotation of {count} functions, order {order}", ours, "healpy", healpy_many, from_healpy(last, order), ours().coefficients[-1], 1e-9)


HEIGHT, PIXELS = 512, 640
"""Rows of our map beside a grid of pyshtools, which has as many, and beside healpy's 786 432 pixels, which are fewer than ours."""

SIDE = 256


def smooth(order):
    """A function whose bands get fainter, as those of pictures do."""
    l = np.repeat(np.arange(order), 2 * np.arange(order) + 1)
    return np.random.default_rng(4).normal(size=order**2) / (1 + l) ** 2


def poles(height):
    """Directions of a grid of pyshtools, whose first row is a pole, and whose first column is towards +x."""
    return directions_of(np.pi * np.arange(height) / height, np.pi * np.arange(2 * height) / height)


def middles(height):
    """Directions of the middles of our texels, +x in the middle and +y to the left."""
    return directions_of(np.pi * (np.arange(height) + 0.5) / height, np.pi - np.pi * (np.arange(2 * height) + 0.5) / height)


def directions_of(theta, phi):
    t, p = np.meshgrid(theta, phi, indexing="ij")
    return np.stack([np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)], axis=-1)


def pixels():
    return np.stack(healpy.pix2vec(SIDE, np.arange(healpy.nside2npix(SIDE))), axis=-1)


def projection(order):
    # A function of fewer bands than the grids hold, so that all are exact but for the texels of ours, which are averages.
    c = smooth(order)
    f = lobe.Sh(c)
    grid = f.eval(poles(HEIGHT))
    theirs = lambda: pyshtools.SHGrid.from_array(grid, grid="DH").expand(normalization="ortho", csphase=-1, lmax_calc=order - 1)  # noqa: E731
    picture = f.texels(2 * HEIGHT, HEIGHT)
    ours = lambda: lobe.project(picture, order)  # noqa: E731
    row(f"projection of {2 * HEIGHT} x {HEIGHT}, order {order}", ours, "pyshtools", theirs, from_pyshtools(theirs().coeffs), c, 1e-9)
    # The average of a texel takes a little from the highest bands.
    check(f"projection, order {order}", ours().coefficients, c, 4e-6 * order**2)
    sphere = f.eval(pixels())
    theirs = lambda: healpy.map2alm(sphere, lmax=order - 1, iter=3)  # noqa: E731
    picture = f.texels(2 * PIXELS, PIXELS)
    row(f"projection of {2 * PIXELS} x {PIXELS}, order {order}", ours, "healpy", theirs, from_healpy(theirs(), order), c, 1e-6)


def synthesis(order):
    c = smooth(order)
    f = lobe.Sh(c)
    coefficients = pyshtools.SHCoeffs.from_array(of_pyshtools(c), normalization="ortho", csphase=-1)
    ours = lambda: f.texels(2 * HEIGHT, HEIGHT)  # noqa: E731
    theirs = lambda: coefficients.expand(grid="DH2", lmax=HEIGHT // 2 - 1, extend=False)  # noqa: E731
    name = f"picture of {2 * HEIGHT} x {HEIGHT}, order {order}"
    row(name, ours, "pyshtools", theirs, theirs().data, f.eval(poles(HEIGHT)), 1e-9)
    check(name, ours(), f.eval(middles(HEIGHT)), 1e-12)
    alm = of_healpy(c)
    ours = lambda: f.texels(2 * PIXELS, PIXELS)  # noqa: E731
    theirs = lambda: healpy.alm2map(alm, SIDE, lmax=order - 1)  # noqa: E731
    row(f"picture of {2 * PIXELS} x {PIXELS}, order {order}", ours, "healpy", theirs, theirs(), f.eval(pixels()), 1e-9)


def product(order):
    a, b = smooth(order), smooth(order)[::-1].copy()
    f, g = lobe.Sh(a), lobe.Sh(b)
    x, y = of_pyshtools(a), of_pyshtools(b)
    ours = lambda: f.product(g, order=2 * order - 1)  # noqa: E731
    theirs = lambda: pyshtools.expand.SHMultiply(x, y, norm=4, csphase=-1)  # noqa: E731
    row(f"exact product of a pair, order {order}", ours, "pyshtools", theirs, from_pyshtools(theirs()), ours().coefficients, 1e-9)


def projection_pasted():
    height = 512
    picture = lobe.EnvMap.bundled("sunset").convert("lat-long", 2 * height, height).texels[..., 1].astype(np.float64)
    ours = lambda: lobe.project(picture, 3)  # noqa: E731
    theirs = lambda: pasted.project(picture)  # noqa: E731
    job = f"projection of {2 * height} x {height}, order 3, a sunset"
    # The middles of texels against their exact integrals: the sun fills a few.
    row(job, ours, "nine terms", theirs, theirs(), ours().coefficients, 1e-4)


def main():
    print(f"{'job':<68} {'peer':<11} {'lobe ms':>9} {'peer ms':>9} {'ratio':>7} {'apart':>9}")
    evaluation()
    evaluation_pasted()
    rotation()
    for order in [16, 64]:
        projection(order)
        synthesis(order)
    for order in [4, 16, 64]:
        product(order)
    projection_pasted()
    for fault in FAULTS:
        print(f"error: {fault}", file=sys.stderr)
    return int(bool(FAULTS))


if __name__ == "__main__":
    sys.exit(main())
