#!/usr/bin/env python3
"""Coefficients that `lobe sh convert` writes, evaluated by the libraries themselves, and theirs, read back.

For each name of `lobe sh convert --help` a random function goes to the library, which evaluates it in 50 directions; `lobe sh eval` does the same.
Then the library analyzes the function, and its coefficients go to Lobe, which must find those that it began with. Ends with a failure if a row
disagrees, or if a control, numbers with a wrong sign, agrees.
"""

import json
import os
import subprocess
import sys
import tempfile
import warnings
from pathlib import Path

CACHE = Path(os.environ.get("LOBE_CONVENTIONS") or Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")) / "lobe-conventions")
PACKAGES = Path(__file__).with_name("requirements.txt").read_text().split()


def in_own_environment():
    """Runs this script again in an environment of its own, with what pip has of the packages."""
    python = CACHE / "bin" / "python"
    if not python.exists():
        subprocess.run([sys.executable, "-m", "venv", CACHE], check=True)
    done = CACHE / "tried.txt"
    if not done.exists() or done.read_text().split() != PACKAGES:
        install = [python, "-m", "pip", "install", "--quiet"]
        results = [subprocess.run([*install, package], check=False).returncode for package in PACKAGES]
        # What failed is tried again the next time.
        if not any(results):
            done.write_text("\n".join(PACKAGES))
    os.environ["LOBE_CONVENTIONS_INSIDE"] = "1"
    os.execv(python, [python, "-W", "ignore", *sys.argv])


if __name__ == "__main__" and "LOBE_CONVENTIONS_INSIDE" not in os.environ:
    in_own_environment()

import numpy as np  # noqa: E402

warnings.simplefilter("ignore")
RANDOM = np.random.default_rng(6)

# The largest differences that are allowed: rounding of sums of 400 numbers in double precision.
MOST = 1e-12


def angles(d):
    return np.arccos(np.clip(d[:, 2], -1, 1)), np.arctan2(d[:, 1], d[:, 0])


def directions(theta, phi):
    return np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], -1)


def quadrature(order):
    """Directions and weights that integrate products of two functions."""
    z, w = np.polynomial.legendre.leggauss(order)
    phi = 2 * np.pi * np.arange(2 * order) / (2 * order)
    z, phi = (a.ravel() for a in np.meshgrid(z, phi, indexing="ij"))
    return directions(np.arccos(z), phi), np.repeat(w, 2 * order) * np.pi / order


class Pyshtools:
    def __init__(self, normalization="4pi", csphase=1, kind="real"):
        import pyshtools

        self.module, self.kind = pyshtools, kind
        self.settings = {"normalization": normalization, "csphase": csphase}

    def eval(self, c, d):
        theta, phi = angles(d)
        f = self.module.SHCoeffs.from_array(c, **self.settings)
        return np.real(f.expand(lat=90 - np.degrees(theta), lon=np.degrees(phi)))

    def grid(self, order):
        n = 2 * order
        lat, lon = np.meshgrid(90 - 180 * np.arange(n) / n, 360 * np.arange(2 * n) / (2 * n), indexing="ij")
        return directions(np.radians(90 - lat).ravel(), np.radians(lon).ravel())

    def analyze(self, values, order):
        grid = values.reshape(2 * order, -1).astype(complex if self.kind == "complex" else float)
        return self.module.SHGrid.from_array(grid, grid="DH").expand(**self.settings).coeffs[:, :order, :order]


class Shtns:
    ROWS = 48

    def __init__(self, norm="sht_orthonormal", without_phase=False):
        import shtns

        self.module, self.norm = shtns, getattr(shtns, norm) + (shtns.SHT_NO_CS_PHASE if without_phase else 0)

    def made(self, order):
        transform = self.module.sht(order - 1, order - 1, 1, self.norm)
        transform.set_grid(self.ROWS, 2 * self.ROWS, self.module.sht_gauss)
        return transform

    def eval(self, c, d):
        order = (int(np.sqrt(8 * len(c) + 1)) - 1) // 2
        transform = self.made(order)
        theta, phi = angles(d)
        return np.array([transform.SH_to_point(c, z, p) for z, p in zip(np.cos(theta), phi)])

    def grid(self, order):
        transform = self.made(order)
        z, phi = np.meshgrid(transform.cos_theta, np.pi * np.arange(2 * self.ROWS) / self.ROWS, indexing="ij")
        return directions(np.arccos(z.ravel()), phi.ravel())

    def analyze(self, values, order):
        return self.made(order).analys(np.ascontiguousarray(values.reshape(self.ROWS, -1)))


