"""What each peer does of the jobs of `lobe-bench`.

A peer is a class with a `name`, its `jobs`, of a name and an order each, and a constructor that loads the library. The method of a
job's name makes a `Prepared` of an order. Results are brought to Lobe's convention before they are compared, never in the time.
"""

import ctypes
import math
import os
import struct
import subprocess
from dataclasses import dataclass
from glob import glob
from importlib.metadata import version
from pathlib import Path
from typing import Callable

import numpy as np

import reference

# As in `lobe-bench`.
TILE, MESH, PAIRS, TURNED = 256, 1 << 20, 512, 1024
WIDTH, HEIGHT = 2048, 1024
COLORS = 3

BASIS = [("basis", order) for order in (3, 4, 6, 10)]
STREAMED = [("basis-streamed", order) for order in (3, 4, 6, 10)]
ROTATION = [("rotation", order) for order in (3, 4, 6)]
ROTATION_ONE = [("rotation-one", order) for order in (3, 4, 6, 10)]
PRODUCT_ONE = [("product-one", order) for order in (3, 4, 6)]
PROJECT_CUBE = [("project-cube", order) for order in (3, 6)]
PROJECT = [("project", order) for order in (3, 6)]
RECONSTRUCT = [("reconstruct", order) for order in (3, 6)]


@dataclass
class Prepared:
    """A job that is ready to run."""

    work: Callable[[], object]
    items: int
    # The numbers of the last run and what they should be.
    found: Callable[[], np.ndarray]
    expected: np.ndarray
    # A call of the same function with nothing to do: the price of calling from Python, which is taken off.
    empty: Callable[[], object] | None = None


def of_complex(alm, order):
    """Coefficients of a real function from the complex ones with m >= 0, which lie m after m: c_lm = sqrt(2) Re, c_l,-m = -sqrt(2) Im."""
    c, k = np.empty(alm.shape[:-1] + (order * order,)), 0
    for m in range(order):
        for l in range(m, order):
            i = l * (l + 1)
            if m == 0:
                c[..., i] = alm[..., k].real
            else:
                c[..., i + m], c[..., i - m] = math.sqrt(2) * alm[..., k].real, -math.sqrt(2) * alm[..., k].imag
            k += 1
    return c


def to_complex(c, order, dtype=np.complex128):
    """The inverse of `of_complex`."""
    columns = []
    for m in range(order):
        for l in range(m, order):
            i = l * (l + 1)
            columns.append(c[..., i] + 0j if m == 0 else (c[..., i + m] - 1j * c[..., i - m]) / math.sqrt(2))
    return np.stack(columns, axis=-1).astype(dtype)


def of_cosines(cilm):
    """From [cosine or sine, l, m]."""
    order = cilm.shape[1]
    return np.array([cilm[int(m < 0), l, abs(m)] for l in range(order) for m in range(-l, l + 1)])


def to_cosines(c, order):
    """The inverse of `of_cosines`."""
    out = np.zeros((2, order, order))
    for l in range(order):
        for m in range(-l, l + 1):
            out[int(m < 0), l, abs(m)] = c[l * (l + 1) + m]
    return out


def colors(order):
    """Three functions, one for each color."""
    return reference.coefficients(order, COLORS) / (1 + np.arange(order * order))


class Blas:
    """The matrices of the bands times many functions by the BLAS of numpy."""

    name = "numpy (BLAS)"
    jobs = ROTATION

    def __init__(self):
        self.version = np.__version__

    def rotation(self, order):
        f = reference.coefficients(order, TURNED)
        matrix = reference.rotated(np.eye(order * order), order).T
        bands = [slice(l * l, (l + 1) ** 2) for l in range(order)]
        blocks = [np.ascontiguousarray(matrix[band, band], np.float32) for band in bands]
        sources = [np.ascontiguousarray(f.T[band], np.float32) for band in bands]
        results = [np.empty_like(source) for source in sources]

        def work():
            for block, source, result in zip(blocks, sources, results):
                np.matmul(block, source, out=result)

        return Prepared(work, TURNED, lambda: np.concatenate(results).T, reference.rotated(f, order))


