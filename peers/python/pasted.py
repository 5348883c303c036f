"""Spherical harmonics as programs carry them along: written once more, by what every description of them says."""

import numpy as np
from scipy.special import sph_harm_y


def nine(d):
    """The first nine real harmonics towards unit vectors (m, 3), term by term: (m, 9)."""
    x, y, z = d.T
    a, b = np.sqrt(3 / (4 * np.pi)), 0.5 * np.sqrt(15 / np.pi)
    return np.stack(
        [
            np.full(len(d), 0.5 / np.sqrt(np.pi)),
            -a * y,
            a * z,
            -a * x,
            b * x * y,
            -b * y * z,
            0.25 * np.sqrt(5 / np.pi) * (3 * z * z - 1),
            -b * x * z,
            0.5 * b * (x * x - y * y),
        ],
        axis=1,
    )


def by_scipy(order, d):
    """The real harmonics from scipy's complex ones, one after the other: (m, n²)."""
    theta, phi = np.arccos(np.clip(d[:, 2], -1, 1)), np.arctan2(d[:, 1], d[:, 0])
    out = np.empty((len(d), order * order))
    for l in range(order):
        for m in range(-l, l + 1):
            y = sph_harm_y(l, abs(m), theta, phi)
            part = y.real if m >= 0 else y.imag
            out[:, l * l + l + m] = part if m == 0 else np.sqrt(2) * part
    return out


def project(picture):
    """A lat-long picture (h, w) as nine numbers: each texel by the direction of its middle and by sin θ."""
    height, width = picture.shape
    theta = (np.arange(height) + 0.5) * np.pi / height
    phi = np.pi - (np.arange(width) + 0.5) * 2 * np.pi / width
    t, p = np.meshgrid(theta, phi, indexing="ij")
    d = np.stack([np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)], axis=-1).reshape(-1, 3)
    weight = np.sin(t) * (np.pi / height) * (2 * np.pi / width)
    return nine(d).T @ (picture * weight).ravel()
