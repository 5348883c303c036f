"""Arrays as the kernels take them, and what is said of arrays that are none."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

Numbers = npt.NDArray[Any]
Doubles = npt.NDArray[np.float64]

NATIVE = (np.dtype(np.float64), np.dtype(np.float32))
"""What the kernels read as it is."""

MAX_ORDER = 256
"""Bands at most of the functions of this package."""

MAX_SIDE = 32768
"""Texels at most along a side of a map that is made."""


def numbers(values: npt.ArrayLike, what: str) -> Numbers:
    """An array of float32 or float64; integers become float64, and anything else is a TypeError. Numbers that lie across the words of
    memory, as those of packed records and of files mapped at an odd place, are copied."""
    given: Any = values
    if type(given) is np.ndarray and given.dtype in NATIVE and given.flags.aligned:
        known: Numbers = given
        return known
    if hasattr(given, "__dlpack__") and not isinstance(given, np.ndarray):
        try:
            given = np.from_dlpack(given)
        except (BufferError, RuntimeError, TypeError, ValueError) as error:
            text = " ".join(str(error).split())
            raise TypeError(f"{what}: expected a tensor of float32 or float64 in the memory of the processor: {text}") from None
    if isinstance(given, np.ma.MaskedArray):
        raise TypeError(f"{what}: expected an array, found a masked one: fill it, with `filled(value)`")
    array = np.asarray(given)
    if array.dtype.kind in "iu":
        array = array.astype(np.float64)
    if array.dtype.kind != "f" or array.dtype.itemsize not in (4, 8):
        raise TypeError(f"{what}: expected numbers of float32 or float64, found {array.dtype}")
    # In the order of bytes of this machine and at whole words, as the kernels read them.
    return np.require(array, array.dtype.newbyteorder("="), "A")


def order_of(count: int, what: str) -> int:
    """The order n of n² coefficients."""
    order = math.isqrt(count)
    if order * order != count or not 1 <= order <= MAX_ORDER:
        raise ValueError(f"{what}: expected n² coefficients for an order n of 1 to {MAX_ORDER}, found {count}")
    return order


def vectors(values: npt.ArrayLike) -> Numbers:
    """Vectors of shape (..., 3), of any length."""
    array = numbers(values, "directions")
    if array.ndim == 0 or array.shape[-1] != 3:
        raise ValueError(f"directions: expected an array of shape (..., 3), found {array.shape}")
    return array


def points(values: npt.ArrayLike, what: str) -> tuple[Doubles, tuple[int, ...]]:
    """Places of shape (m, 3), and the shape without the last axis that they had."""
    array = numbers(values, what).astype(np.float64, copy=False)
    if array.ndim == 0 or array.shape[-1] != 3:
        raise ValueError(f"{what}: expected an array of shape (..., 3), found {array.shape}")
    return np.ascontiguousarray(finite(array, what).reshape(-1, 3)), array.shape[:-1]


def directions(values: npt.ArrayLike) -> tuple[Doubles, tuple[int, ...]]:
    """Unit vectors of shape (m, 3), and the shape without the last axis that they had."""
    array = vectors(values).astype(np.float64, copy=False)
    lengths = np.linalg.norm(array, axis=-1, keepdims=True)
    if not np.all((lengths > 0) & np.isfinite(lengths)):
        raise ValueError("directions: expected vectors with a length, found one that is zero or not finite")
    unit = np.ascontiguousarray((array / lengths).reshape(-1, 3))
    return unit, array.shape[:-1]


def rotation_matrix(values: npt.ArrayLike) -> list[list[float]]:
    """A matrix of three rows."""
    array = numbers(values, "rotation").astype(np.float64, copy=False)
    if array.shape != (3, 3):
        raise ValueError(f"rotation: expected a matrix of shape (3, 3), found {array.shape}")
    rows: list[list[float]] = array.tolist()
    return rows


def finite(values: Numbers, what: str) -> Numbers:
    """An array whose numbers are all finite."""
    if not np.isfinite(values).all():
        place = tuple(int(k) for k in np.argwhere(~np.isfinite(values))[0])
        raise ValueError(f"{what}: expected finite numbers, found {values[place]} at {place}")
    return values


def as_asked(array: Numbers, dtype: Any, copy: bool | None) -> Numbers:
    """What `__array__` gives: the array itself where it may, and a `ValueError` where it must and cannot."""
    found = array if dtype is None else array.astype(dtype, copy=False)
    if copy is False and found is not array:
        raise ValueError(f"the numbers are {array.dtype}: as {np.dtype(dtype)} they are copied")
    return found.copy() if copy else found


def real(value: object, what: str, least: float, most: float = math.inf) -> float:
    """A finite number in a range."""
    if isinstance(value, bool) or not isinstance(value, (int, float, np.integer, np.floating)):
        raise TypeError(f"{what}: expected a number, found {value!r}")
    number = float(value)
    if not (math.isfinite(number) and least <= number <= most):
        bounds = f"{least} to {most}" if most < math.inf else f"a finite number of {least} or more"
        raise ValueError(f"{what}: expected {bounds}, found {value}")
    return number


def expect(value: object, kinds: type | tuple[type, ...], what: str, expected: str) -> None:
    """Refuses a value of another type."""
    if not isinstance(value, kinds):
        raise TypeError(f"{what}: expected {expected}, found {type(value).__name__}")


def whole(value: object, what: str, least: int, most: int) -> int:
    """An integer in a range."""
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)):
        raise TypeError(f"{what}: expected a whole number, found {value!r}")
    if not least <= int(value) <= most:
        raise ValueError(f"{what}: expected {least} to {most}, found {value}")
    return int(value)
