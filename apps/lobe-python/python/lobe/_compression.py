"""Transfer in fewer or shorter numbers: clustered principal components, 16 bits, and zonal lobes for surfaces that bend."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypedDict

from . import _lobe
from ._arrays import whole
from ._bake import MAX_CLUSTERS, MAX_COMPONENTS, CompressReport, expect_bits
from ._scene import Path, Progress

MAX_LOBES = 8


class CompressedReport(CompressReport):
    """What `compress` tells of its work."""

    receivers: int


class HalvesReport(TypedDict):
    """What `compress_f16` tells of its work."""

    receivers: int
    relative_error: float
    """The root of the squared differences of all coefficients over their squares."""
    bytes_before: int
    bytes: int
    ratio: float


class LobesReport(TypedDict):
    """What `fit_lobes` tells of its work."""

    receivers: int
    lobes: int
    squared_error: float
    """The squared differences of all coefficients, summed."""
    relative_error: float
    """The root of that over the squares of the coefficients."""
    worst_relative_error: float
    """The same of the receiver where it is largest."""
    bytes: int


@dataclass(frozen=True)
class CurvePoint:
    """The error of compressed transfer for numbers of clusters and components."""

    clusters: int
    components: int
    squared_error: float
    relative_error: float
    bytes: int
    """With weights of 16 bits."""


def compress(
    input: Path,
    output: Path,
    *,
    clusters: int = 64,
    components: int = 8,
    weights: int = 16,
    progress: Progress | None = None,
) -> CompressedReport:
    """Compresses transfer by clustered principal components, and writes the bytes of `lobe compress`, a .safetensors file.

    `input` is a baked .glb, or transfer alone in a .safetensors file. There are up to `clusters` clusters of receivers, 1 to 65536, of which 1 gives ordinary principal
    components; and `components` in each, 0 to 192, of which 0 gives vector quantization. A weight has 8, 16 or 32 bits. Ctrl-C and what
    `progress(done, total)` raises stop it.
    """
    numbers = (whole(clusters, "clusters", 1, MAX_CLUSTERS), whole(components, "components", 0, MAX_COMPONENTS), expect_bits(weights))
    report: CompressedReport = _lobe.compress(input, output, numbers, progress)
    return report


def compress_f16(input: Path, output: Path) -> HalvesReport:
    """Rounds all coefficients of transfer to 16 bits, and writes the bytes of `lobe compress --f16`, a .safetensors file.

    `input` is that of `compress`. Coefficients of 65520 or more are refused.
    """
    report: HalvesReport = _lobe.compress_f16(input, output)
    return report


def error_curve(
    input: Path,
    clusters: Sequence[int] = (1, 4, 16, 64),
    components: Sequence[int] = (0, 1, 2, 4, 8),
    *,
    progress: Progress | None = None,
) -> list[CurvePoint]:
    """The errors of `compress` for all pairs of numbers of clusters and components, as `lobe compress --curve` prints them."""
    rows = [whole(count, "clusters", 1, MAX_CLUSTERS) for count in clusters]
    columns = [whole(count, "components", 0, MAX_COMPONENTS) for count in components]
    return [CurvePoint(*point) for point in _lobe.error_curve(input, rows, columns, progress)]


def fit_lobes(
    input: Path, output: Path, *, lobes: int = 1, closed_form: bool = False, progress: Progress | None = None
) -> LobesReport:
    """Fits zonal lobes to transfer, which turn with a surface that bends, and writes the bytes of `lobe fit-lobes`, a .safetensors file.

    `input` is that of `compress`. Each receiver has 1 to 8 `lobes`; with `closed_form` the axis of a single one is the optimal linear direction, else it is
    searched. Ctrl-C and what `progress(done, total)` raises stop it.
    """
    count = whole(lobes, "lobes", 1, MAX_LOBES)
    report: LobesReport = _lobe.fit_lobes(input, output, count, bool(closed_form), progress)
    return report
