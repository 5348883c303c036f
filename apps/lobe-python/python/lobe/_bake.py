"""Bakes: what a scene does to light, at its vertices, its texels or points in space, for any light to come."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any, TypedDict

import numpy as np
import numpy.typing as npt

from . import _lobe
from ._arrays import Doubles, expect, points, real, whole
from ._carried import bytes_of, from_bytes
from ._scene import Path, Progress, Scene
from ._sh import Sh

MAX_CLUSTERS, MAX_COMPONENTS = 1 << 16, 192
"""Of compressed transfer: of the highest order in color a row has as many numbers as there are components at most."""


class CompressReport(TypedDict):
    """What compression tells of itself."""

    clusters: int
    components: int
    squared_error: float
    """The squared differences of all coefficients, summed."""
    relative_error: float
    """The root of that over the squares of the coefficients."""
    bytes_before: int
    bytes: int
    ratio: float
    iterations: list[float]
    """The squared error after each round of clustering."""


class AdaptiveReport(TypedDict):
    """What splitting before a bake tells of itself."""

    rounds: int
    vertices_before: int
    vertices: int
    rays: int
    error: float
    """The estimate of the error at the end, as a part of what is there."""
    error_bound: float
    """One standard deviation more, which splitting compares with its goal."""
    too_short: float
    """The part of the error in triangles whose edges are too short to be halved."""


class _BakeReport(TypedDict):
    receivers: int
    rays: int
    seconds: float
    samples: int
    """Paths from each point."""
    bounces: int
    stderr_dc: float


class BakeReport(_BakeReport, total=False):
    """What a bake tells of itself."""

    adaptive: AdaptiveReport
    """With `adaptive`."""
    compression: CompressReport
    """With `clusters`, `components` or `weights`."""


@dataclass(frozen=True)
class BakeOptions:
    """Options of a bake, as of `lobe bake`."""

    mode: str = "interreflected"
    """unshadowed, shadowed, interreflected, or glossy (matrices of the light that arrives)."""
    order: int = 4
    """Number of bands, 1 to 8."""
    samples: int | None = None
    """Paths from each vertex, best a power of two; None: 1024, or up to 4096 where their noise is above 2 %."""
    bounces: int = 3
    """Reflections at most."""
    energy_stop: float = 1e-3
    """Bounces that carry less than this part of the energy are left out."""
    seed: int = 0
    """Bakes with different seeds have independent errors."""
    albedo: str | None = None
    """vertex, or none: whoever shades multiplies by the base color. None: none if a texture colors any surface, else vertex."""
    max_edge: float | None = None
    """Triangles are split first until no edge is longer, in the scene's unit of length."""
    texels: int | None = None
    """Texels along a side of a lightmap, where light is baked instead of at vertices."""
    unwrap: str = "auto"
    """With texels: auto unwraps a scene whose texture coordinates overlap or are missing; always, never."""
    denoise: bool = True
    """With texels: whether those that differ by their noise alone are averaged."""
    grid: tuple[int, int, int] | None = None
    """Points in space along x, y and z, where the light that arrives is baked as matrices."""
    grid_box: tuple[float, float, float, float, float, float] | None = None
    """Two corners of the grid's box, which are points; without them points are in the middle of as many equal parts of the scene's box."""
    split: bool | None = None
    """Whether triangles are split first where transfer between vertices is off; None: of a .glb and of shards, unless max_edge is given, and if
    one of the next three is given."""
    adaptive: float | None = None
    """Splitting ends where transfer is off by less than this part of itself; None: 0.01."""
    min_edge: float | None = None
    """Edges that are shorter are not split; None: 1/1024 of the scene's diagonal."""
    max_vertices: int | None = None
    """Vertices at most, spent where transfer is farthest off; None: four times those of the scene, at least 20000."""
    clusters: int | None = None
    """Transfer is compressed if this or one of the next two is given: to as many clusters at most, 1 to 65536; None: 64."""
    components: int | None = None
    """Components in each cluster, 0 to 192; None: 8."""
    weights: int | None = None
    """Bits of a weight, 8, 16 or 32; None: 16."""

    def __post_init__(self) -> None:
        modes = ("unshadowed", "shadowed", "interreflected", "glossy")
        if self.mode not in modes:
            raise ValueError(f"mode: expected {', '.join(modes[:-1])} or glossy, found {self.mode!r}")
        if self.albedo not in (None, "vertex", "none"):
            raise ValueError(f"albedo: expected vertex or none, found {self.albedo!r}")
        if self.samples is not None:
            whole(self.samples, "samples", 1, 1 << 24)
        for name, least, most in [("order", 1, 8), ("bounces", 0, 255), ("seed", 0, 2**64 - 1)]:
            whole(getattr(self, name), name, least, most)
        real(self.energy_stop, "energy_stop", 0.0, 1.0)
        self._check_points()

    @property
    def _asks_to_split(self) -> bool:
        return (self.adaptive, self.min_edge, self.max_vertices) != (None, None, None)

    def is_split(self, output: Path | None) -> bool:
        """Whether triangles are split for this output, or for shards."""
        if self.texels is not None or self.grid is not None:
            return False
        has_scene = (output is None or os.fspath(output).lower().endswith(".glb")) and self.mode != "glossy"
        is_left_open = has_scene and self.max_edge is None
        return self._asks_to_split or (is_left_open if self.split is None else self.split)

    @property
    def _is_compressed(self) -> bool:
        return (self.clusters, self.components, self.weights) != (None, None, None)

    def _check_numbers(self) -> None:
        for length, what in [(self.max_edge, "max_edge"), (self.adaptive, "adaptive"), (self.min_edge, "min_edge")]:
            if length is not None:
                expect(length, (int, float, np.integer, np.floating), what, "a number")
                if not (np.isfinite(length) and length > 0):
                    expected = "a number" if what == "adaptive" else "a length"
                    raise ValueError(f"{what}: expected {expected} above 0, found {length}")
        for count, what, least, most in [
            (self.max_vertices, "max_vertices", 1, 2**32 - 1),
            (self.clusters, "clusters", 1, MAX_CLUSTERS),
            (self.components, "components", 0, MAX_COMPONENTS),
        ]:
            if count is not None:
                whole(count, what, least, most)
        if self.weights is not None:
            expect_bits(self.weights)

    def _check_points(self) -> None:
        self._check_numbers()
        if self.texels is not None:
            whole(self.texels, "texels", 1, 1 << 14)
        if self.unwrap not in ("auto", "always", "never"):
            raise ValueError(f"unwrap: expected auto, always or never, found {self.unwrap!r}")
        expect(self.denoise, bool, "denoise", "True or False")
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
            (self._asks_to_split and is_elsewhere, "adaptive, min_edge and max_vertices: light is not at vertices with texels and grid"),
            (self._asks_to_split and self.split is False, "adaptive, min_edge and max_vertices: nothing is split with split=False"),
            (
                self._is_compressed and (self.mode == "glossy" or self.grid is not None),
                "clusters, components and weights: of transfer vectors only, not of matrices",
            ),
            (self.mode == "glossy" and is_elsewhere, "mode: glossy at vertices only; grid bakes matrices by itself"),
            (
                self.albedo == "none" and (self.mode == "glossy" or self.grid is not None),
                "albedo: matrices never have it, none is for vectors",
            ),
        ]:
            if is_refused:
                raise ValueError(why)

    def of(self, scene: Path | Scene, output: Path | None = None) -> _lobe.Bake:
        """The bake of a scene into an output; without one that of shards, whose scene is split at once."""
        return _lobe.Bake(Scene.of(scene), asdict(self) | {"split": self.is_split(output), "is_shared": output is None})