class Healpy:
    NSIDE = 32

    def __init__(self):
        import healpy

        self.module = healpy

    def centers(self):
        return np.stack(self.module.pix2vec(self.NSIDE, np.arange(self.module.nside2npix(self.NSIDE))), -1)

    def eval(self, c, d):
        """At centers of pixels, where its maps have values: all directions are some."""
        values = self.module.alm2map(c, self.NSIDE)
        return values[self.module.vec2pix(self.NSIDE, *d.T)]

    def grid(self, order):
        return self.centers()

    def analyze(self, values, order):
        return self.module.map2alm_lsq(values, order - 1, order - 1, tol=1e-15, maxiter=60)[0]


class Quadrature:
    """A library that has functions alone: sums, and integrals of products with the functions."""

    def eval(self, c, d):
        functions = self.functions(d, self.order_of(c))
        return np.real(np.sum((c * functions).reshape(len(d), -1), axis=1))

    def order_of(self, c):
        return round(c.size**0.5)

    def grid(self, order):
        return quadrature(order)[0]

    def analyze(self, values, order):
        d, w = quadrature(order)
        functions = self.functions(d, order)
        squares = np.tensordot(w, np.abs(functions) ** 2, 1)
        found = np.tensordot(w * values, np.conj(functions), 1)
        return np.divide(found, squares, out=np.zeros_like(found), where=squares > 0.0)


class Scipy(Quadrature):
    def __init__(self):
        from scipy.special import sph_harm_y_all

        self.all = sph_harm_y_all

    def order_of(self, c):
        return len(c)

    def functions(self, d, order):
        return np.moveaxis(self.all(order - 1, order - 1, *angles(d)), -1, 0)


class Sphericart(Quadrature):
    def __init__(self):
        import sphericart

        self.module = sphericart

    def functions(self, d, order):
        return self.module.SphericalHarmonics(order - 1).compute(d)


class E3nn(Quadrature):
    def __init__(self, normalization="integral"):
        import jax

        jax.config.update("jax_enable_x64", True)
        import e3nn_jax

        self.module, self.normalization = e3nn_jax, normalization

    def functions(self, d, order):
        irreps = self.module.Irreps([(1, (l, (-1) ** l)) for l in range(order)])
        vectors = self.module.IrrepsArray("1o", d)
        how = {"normalization": self.normalization, "algorithm": ("legendre", "dense")}
        return np.asarray(self.module.spherical_harmonics(irreps, vectors, True, **how).array)


class Ambisonics(Quadrature):
    """Signals: a source of strength s towards d adds s Y(d), Y as spharpy has it, times √4π, which makes W of SN3D 1."""

    def __init__(self, normalization):
        import pyfar
        import spharpy

        self.module, self.coordinates, self.normalization = spharpy, pyfar.Coordinates, normalization

    def functions(self, d, order):
        basis = self.module.SphericalHarmonics(order - 1, self.coordinates(*d.T), normalization=self.normalization).basis
        return self.arranged(basis * np.sqrt(4 * np.pi))

    def arranged(self, functions):
        return functions

    def eval(self, c, d):
        """The signals as amplitudes of the functions that their lengths belong to."""
        order = self.order_of(c)
        nodes, w = quadrature(order)
        squares = w @ self.functions(nodes, order) ** 2
        return self.functions(d, order) @ (c / squares)

    def analyze(self, values, order):
        d, w = quadrature(order)
        return (w * values) @ self.functions(d, order)


