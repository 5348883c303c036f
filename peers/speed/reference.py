"""The numbers that every peer has to give, from the definitions of CONVENTIONS.md, in double precision.

Nothing here uses Lobe: `command_differs` shows that the command and these functions agree.
"""

import json
import math
import subprocess
from pathlib import Path

import numpy as np

# The rotation that all turn by: 0.8 about the axis of theta = 0.7, phi = 1.9, as in `lobe-bench`.
AXIS = np.array([math.sin(0.7) * math.cos(1.9), math.sin(0.7) * math.sin(1.9), math.cos(0.7)])
ANGLE = 0.8


def turn():
    """The matrix of the rotation, by Rodrigues' formula."""
    x, y, z = AXIS
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + math.sin(ANGLE) * cross + (1 - math.cos(ANGLE)) * cross @ cross


def euler_zyz(r):
    """alpha, beta, gamma of r = Rz(alpha) Ry(beta) Rz(gamma)."""
    return math.atan2(r[1, 2], r[0, 2]), math.acos(r[2, 2]), math.atan2(r[2, 1], -r[2, 0])


def directions(count):
    """Directions that cover the sphere evenly, on a spiral, one in a row."""
    k = np.arange(count)
    z, phi = 1 - (2 * k + 1) / count, math.pi * (3 - math.sqrt(5)) * k
    ring = np.sqrt(1 - z * z)
    return np.stack([ring * np.cos(phi), ring * np.sin(phi), z], axis=1)


def phases(order):
    """(-1)^m of each coefficient."""
    return np.array([(-1.0) ** m for l in range(order) for m in range(-l, l + 1)])


def basis(d, order):
    """y_i(d), a row for each direction: orthonormal, with the phase (-1)^m.

    The factors of sin^m(theta) are in the powers of x + iy, so that the poles are no exception.
    """
    x, y, z = d.T
    out = np.empty((len(d), order * order))
    power, diagonal = np.ones(len(d), complex), np.full(len(d), math.sqrt(1 / (4 * math.pi)))
    for m in range(order):
        if m > 0:
            power = power * (x + 1j * y)
            diagonal = -diagonal * math.sqrt((2 * m + 1) / (2 * m))
        before, now = np.zeros(len(d)), diagonal
        for l in range(m, order):
            i = l * (l + 1)
            out[:, i + m] = now * power.real * (math.sqrt(2) if m else 1)
            if m:
                out[:, i - m] = now * power.imag * math.sqrt(2)
            a = math.sqrt((2 * l + 1) * (2 * l + 3) / ((l + 1) ** 2 - m * m))
            b = math.sqrt((2 * l + 3) * (l * l - m * m) / ((2 * l - 1) * ((l + 1) ** 2 - m * m))) if l > m else 0.0
            before, now = now, a * z * now - b * before
    return out


def coefficients(order, count=1):
    """As many expansions, one in a row; small steps of an irrational angle, as in `lobe-bench`."""
    return np.sin(0.618 * np.arange(count * order * order)).reshape(count, -1)


def rotated(f, order):
    """The coefficients of g(s) = f(R^-1 s), from values in more directions than there are coefficients."""
    d = directions(8 * order * order)
    return np.linalg.lstsq(basis(d, order), basis(d @ turn(), order) @ f.T, rcond=None)[0].T


def product(f, g, order):
    """The first bands of the product, by Gauss' rule along z and even steps around."""
    z, w = np.polynomial.legendre.leggauss(2 * order)
    steps = 4 * order
    phi = 2 * math.pi * np.arange(steps) / steps
    ring = np.sqrt(1 - z * z)
    d = np.stack([np.outer(ring, np.cos(phi)), np.outer(ring, np.sin(phi)), np.outer(z, np.ones(steps))], axis=-1)
    y = basis(d.reshape(-1, 3), order)
    weights = np.repeat(w * 2 * math.pi / steps, steps)
    return ((y @ f.T) * (y @ g.T) * weights[:, None]).T @ y


def grid(theta, phi, f, order):
    """The values of f at each theta, a row, and phi."""
    t, p = np.meshgrid(theta, phi, indexing="ij")
    d = np.stack([np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)], axis=-1).reshape(-1, 3)
    rows = [basis(part, order) @ f for part in np.array_split(d, 64)]
    return np.concatenate(rows).reshape(t.shape)


def texels(width, height):
    """theta and phi of the middles of the texels of a lat-long picture: its left edge looks towards phi = pi, phi falls to the right."""
    return math.pi * (np.arange(height) + 0.5) / height, math.pi - 2 * math.pi * (np.arange(width) + 0.5) / width


def apart(found, expected):
    """The largest difference, in parts of the largest number."""
    return float(np.abs(np.asarray(found) - expected).max() / np.abs(expected).max())


def command_differs(lobe, folder):
    """How far the command and the functions above are apart, for each of what the peers do."""
    order, folder = 6, Path(folder)
    f, g = coefficients(order, 2)
    write_sh(folder / "f.sh.json", f)
    write_sh(folder / "g.sh.json", g)
    d = directions(20)
    towards = [part for row in d for part in ("--dir", ",".join(map(repr, row.tolist())))]
    values = json.loads(run(lobe, "sh", "eval", folder / "f.sh.json", *towards, "--json"))["values"]
    matrix = ",".join(map(repr, turn().flatten().tolist()))
    run(lobe, "sh", "rotate", folder / "f.sh.json", "--matrix", matrix, "-o", folder / "turned.sh.json")
    run(lobe, "sh", "product", folder / "f.sh.json", folder / "g.sh.json", "-o", folder / "product.sh.json")
    height = 512
    picture = grid(*texels(2 * height, height), f, order)
    write_pfm(folder / "picture.pfm", picture)
    run(lobe, "project", folder / "picture.pfm", "--order", str(order), "-o", folder / "projected.sh.json")
    return {
        "basis": apart(np.array(values)[:, 0], basis(d, order) @ f),
        "rotation": apart(read_sh(folder / "turned.sh.json"), rotated(f[None], order)[0]),
        "product": apart(read_sh(folder / "product.sh.json"), product(f[None], g[None], order)[0]),
        "project": apart(read_sh(folder / "projected.sh.json"), f),
    }


def run(lobe, *arguments):
    """What the command prints; its message, if it fails."""
    done = subprocess.run([lobe, *map(str, arguments)], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise SystemExit(f"error: {lobe} {arguments[0]} failed: {done.stderr.strip()}")
    return done.stdout


def write_sh(path, f):
    rows = [[float(c)] for c in f]
    order = math.isqrt(len(rows))
    path.write_text(json.dumps({"format": "lobe-sh", "version": 1, "order": order, "quantity": "function", "coefficients": rows}))


def read_sh(path):
    return np.array(json.loads(path.read_text())["coefficients"])[:, 0]


def write_pfm(path, picture):
    """A gray picture of three channels, little-endian, the lowest row first."""
    height, width = picture.shape
    texels = np.repeat(picture[::-1, :, None], 3, axis=2).astype("<f4")
    path.write_bytes(f"PF\n{width} {height}\n-1.0\n".encode() + texels.tobytes())
