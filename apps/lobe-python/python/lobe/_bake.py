"""Bakes: what a scene does to light, at its vertices, its texels or points in space, for any light to come."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any, TypedDict

import numpy as np
import numpy.typing as npt

from . import _lobe
from ._arrays import Doubles, expect, points, whole
from ._carried import bytes_of, from_bytes
from ._option_fields import BakeFields
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
class BakeOptions(BakeFields):
    """Options of a bake, as of `lobe bake`. An option that is out of its range, or excludes another, is refused when they are made."""

    def __post_init__(self) -> None:
        _lobe.check_bake(self.asked())

    @staticmethod
    def like(path: Path) -> BakeOptions:
        """The options of the bake that made a file: a baked .glb, a .safetensors file of transfer, or an .exr picture of texels. How its
        scene was read is not among them."""
        names = {field.name for field in fields(BakeOptions)}
        found = {name: json.loads(text) for name, text in _lobe.bake_like(os.fspath(path))}
        options: dict[str, Any] = {name: tuple(value) if isinstance(value, list) else value for name, value in found.items() if name in names}
        return BakeOptions(**options)

    def asked(self) -> dict[str, Any]:
        """The options that are not left at their defaults."""
        return asked_of(self)

    def job(self, scene: Path | Scene, **others: Any) -> dict[str, Any]:
        """All that is asked of a bake: of this scene, with other options of the job, such as its output."""
        return Scene.of(scene)._job() | self.asked() | others

    def of(self, scene: Path | Scene) -> _lobe.Bake:
        """The bake of a scene in shards, which is read and split at once."""
        return _lobe.Bake(self.job(scene))


def asked_of(options: Any) -> dict[str, Any]:
    """The options of a dataclass that are not left at their defaults."""
    all_of_them = [(field.name, getattr(options, field.name), field.default) for field in fields(options)]
    return {name: value for name, value, default in all_of_them if not _is_default(value, default)}


def _is_default(value: object, default: object) -> bool:
    if value is None or default is None:
        return value is default
    return isinstance(value, (str, bool, int, float)) and type(value) is type(default) and value == default


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
    fresh: bool = False,
    progress: Progress | None = None,
) -> BakeReport:
    """Bakes the transfer of a scene, and writes the bytes of `lobe bake`: a .glb of transfer at vertices, a .safetensors file of any, an .exr of
    texels.

    `scene` is a file, which `Scene` tells how to read, or "built-in:still-life" or another scene of Lobe. Results are kept beside the output while they are found: a bake that was
    stopped, by Ctrl-C or by what `progress(done, total)` raises, goes on from there, unless it is to start `fresh`. With `shard=(i, n)` part i of n is baked, from 1 on,
    and written as a .safetensors file, which `merge` puts together with the others.
    """
    options = options or BakeOptions()
    others: dict[str, Any] = {} if shard is None else {"shard": "{}/{}".format(*expect_shard(shard))}
    report: BakeReport = _lobe.bake(options.job(scene, output=output, fresh=fresh, **others), progress)
    return report


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
    options = options or BakeOptions()
    report: BakeReport = _lobe.bake(options.job(scene, output=output, merge=expect_parts(parts)), progress)
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