class Fuma(Ambisonics):
    """W X Y Z R .. Q in the order of letters that Malham gave; lengths of spharpy."""

    LETTERS = "WXYZRSTUVKLMNOPQ"
    BY_ACN = "WYZXVTRSUQOMKLNP"

    def __init__(self):
        super().__init__("maxN")

    def arranged(self, functions):
        return functions[:, [self.BY_ACN.index(letter) for letter in self.LETTERS[: functions.shape[1]]]]


class FumaTable(Fuma):
    """The same by the formulas of the published table, in azimuth and elevation."""

    def functions(self, d, order):
        theta, a = angles(d)
        e, sin, cos = np.pi / 2 - theta, np.sin, np.cos
        table = [
            np.full(len(d), np.sqrt(0.5)),
            cos(a) * cos(e), sin(a) * cos(e), sin(e),
            1.5 * sin(e) ** 2 - 0.5,
            cos(a) * sin(2 * e), sin(a) * sin(2 * e), cos(2 * a) * cos(e) ** 2, sin(2 * a) * cos(e) ** 2,
            sin(e) * (5 * sin(e) ** 2 - 3) / 2,
            np.sqrt(135 / 256) * cos(a) * cos(e) * (5 * sin(e) ** 2 - 1), np.sqrt(135 / 256) * sin(a) * cos(e) * (5 * sin(e) ** 2 - 1),
            np.sqrt(27 / 4) * cos(2 * a) * sin(e) * cos(e) ** 2, np.sqrt(27 / 4) * sin(2 * a) * sin(e) * cos(e) ** 2,
            cos(3 * a) * cos(e) ** 3, sin(3 * a) * cos(e) ** 3,
        ]  # fmt: skip
        return np.stack(table[: order * order], -1)


# What evaluates and analyzes for each name, and what it is called.
WITNESSES = [
    ("pyshtools", "pyshtools", Pyshtools, ()),
    ("pyshtools-phase", "pyshtools", Pyshtools, ("4pi", -1)),
    ("pyshtools-orthonormal", "pyshtools", Pyshtools, ("ortho",)),
    ("pyshtools-schmidt", "pyshtools", Pyshtools, ("schmidt",)),
    ("pyshtools-unnormalized", "pyshtools", Pyshtools, ("unnorm",)),
    ("pyshtools-complex", "pyshtools", Pyshtools, ("4pi", 1, "complex")),
    ("pyshtools-quantum", "pyshtools", Pyshtools, ("ortho", -1, "complex")),
    ("shtns", "shtns", Shtns, ()),
    ("shtns-4pi", "shtns", Shtns, ("sht_fourpi",)),
    ("shtns-schmidt", "shtns", Shtns, ("sht_schmidt",)),
    ("shtns-schmidt-no-phase", "shtns", Shtns, ("sht_schmidt", True)),
    ("healpy", "healpy", Healpy, ()),
    ("scipy", "scipy", Scipy, ()),
    ("sphericart", "sphericart", Sphericart, ()),
    ("e3nn", "e3nn-jax", E3nn, ()),
    ("e3nn-component", "e3nn-jax", E3nn, ("component",)),
    ("e3nn-norm", "e3nn-jax", E3nn, ("norm",)),
    ("ambix", "spharpy", Ambisonics, ("SN3D",)),
    ("ambisonics-n3d", "spharpy", Ambisonics, ("N3D",)),
    ("fuma", "spharpy", Fuma, ()),
    ("fuma", "the table", FumaTable, ()),
]


