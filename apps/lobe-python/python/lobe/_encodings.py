"""Irradiance in a few numbers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _lobe
from ._arrays import Doubles, directions, finite


@dataclass(frozen=True)
class EncodingError:
    """How far an encoding is from the irradiance, over normals that cover the sphere evenly; errors in units of the mean irradiance."""

    name: str
    floats: int
    """Numbers for all channels; a direction counts as three."""
    is_hemispherical: bool
    """Whether it serves the normals on one side of a surface only; its errors are means over 32 surfaces."""
    mean: float
    rms: float
    max: float
    lowest: float
    """The lowest irradiance, in its own unit: negative if the encoding rings."""


class Encoded:
    """Irradiances in one encoding; see `Sh.encode`."""

    def __init__(self, name: str, inner: _lobe.Encoded, shape: tuple[int, ...], is_color: bool, made_of: tuple[Any, ...]) -> None:
        self._name, self._inner, self._shape, self._is_color = name, inner, shape, is_color
        self._made_of = made_of

    def __reduce__(self) -> tuple[Any, ...]:
        return encode, self._made_of

    @property
    def name(self) -> str:
        """The name of the encoding."""
        return self._name

    @property
    def shape(self) -> tuple[int, ...]:
        """The shape of the batch."""
        return self._shape

    @property
    def numbers(self) -> dict[str, Doubles]:
        """What is kept, by name: coefficients and colors of shape (...) or (..., 3), directions (..., 3)."""
        return {
            name: values.reshape(self._shape if values.shape[-1] == 1 else (*self._shape, values.shape[-1]))
            for name, values in self._inner.numbers()
        }

    def eval(self, n: npt.ArrayLike) -> Doubles:
        """Irradiance for normals of shape (..., 3), of any length above zero: (batch, ...), for colors (batch, ..., 3)."""
        unit, shape = directions(n)
        values = self._inner.eval(unit)
        return values.reshape(self._shape + shape + ((3,) if self._is_color else ()))

    def __repr__(self) -> str:
        batch = f"{self._shape}, " if self._shape else ""
        return f"Encoded({batch}{self._name}{', rgb' if self._is_color else ''})"


def encode(
    c: Doubles, order: int, name: str, normal: npt.ArrayLike, over_pi: bool, up: str, shape: tuple[int, ...]
) -> Encoded:
    """Irradiances of shape (rows, n²) or (rows, n², 3), whose batch has the shape given, in an encoding."""
    finite(c, "coefficients")
    unit, of_normal = directions(normal)
    if of_normal:
        raise ValueError(f"normal: expected one vector, found an array of shape {np.shape(normal)}")
    if up not in ("y", "z"):
        raise ValueError(f"up: expected y or z, found {up!r}")
    settings = {"name": name, "normal": unit[0].tolist(), "over_pi": bool(over_pi), "up_is_y": up == "y"}
    # Copies: the caller may write to its arrays.
    made_of = (np.array(c), order, name, np.array(normal), over_pi, up, shape)
    return Encoded(name, _lobe.encode(c, order, settings), shape, c.ndim == 3, made_of)
