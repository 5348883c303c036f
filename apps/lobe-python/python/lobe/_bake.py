"""Bakes: what a scene does to light, at its vertices, for any light to come."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import TypedDict

import numpy as np
import numpy.typing as npt

from . import _lobe
from ._arrays import whole
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

    def __post_init__(self) -> None:
        if self.albedo not in ("vertex", "none"):
            raise ValueError(f"albedo: expected vertex or none, found {self.albedo!r}")
        for name, least, most in [("order", 1, 8), ("samples", 1, 1 << 24), ("bounces", 0, 255), ("seed", 0, 2**64 - 1)]:
            whole(getattr(self, name), name, least, most)

    def of(self, scene: Path) -> _lobe.Bake:
        """The bake of a scene."""
        o = asdict(self)
        demodulated = o.pop("albedo") == "none"
        return _lobe.Bake(scene, **o, demodulated=demodulated)


def bake(
    scene: Path,
    output: Path,
    options: BakeOptions | None = None,
    *,
    shard: tuple[int, int] | None = None,
    progress: Progress | None = None,
) -> BakeReport:
    """Bakes the transfer of a scene at its vertices, and writes a .glb or a .safetensors file: the bytes of `lobe bake`.

    `scene` is a file, or "built-in:still-life" or another scene of Lobe. Results are kept beside the output while they are found: a bake that was
    stopped, by Ctrl-C or by what `progress(done, total)` raises, goes on from there. With `shard=(i, n)` part i of n is baked, from 1 on,
    and written as a .safetensors file, which `merge` puts together with the others.
    """
    made = (options or BakeOptions()).of(scene)
    if shard is None:
        report: BakeReport = made.write(output, progress)
        return report
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
        if light.shape:
            raise ValueError(f"light: expected one function, found a batch of shape {light.shape}")
        c = light.resized(self.order).coefficients.astype(np.float64)
        colors = np.ascontiguousarray(c if light.is_color else np.repeat(c[:, None], 3, axis=1))
        return self._transfer.exit_radiance(colors)
