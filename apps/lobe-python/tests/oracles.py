"""What the tests compare with: scipy's spherical harmonics, and quadrature by numpy."""

import numpy as np
from scipy.special import sph_harm_y


def basis(order, d):
    """Real orthonormal harmonics towards unit vectors (m, 3): (m, n²). From the complex ones of scipy, which have the phase (-1)^m as ours do."""
    theta, phi = np.arccos(np.clip(d[:, 2], -1, 1)), np.arctan2(d[:, 1], d[:, 0])
    columns = []
    for l in range(order):
        for m in range(-l, l + 1):
            y = sph_harm_y(l, abs(m), theta, phi)
            columns.append(y.real if m == 0 else np.sqrt(2) * (y.real if m > 0 else y.imag))
    return np.stack(columns, axis=1)


def directions(count, seed=0):
    """Random unit vectors, and the axes."""
    v = np.random.default_rng(seed).normal(size=(count, 3))
    v /= np.linalg.norm(v, axis=1, keepdims=True)
    return np.concatenate([v, np.eye(3), -np.eye(3)])


def quadrature(degree):
    """Unit vectors and weights that integrate polynomials of a degree exactly: Gauss-Legendre by equal angles."""
    z, w = np.polynomial.legendre.leggauss(degree // 2 + 1)
    phi = 2 * np.pi * np.arange(degree + 1) / (degree + 1)
    r = np.sqrt(1 - z**2)
    d = np.stack([np.outer(r, np.cos(phi)), np.outer(r, np.sin(phi)), np.outer(z, np.ones_like(phi))], axis=-1)
    return d.reshape(-1, 3), np.repeat(w * 2 * np.pi / len(phi), len(phi))


def rotation(seed):
    """A random rotation matrix."""
    q, r = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    q = q * np.sign(np.diag(r))
    return q if np.linalg.det(q) > 0 else -q