def expect_bits(weights: int) -> int:
    """The bits of a weight."""
    if weights not in (8, 16, 32):
        raise ValueError(f"weights: expected 8, 16 or 32 bits, found {weights}")
    return int(weights)


def bake(
    scene: Path | Scene,
    output: Path,
    options: BakeOptions | None = None,
    *,
    shard: tuple[int, int] | None = None,
    progress: Progress | None = None,
) -> BakeReport:
    """Bakes the transfer of a scene, and writes the bytes of `lobe bake`: a .glb of transfer at vertices, a .safetensors file of any, an .exr of
    texels.

    `scene` is a file, which `Scene` tells how to read, or "built-in:still-life" or another scene of Lobe. Results are kept beside the output while they are found: a bake that was
    stopped, by Ctrl-C or by what `progress(done, total)` raises, goes on from there. With `shard=(i, n)` part i of n is baked, from 1 on,
    and written as a .safetensors file, which `merge` puts together with the others.
    """
    options = options or BakeOptions()
    if shard is None:
        report: BakeReport = options.of(scene, output).write(output, progress)
        return report
    number, count = expect_shard(shard)
    part: BakeReport = options.of(scene).write_shard(output, number, count, progress)
    return part


def expect_shard(shard: object) -> tuple[int, int]:
    """The number of a shard, from 1 on, and how many there are."""
    if not isinstance(shard, (tuple, list)) or len(shard) != 2:
        raise TypeError(f"shard: expected a pair such as (1, 4), found {shard!r}")
    number, count = (whole(k, "shard", 1, 1 << 20) for k in shard)
    return number, count


def expect_parts(parts: object) -> list[Path]:
    """The files of all shards."""
    if isinstance(parts, (str, bytes, os.PathLike)) or not isinstance(parts, Sequence):
        raise TypeError(f"parts: expected a list of files, found {parts!r}")
    return list(parts)


def merge(
    scene: Path | Scene,
    parts: Sequence[Path],
    output: Path,
    options: BakeOptions | None = None,
    *,
    progress: Progress | None = None,
) -> BakeReport:
    """Puts all shards of a bake together, in any order: the bytes that one machine alone writes. Shards of other work, missing ones and those
    that are there twice are refused by name."""
    paths = expect_parts(parts)
    options = options or BakeOptions()
    report: BakeReport = options.of(scene).merge(paths, output, progress)
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

    def __reduce__(self) -> tuple[Any, ...]:
        return _transfer_of, (bytes_of(self._transfer.write),)

    def __repr__(self) -> str:
        return f"Transfer(order {self.order}, {len(self)} vertices)"

    @property
    def coefficients(self) -> npt.NDArray[np.float32] | None:
        """A copy of the coefficients, (vertices, n²), or (vertices, 3, n²) for colors, those of 16 bits too; None if they are compressed."""
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

    def __reduce__(self) -> tuple[Any, ...]:
        return _matrices_of, (bytes_of(self._matrices.write), self._matrices.grid is not None)

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


def _transfer_of(contents: bytes) -> Transfer:
    """The transfer that was sent from another process."""
    return from_bytes(Transfer, contents)


def _matrices_of(contents: bytes, is_grid: bool) -> Matrices:
    """The matrices that were sent from another process."""
    return from_bytes(lambda path: Matrices(path, is_grid), contents)