class Lobe:
    """The command, in a folder."""

    def __init__(self, program, folder):
        self.program, self.folder = Path(program).resolve(), folder

    def __call__(self, *arguments):
        command = [self.program, "--quiet", *map(str, arguments)]
        return subprocess.run(command, cwd=self.folder, check=True, stdout=subprocess.PIPE, text=True).stdout

    def write(self, name, c):
        head = {"format": "lobe-sh", "version": 1, "order": round(len(c) ** 0.5), "quantity": "radiance"}
        (self.folder / name).write_text(json.dumps({**head, "coefficients": [[x] for x in c]}))

    def read(self, name):
        return np.array(json.loads((self.folder / name).read_text())["coefficients"])[:, 0]

    def eval(self, name, d):
        values = []
        # As many directions as a command line takes.
        for part in np.array_split(d, max(1, len(d) // 2000)):
            words = [word for v in part for word in ("--dir", ",".join(map(repr, map(float, v))))]
            values += [row[0] for row in json.loads(self("sh", "eval", name, "--json", *words))["values"]]
        return np.array(values)

    def names(self):
        """The names that the command has, from its refusal of another."""
        command = [self.program, "sh", "convert", "f.sh.json", "--to", "none"]
        said = subprocess.run(command, cwd=self.folder, stderr=subprocess.PIPE, text=True, check=False).stderr
        return set(said.split("[possible values: ")[1].split("]")[0].split(", "))


def version(package):
    from importlib.metadata import version

    return package if " " in package else f"{package} {version(package)}"


def differences(lobe, name, witness, order):
    """Of values in directions, and of coefficients that the library has analyzed, as parts of the largest."""
    c = RANDOM.normal(size=order * order)
    lobe.write("f.sh.json", c)
    lobe("sh", "convert", "f.sh.json", "--to", name, "-o", "c.npy")
    numbers = np.load(lobe.folder / "c.npy")
    check_python(c, name, numbers)
    d = RANDOM.normal(size=(50, 3))
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    if isinstance(witness, Healpy):
        d = witness.centers()[RANDOM.choice(len(witness.centers()), 50)]
    seen = lobe.eval("f.sh.json", d)
    forth = np.abs(witness.eval(numbers, d) - seen).max() / np.abs(seen).max()
    control = np.abs(witness.eval(wrong(numbers), d) - seen).max() / np.abs(seen).max()
    analyzed = witness.analyze(lobe.eval("f.sh.json", witness.grid(order)), order)
    np.save(lobe.folder / "a.npy", analyzed)
    lobe("sh", "convert", "a.npy", "--from", name, "-o", "back.sh.json")
    return forth, np.abs(lobe.read("back.sh.json") - c).max() / np.abs(c).max(), control


def wrong(numbers):
    """The numbers with a wrong sign: that of the largest."""
    numbers = numbers.copy()
    largest = np.unravel_index(np.abs(numbers).argmax(), numbers.shape)
    numbers[largest] *= -1
    return numbers


def check_python(c, name, numbers):
    """The Python package has the same numbers, where it is installed."""
    try:
        import lobe
    except ModuleNotFoundError:
        return
    found = lobe.Sh(c).to_convention(name)
    if found.dtype != numbers.dtype or not np.array_equal(found, numbers):
        raise SystemExit(f"{name}: the package lobe has other numbers than the command")
    back = lobe.Sh.from_convention(numbers, name).coefficients
    if np.abs(back - c).max() > 1e-13:
        raise SystemExit(f"{name}: the package lobe reads back other numbers")


def main():
    if len(sys.argv) != 2:
        raise SystemExit("usage: conventions.py target/release/lobe")
    faults = skipped = 0
    with tempfile.TemporaryDirectory() as folder:
        lobe = Lobe(sys.argv[1], Path(folder))
        untried = lobe.names() - {name for name, *_ in WITNESSES}
        for name in sorted(untried):
            print(f"{name}: DISAGREES, no library evaluates it here")
        faults += len(untried)
        print("| name | by | order | values | back | wrong sign | |")
        print("|---|---|---|---|---|---|---|")
        for name, package, kind, settings in WITNESSES:
            try:
                witness = kind(*settings)
            except ImportError as error:
                print(f"| {name} | {package} | | | | | SKIPPED, {error} |")
                skipped += 1
                continue
            for order in (4,) if name == "fuma" else (6, 20):
                forth, back, control = differences(lobe, name, witness, order)
                agrees = forth <= MOST and back <= MOST and control > 1e-4
                faults += not agrees
                said = "agrees" if agrees else "DISAGREES"
                found = f"{forth:.1e} | {back:.1e} | {control:.1e} | {said}"
                print(f"| {name} | {version(package)} | {order} | {found} |", flush=True)
    print(f"{faults} rows disagree, {skipped} libraries skipped")
    raise SystemExit(1 if faults or skipped == len(WITNESSES) else 0)


if __name__ == "__main__":
    main()
