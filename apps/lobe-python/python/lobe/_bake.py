"""Bakes: what a scene does to light, at its vertices, its texels or points in space, for any light to come."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import TypedDict

import numpy as np
import numpy.typing as npt

from . import _lobe
from ._arrays import Doubles, expect, points, real, whole
from ._sh import Sh

Path = str | os.PathLike[str]
Progress = Callable[[int, int], object]


class BakeReport(TypedDict):
    """What a bake tells of itself."""

    receivers: int
    rays: int
    seconds: float
    bounces: int
    stderr_dc: float


@dataclass(frozen=True)
class BakeOptions:
    """Options of a bake, as of `lobe bake`."""

    mode: str = "interreflected"
    """unshadowed, shadowed, interreflected, or glossy (matrices of the light that arrives)."""
    order: int = 4
    """Number of bands, 1 to 8."""
    samples: int = 1024
    """Paths from each vertex, best a power of two."""
    bounces: int = 3
    """Reflections at most."""
    energy_stop: float = 1e-3
    """Bounces that carry less than this part of the energy are left out."""
    seed: int = 0
    """Bakes with different seeds have independent errors."""
    albedo: str = "vertex"
    """vertex, or none: whoever shades multiplies by the base color."""
    max_edge: float | None = None
    """Triangles are split first until no edge is longer, in the scene's unit of length."""
    texels: int | None = None
    """Texels along a side of a lightmap, where light is baked instead of at vertices."""
    grid: tuple[int, int, int] | None = None
    """Points in space along x, y and z, where the light that arrives is baked as matrices."""
    grid_box: tuple[float, float, float, float, float, float] | None = None
    """Two corners of the grid's box, which are points; without them points are in the middle of as many equal parts of the scene's box."""

    def __post_init__(self) -> None:
        modes = ("unshadowed", "shadowed", "interreflected", "glossy")
        if self.mode not in modes:
            raise ValueError(f"mode: expected {', '.join(modes[:-1])} or glossy, found {self.mode!r}")
        if self.albedo not in ("vertex", "none"):
            raise ValueError(f"albedo: expected vertex or none, found {self.albedo!r}")
        for name, least, most in [("order", 1, 8), ("samples", 1, 1 << 24), ("bounces", 0, 255), ("seed", 0, 2**64 - 1)]:
            whole(getattr(self, name), name, least, most)
        real(self.energy_stop, "energy_stop", 0.0, 1.0)
        self._check_points()

    def _check_points(self) -> None:
        if self.max_edge is not None:
            expect(self.max_edge, (int, float, np.integer, np.floating), "max_edge", "a number")
            if not (np.isfinite(self.max_edge) and self.max_edge > 0):
                raise ValueError(f"max_edge: expected a length above 0, found {self.max_edge}")
        if self.texels is not None:
            whole(self.texels, "texels", 1, 1 << 14)
        for corners, what, expected in [(self.grid, "grid", "three numbers of points"), (self.grid_box, "grid_box", "two corners")]:
            expect(corners, (tuple, list, np.ndarray, type(None)), what, expected)
        if self.grid is not None and len([whole(count, "grid", 2, 4096) for count in self.grid]) != 3:
            raise ValueError(f"grid: expected three numbers of points, found {self.grid}")
        if self.grid_box is not None and (len(self.grid_box) != 6 or not np.isfinite(self.grid_box).all()):
            raise ValueError(f"grid_box: expected the six numbers of two corners, found {self.grid_box}")
        is_elsewhere = self.texels is not None or self.grid is not None
        for is_refused, why in [
            (self.texels is not None and self.grid is not None, "texels and grid: expected one of them"),
            (self.grid_box is not None and self.grid is None, "grid_box: only with grid"),
            (self.max_edge is not None and is_elsewhere, "max_edge: light is not at vertices with texels and grid"),
            (self.mode == "glossy" and is_elsewhere, "mode: glossy at vertices only; grid bakes matrices by itself"),
            (
                self.albedo == "none" and (self.mode == "glossy" or self.grid is not None),
                "albedo: matrices never have it, none is for vectors",
            ),
        ]:
            if is_refused:
                raise ValueError(why)

    def of(self, scene: Path) -> _lobe.Bake:
        """The bake of a scene."""
        return _lobe.Bake(scene, asdict(self))


