"""Coefficients as other libraries and engines keep them."""

from __future__ import annotations

import math
import os
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from . import _lobe
from ._arrays import Doubles, Numbers, expect

Convention = Literal[
    "pyshtools",
    "pyshtools-phase",
    "pyshtools-orthonormal",
    "pyshtools-schmidt",
    "pyshtools-unnormalized",
    "pyshtools-complex",
    "pyshtools-quantum",
    "shtns",
    "shtns-4pi",
    "shtns-schmidt",
    "shtns-schmidt-no-phase",
    "healpy",
    "scipy",
    "sphericart",
    "e3nn",
    "e3nn-component",
    "e3nn-norm",
    "ambix",
    "ambisonics-n3d",
    "fuma",
]
"""A convention of coefficients, of `lobe.CONVENTIONS`."""

EngineForm = Literal["three", "babylon", "playcanvas", "filament", "godot", "unity", "unreal", "cesium"]
"""The form in which an engine keeps nine colors of a light."""

CONVENTIONS: dict[str, str] = {
    name: f"{description}; tried with {tried}" for name, description, tried in _lobe.conventions()
}
"""The conventions of `Sh.to_convention`: what each is, and the library and version that it was tried with."""


def encoded(rows: Doubles, name: str, shape: tuple[int, ...]) -> Numbers:
    """Functions of shape (rows, n²) or (rows, n², 3), whose batch has the shape given, as a library keeps them."""
    expect(name, str, "convention", "a name such as pyshtools")
    values = _lobe.to_convention(rows, name)
    return values.reshape(shape + values.shape[1:])


def decoded(array: npt.ArrayLike, name: str, color: bool | None) -> Doubles:
    """The coefficients, (..., n²) or (..., n², 3), of an array of a library."""
    expect(name, str, "convention", "a name such as pyshtools")
    given = np.asarray(array)
    if given.dtype.kind not in "iufc" or given.dtype.itemsize > 16:
        raise TypeError(f"array: expected real or complex numbers, found {given.dtype}")
    axes = _lobe.convention_axes(name)
    if given.ndim < axes:
        raise ValueError(f"array: expected {axes} axes or more for {name}, found an array of shape {given.shape}")
    before = given.shape[: given.ndim - axes]
    is_color = bool(before) and before[-1] == 3 if color is None else bool(color)
    if is_color and before[-1:] != (3,):
        found = f"found an array of shape {given.shape}"
        raise ValueError(f"array: expected an axis of three colors before the axes of {name}, {found}")
    batch = before[:-1] if is_color else before
    rows: npt.NDArray[Any] = np.ascontiguousarray(given, dtype=np.complex128)
    values = _lobe.from_convention(rows.reshape((math.prod(batch), *given.shape[len(batch) :])), name, is_color)
    return values.reshape(batch + values.shape[1:])


def import_coefficients(path: str | os.PathLike[str], form: EngineForm) -> Doubles:
    """The radiance, (9, 3), whose nine colors a file holds in the form of an engine."""
    expect(form, str, "form", "the name of an engine")
    return _lobe.import_coefficients(path, form)