class Sphericart:
    """The basis, a row for each direction, by sphericart's C functions into an array that is there."""

    name = "sphericart"
    jobs = BASIS + STREAMED

    def __init__(self):
        import sphericart

        self.module, self.version = sphericart, version("sphericart")

    def basis(self, order):
        return self.of_directions(order, TILE)

    def basis_streamed(self, order):
        return self.of_directions(order, MESH)

    def of_directions(self, order, count):
        calculator = self.module.SphericalHarmonics(order - 1)
        compute = calculator._lib.sphericart_spherical_harmonics_compute_array_f
        d = np.ascontiguousarray(reference.directions(count), np.float32)
        out = np.empty((count, order * order), np.float32)
        floats = ctypes.POINTER(ctypes.c_float)
        data, result = d.ctypes.data_as(floats), out.ctypes.data_as(floats)
        some = slice(0, count, max(1, count // TILE))
        # No phase (-1)^m there.
        return Prepared(
            lambda: compute(calculator._calculator_f, data, d.size, result, out.size),
            count,
            lambda: out[some] * reference.phases(order),
            reference.basis(d[some].astype(float), order),
            lambda: compute(calculator._calculator_f, data, 0, result, 0),
        )


class DrJit:
    """The basis of many directions, an array for each function of it, by code that is compiled for the machine.

    Each run has new arrays, from a pool. The tile of `basis` is no job for it: a launch takes longer than the tile.
    """

    name = "Dr.Jit"
    jobs = STREAMED

    def __init__(self):
        os.environ.setdefault("DRJIT_LIBLLVM_PATH", self.llvm())
        import drjit

        self.drjit, self.version = drjit, drjit.__version__
        drjit.set_thread_count(1)

    @staticmethod
    def llvm():
        """The newest LLVM of 17 and above: older ones end the process on machines with AVX-512."""
        found = {}
        for path in glob("/usr/lib/*/libLLVM*.so*") + glob("/usr/lib/libLLVM*.so*") + glob("/usr/lib/llvm-*/lib/libLLVM*.so*"):
            digits = "".join(c if c.isdigit() else " " for c in Path(path).name).split()
            if digits and int(digits[0]) >= 17:
                found[int(digits[0])] = path
        if not found:
            raise ImportError("no libLLVM of version 17 or above; apt-get install libllvm19, or set DRJIT_LIBLLVM_PATH")
        return found[max(found)]

    def basis_streamed(self, order):
        from drjit.llvm import Array3f

        drjit = self.drjit
        d = reference.directions(MESH).astype(np.float32)
        at = Array3f(np.ascontiguousarray(d.T))
        drjit.eval(at)
        drjit.sync_thread()
        kept = []

        def work():
            kept[:] = [drjit.sh_eval(at, order - 1)]
            drjit.eval(kept)
            drjit.sync_thread()

        def found():
            planes = [np.broadcast_to(np.array(plane), MESH)[:: MESH // TILE] for plane in kept[0]]
            return np.stack(planes, axis=1)

        return Prepared(work, MESH, found, reference.basis(d[:: MESH // TILE].astype(float), order))


class Ducc0:
    """Sums over rings of a grid of Fejer's first rule, whose rings are the rows of a lat-long picture; rotation of all functions in one call."""

    name = "ducc0"
    jobs = PROJECT + RECONSTRUCT + ROTATION + ROTATION_ONE

    def __init__(self):
        import ducc0

        self.sht, self.version = ducc0.sht, ducc0.__version__

    def planes(self, order):
        phi = math.pi / WIDTH + 2 * math.pi * np.arange(WIDTH) / WIDTH
        theta, _ = reference.texels(WIDTH, HEIGHT)
        return np.stack([reference.grid(theta, phi, f, order) for f in colors(order)])

    def project(self, order):
        planes = self.planes(order).astype(np.float32)[:, None]
        alms = np.empty((COLORS, 1, order * (order + 1) // 2), np.complex64)
        weights = self.sht.get_gridweights("F1", HEIGHT) / WIDTH
        options = {"spin": 0, "lmax": order - 1, "geometry": "F1", "phi0": math.pi / WIDTH, "nthreads": 1, "ringfactor": weights}

        def work():
            for plane, alm in zip(planes, alms):
                self.sht.adjoint_synthesis_2d(map=plane, alm=alm, **options)

        return Prepared(work, WIDTH * HEIGHT, lambda: of_complex(alms[:, 0], order), colors(order))

    def reconstruct(self, order):
        alms = to_complex(colors(order), order, np.complex64)[:, None]
        planes = np.empty((COLORS, 1, HEIGHT, WIDTH), np.float32)
        options = {"spin": 0, "lmax": order - 1, "geometry": "F1", "phi0": math.pi / WIDTH, "nthreads": 1}

        def work():
            for plane, alm in zip(planes, alms):
                self.sht.synthesis_2d(alm=alm, map=plane, **options)

        return Prepared(work, WIDTH * HEIGHT, lambda: planes[:, 0], self.planes(order))

    def rotation(self, order):
        return self.turned(order, TURNED)

    def rotation_one(self, order):
        return self.turned(order, 1)

    def turned(self, order, count):
        alpha, beta, gamma = reference.euler_zyz(reference.turn())
        f = reference.coefficients(order, count)
        alms = to_complex(f, order, np.complex64)
        out, nothing = np.empty_like(alms), np.zeros((1, 1), np.complex64)
        return Prepared(
            lambda: self.sht.rotate_alm(alms, order - 1, gamma, beta, alpha, out=out),
            count,
            lambda: of_complex(out, order),
            reference.rotated(f, order),
            lambda: self.sht.rotate_alm(nothing, 0, gamma, beta, alpha, out=nothing),
        )


class Shtns:
    """Transforms on its regular grid, whose rows are those of a lat-long picture, in double precision; rotation by Euler angles."""

    name = "SHTns"
    jobs = PROJECT + RECONSTRUCT + ROTATION_ONE

    def __init__(self):
        import shtns

        self.shtns, self.version = shtns, shtns.__version__
        shtns.set_verbosity(0)

    def transform(self, order):
        transform = self.shtns.sht(order - 1, order - 1, 1, self.shtns.sht_orthonormal, 1)
        transform.set_grid(HEIGHT, WIDTH, self.shtns.sht_reg_fast | self.shtns.SHT_PHI_CONTIGUOUS, 0)
        return transform

    @staticmethod
    def planes(order):
        theta, _ = reference.texels(WIDTH, HEIGHT)
        phi = 2 * math.pi * np.arange(WIDTH) / WIDTH
        return np.stack([reference.grid(theta, phi, f, order) for f in colors(order)])

    def project(self, order):
        transform, planes = self.transform(order), self.planes(order)
        alms = np.stack([transform.spec_array() for _ in range(COLORS)])
        once = planes.copy()

        def work():
            for plane, alm in zip(planes, alms):
                transform.spat_to_SH(plane, alm)

        work()
        if not np.array_equal(planes, once):
            raise ValueError("the planes have changed")
        return Prepared(work, WIDTH * HEIGHT, lambda: of_complex(alms, order), colors(order))

    def reconstruct(self, order):
        transform, planes = self.transform(order), np.empty((COLORS, HEIGHT, WIDTH))
        alms = to_complex(colors(order), order)
        once = alms.copy()

        def work():
            for plane, alm in zip(planes, alms):
                transform.SH_to_spat(alm, plane)

        work()
        if not np.array_equal(alms, once):
            raise ValueError("the coefficients have changed")
        return Prepared(work, WIDTH * HEIGHT, lambda: planes, self.planes(order))

    def rotation_one(self, order):
        alpha, beta, gamma = reference.euler_zyz(reference.turn())
        f = reference.coefficients(order)
        alm, rotation, kept = to_complex(f, order)[0], self.shtns.rotation(order - 1), []

        def work():
            rotation.set_angles_ZYZ(gamma, beta, alpha)
            kept[:] = [rotation.apply_real(alm)]

        # The smallest that there is: two bands.
        least, few = self.shtns.rotation(1), np.zeros(3, complex)

        def empty():
            least.set_angles_ZYZ(gamma, beta, alpha)
            least.apply_real(few)

        return Prepared(work, 1, lambda: of_complex(kept[0], order)[None], reference.rotated(f, order), empty)


class Pyshtools:
    """Driscoll and Healy's grid of the same size, by the backend that it takes by itself; in double precision.

    The rows of that grid begin at the pole, so that its values are others, of the same function.
    """

    name = "pyshtools"
    jobs = PROJECT + RECONSTRUCT + ROTATION_ONE

    def __init__(self):
        import pyshtools

        self.pyshtools, self.version = pyshtools, pyshtools.__version__
        if pyshtools.backends.preferred_backend() == "ducc":
            pyshtools.backends.select_preferred_backend("ducc", nthreads=1)

    @staticmethod
    def planes(order):
        theta, phi = math.pi * np.arange(HEIGHT) / HEIGHT, 2 * math.pi * np.arange(WIDTH) / WIDTH
        return np.stack([reference.grid(theta, phi, f, order) for f in colors(order)])

    def project(self, order):
        planes, kept = self.planes(order), []
        expand = self.pyshtools.expand.SHExpandDH

        def work():
            kept[:] = [expand(plane, norm=4, sampling=2, csphase=-1, lmax_calc=order - 1) for plane in planes]

        return Prepared(work, WIDTH * HEIGHT, lambda: np.stack([of_cosines(c) for c in kept]), colors(order))

    def reconstruct(self, order):
        cilms = [to_cosines(f, order) for f in colors(order)]
        make, kept = self.pyshtools.expand.MakeGridDH, []

        def work():
            kept[:] = [make(c, lmax=HEIGHT // 2 - 1, norm=4, sampling=2, csphase=-1, lmax_calc=order - 1, extend=False) for c in cilms]

        return Prepared(work, WIDTH * HEIGHT, lambda: np.stack(kept), self.planes(order))

    def rotation_one(self, order):
        f = reference.coefficients(order)
        # Without the phase, and by the negative angles: the body turns.
        cilm, phases = to_cosines(f[0] * reference.phases(order), order), reference.phases(order)
        angles = -np.array(reference.euler_zyz(reference.turn())[::-1])
        quarter, turn, kept = self.pyshtools.rotate.djpi2(order - 1), self.pyshtools.rotate.SHRotateRealCoef, []

        def work():
            kept[:] = [turn(cilm, angles, quarter)]

        return Prepared(work, 1, lambda: (of_cosines(kept[0]) * phases)[None], reference.rotated(f, order))


class Embree:
    """Any-hit rays, all of them in one call of embreex, which asks `rtcOccluded1` for one after the other."""

    name = "Embree (embreex)"
    jobs = [("occlusion", None)]

    def __init__(self):
        from embreex import mesh_construction, rtcore_scene

        self.mesh, self.scene, self.version = mesh_construction.TriangleMesh, rtcore_scene.EmbreeScene, version("embreex")

    def occlusion(self, _):
        rays = read_safetensors(os.environ["LOBE_RAYS"])
        scene = self.scene()
        self.mesh(scene, rays["corners"])
        points, directions = rays["points"], rays["directions"]
        origins = np.repeat(points, len(directions), axis=0)
        every = np.tile(directions, (len(points), 1))
        kept = []

        def work():
            kept[:] = [scene.run(origins, every, query="OCCLUDED")]

        # Rays that graze an edge differ: what is compared is the part of all rays that are hidden.
        part = lambda hidden: np.array([np.count_nonzero(hidden) / len(every)])  # noqa: E731
        return Prepared(work, len(every), lambda: part(kept[0] >= 0), part(rays["hidden"]))


def read_safetensors(path):
    """The tensors of a file, by name."""
    import json

    data = Path(path).read_bytes()
    (length,) = struct.unpack("<Q", data[:8])
    header, numbers = json.loads(data[8 : 8 + length]), data[8 + length :]
    types = {"F32": "<f4", "U8": "u1"}
    return {
        name: np.frombuffer(numbers[slice(*entry["data_offsets"])], types[entry["dtype"]]).reshape(entry["shape"])
        for name, entry in header.items()
        if name != "__metadata__"
    }


def cube(order, side=512):
    """The colors of texels of the faces +x, -x, +y, -y, +z, -z, at their middles."""
    v, u = np.meshgrid(*2 * [(2 * np.arange(side) + 1) / side - 1], indexing="ij")
    one = np.ones_like(u)
    faces = [(one, -v, -u), (-one, -v, u), (u, one, v), (u, -one, -v), (u, -v, one), (-u, -v, -one)]
    d = np.stack([np.stack(face, axis=-1) for face in faces]).reshape(-1, 3)
    d /= np.linalg.norm(d, axis=1)[:, None]
    parts = np.array_split(d, 64)
    return d, np.concatenate([reference.basis(part, order) @ colors(order).T for part in parts])


def run_program(program, job, order, seconds, given):
    """The numbers that a peer in C++ writes, and the nanoseconds that it says."""
    sent = b"".join(np.ascontiguousarray(part, np.float32).tobytes() for part in given)
    done = subprocess.run([program, job, str(order), str(seconds)], input=sent, capture_output=True, check=False)
    if done.returncode != 0:
        raise ValueError(done.stderr.decode().strip() or f"ended with {done.returncode}")
    return np.frombuffer(done.stdout, np.float32), float(done.stderr)


# Sums of a million and a half texels in single precision.
CUBE_SAME = 2e-3


class DirectXMath:
    """DirectXSH by `directxmath.cpp`, which the driver has compiled; that program measures by itself."""

    name = "DirectXMath"
    jobs = [job for job in BASIS + STREAMED + ROTATION + ROTATION_ONE if job[1] <= 6] + PRODUCT_ONE + PROJECT_CUBE
    allowed = {"project-cube": CUBE_SAME}

    def __init__(self):
        if "LOBE_DIRECTXMATH" not in os.environ:
            raise ImportError(os.environ.get("LOBE_NO_DIRECTXMATH", "set DIRECTXMATH to a checkout"))
        self.program, self.version = os.environ["LOBE_DIRECTXMATH"], "checkout"

    def measure(self, job, order, seconds):
        """Nanoseconds for an item, and how far the numbers are apart."""
        given, expected = self.numbers(job, order)
        found, ns = run_program(self.program, job, order, seconds, given)
        found = found.reshape(-1, order * order)
        return ns, reference.apart(found[:: max(1, len(found) // TURNED)], expected)

    @staticmethod
    def numbers(job, order):
        """What the program reads, and what it should write, of a thousand items."""
        if job.startswith("basis"):
            count = MESH if job == "basis-streamed" else TILE
            d = reference.directions(count)
            return [d], reference.basis(d[:: max(1, count // TURNED)].astype(np.float32).astype(float), order)
        if job.startswith("rotation"):
            f = reference.coefficients(order, TURNED if job == "rotation" else 1)
            return [reference.turn(), f], reference.rotated(f, order)
        if job == "project-cube":
            return [cube(order)[1]], colors(order)
        f = reference.coefficients(order, PAIRS)
        g = f.flatten()[::-1].reshape(f.shape)
        return [f, g], reference.product(f, g, order)


class Filament:
    """libfilament_ibl of Debian by `filament.cpp`, which the driver has compiled.

    Its loops take two threads at least, which have one core.
    """

    name = "Filament"
    jobs = PROJECT_CUBE + [("irradiance", 3), ("dering", 3)]
    # Deringed probes have another window; what is left below zero is in parts of the largest value.
    allowed = {"project-cube": CUBE_SAME, "dering": 0.1}

    def __init__(self):
        if "LOBE_FILAMENT" not in os.environ:
            raise ImportError(os.environ.get("LOBE_NO_FILAMENT", "apt-get install libfilament-dev"))
        self.program, self.version = os.environ["LOBE_FILAMENT"], "libfilament_ibl"
        if hasattr(os, "sched_setaffinity"):
            os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})

    def measure(self, job, order, seconds):
        """Nanoseconds for an item, and how far the numbers are apart."""
        if job == "project-cube":
            found, ns = run_program(self.program, job, order, seconds, [cube(order)[1]])
            return ns, reference.apart(found.reshape(-1, COLORS).T, colors(order))
        if job == "irradiance":
            f, (d, _) = reference.coefficients(order, COLORS) + 2, cube(order, 64)
            found, ns = run_program(self.program, job, order, seconds, [f.T])
            return ns, reference.apart(found.reshape(-1, COLORS), reference.basis(d, order) @ f.T / math.pi)
        return self.dering(seconds)

    def dering(self, seconds):
        """Skies with a sun, as in `lobe-bench`."""
        count, order, d = 1024, 3, reference.directions(4096)
        phi = 0.618 * np.arange(count)
        around, up = math.sin(0.3), np.full(count, math.cos(0.3))
        suns = np.stack([around * np.cos(phi), around * np.sin(phi), up], axis=1)
        probes = reference.basis(suns, order)[:, :, None] * np.array([5.0, 4.0, 2.5])
        probes[:, 0] += 1
        found, ns = run_program(self.program, "dering", order, seconds, [probes])
        values = reference.basis(d, order) @ found.reshape(count, 9, COLORS).astype(float)
        return ns, float((-values.min(axis=1) / values.max(axis=1)).max().clip(0))


PEERS = [Blas, Sphericart, DrJit, Ducc0, Shtns, Pyshtools, Embree, DirectXMath, Filament]