def bake(
    scene: Path,
    output: Path,
    options: BakeOptions | None = None,
    *,
    shard: tuple[int, int] | None = None,
    progress: Progress | None = None,
) -> BakeReport:
    """Bakes the transfer of a scene, and writes the bytes of `lobe bake`: a .glb of transfer at vertices, a .safetensors file of any, an .exr of
    texels.

    `scene` is a file, or "built-in:still-life" or another scene of Lobe. Results are kept beside the output while they are found: a bake that was
    stopped, by Ctrl-C or by what `progress(done, total)` raises, goes on from there. With `shard=(i, n)` part i of n is baked, from 1 on,
    and written as a .safetensors file, which `merge` puts together with the others.
    """
    made = (options or BakeOptions()).of(scene)
    if shard is None:
        report: BakeReport = made.write(output, progress)
        return report
    if not isinstance(shard, (tuple, list)) or len(shard) != 2:
        raise TypeError(f"shard: expected a pair such as (1, 4), found {shard!r}")
    number, count = (whole(k, "shard", 1, 1 << 20) for k in shard)
    part: BakeReport = made.write_shard(output, number, count, progress)
    return part


def merge(
    scene: Path,
    parts: Sequence[Path],
    output: Path,
    options: BakeOptions | None = None,
    *,
    progress: Progress | None = None,
) -> BakeReport:
    """Puts all shards of a bake together, in any order: the bytes that one machine alone writes. Shards of other work, missing ones and those
    that are there twice are refused by name."""
    if isinstance(parts, (str, bytes, os.PathLike)) or not isinstance(parts, Sequence):
        raise TypeError(f"parts: expected a list of files, found {parts!r}")
    report: BakeReport = (options or BakeOptions()).of(scene).merge(list(parts), output, progress)
    return report


class Transfer:
    """Transfer that was baked at vertices: what they send under any distant light."""

    def __init__(self, path: Path) -> None:
        """From a baked .glb, or a .safetensors file of vertices."""
        self._transfer = _lobe.load_transfer(path)

    @property
    def order(self) -> int:
        """The number of bands."""
        return self._transfer.order

    def __len__(self) -> int:
        """The number of vertices."""
        return len(self._transfer)

    def __repr__(self) -> str:
        return f"Transfer(order {self.order}, {len(self)} vertices)"

    @property
    def coefficients(self) -> npt.NDArray[np.float32] | None:
        """A copy of the coefficients, (vertices, n²), or (vertices, 3, n²) for colors; None if they are compressed."""
        return self._transfer.coefficients()

    def exit_radiance(self, light: Sh) -> npt.NDArray[np.float32]:
        """What each vertex sends under radiance from everywhere: (vertices, 3). Bands of the light beyond the transfer's count nothing."""
        return self._transfer.exit_radiance(_light(light, self.order))


class Matrices:
    """Transfer matrices that were baked: the light that arrives, past shadows and with reflections, to be reflected by any lobe."""

    def __init__(self, path: Path, grid: bool = False) -> None:
        """From a .safetensors file of `mode="glossy"`, or with `grid` of points in space."""
        self._matrices = _lobe.load_matrices(path, bool(grid))

    @property
    def order(self) -> int:
        """The number of bands."""
        return self._matrices.order

    def __len__(self) -> int:
        """The number of points."""
        return len(self._matrices)

    @property
    def grid(self) -> tuple[tuple[int, int, int], Doubles] | None:
        """Points along x, y and z, and two corners of the box of a grid, (2, 3); None of vertices."""
        found = self._matrices.grid
        return None if found is None else (found[0], np.asarray(found[1], np.float64))

    def __repr__(self) -> str:
        return f"Matrices(order {self.order}, {len(self)} points)"

    @property
    def coefficients(self) -> npt.NDArray[np.float32]:
        """A copy of the matrices, (points, n², n²), or (points, 3, n², n²) for colors: rows of the light that arrives."""
        return self._matrices.coefficients()

    def incident(self, light: Sh) -> Sh:
        """The light that arrives at each point under radiance from everywhere, M L: float32, (points, n², 3). Bands of the light beyond the
        matrices' count nothing."""
        return Sh(self._matrices.incident(_light(light, self.order)))

    def incident_at(self, light: Sh, places: npt.ArrayLike) -> Sh:
        """The same at places (..., 3) of the scene's world, between the eight points of a grid around each: (..., n², 3)."""
        found, shape = points(places, "places")
        arrives = self._matrices.incident_at(_light(light, self.order), found)
        return Sh(arrives.reshape((*shape, *arrives.shape[1:])))


def _light(light: Sh, order: int) -> Doubles:
    """The colors of one function, of an order."""
    expect(light, Sh, "light", "an Sh")
    if light.shape:
        raise ValueError(f"light: expected one function, found a batch of shape {light.shape}")
    c = light.resized(order).coefficients.astype(np.float64)
    return np.ascontiguousarray(c if light.is_color else np.repeat(c[:, None], 3, axis=1))
