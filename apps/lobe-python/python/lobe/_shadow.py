"""Occluders and lamps that move: occlusion fields, sets of spheres, and the light of lamps, as the command writes them to files."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, TypedDict

import numpy as np
import numpy.typing as npt

from . import _lobe
from ._arrays import Doubles, expect, finite, numbers, real, whole
from ._bake import expect_parts, expect_shard
from ._scene import Path, Progress, Scene

MAX_PATCHES = 64
"""A limit as of the command, beyond which a number is taken for a typing error."""


class FieldReport(TypedDict):
    """What `field` tells of its work."""

    points: int
    """Sample points."""
    inside: int
    """Those inside the solid."""
    rays: int
    bytes: int
    """Of the numbers as they are stored, and in single precision."""
    bytes_before: int
    relative_error: float
    """Of storage: the root of the sum of squared differences over that of squares."""
    largest_error: float


def field(
    scene: Path | Scene,
    output: Path,
    *,
    entity: str | None = None,
    order: int = 4,
    spheres: int = 16,
    cells: int = 16,
    range: tuple[float, float] = (0.25, 8.0),
    rays: int = 1024,
    seed: int = 0,
    storage: str = "f32",
    merge: Sequence[Path] = (),
    progress: Progress | None = None,
) -> FieldReport:
    """Bakes the occlusion field of an entity, and writes the bytes of `lobe field`: how much of the sky it hides from the places around it.

    `scene`, a file or "built-in:ball" or another scene of Lobe, is the entity; or with `entity` a mesh of it, or a node of a glTF file, by name or number, in
    its own frame and in the shape that its skin was bound to. Sample points lie on `spheres` concentric spheres, 2 or more, whose
    radii are `range` in radii of the entity, at the corners of `cells` by `cells` cells of an octahedral grid, an even number.
    `storage` is f32, f16, u8 or clustered. Results are kept beside the output, a .safetensors file, while they are found: what was stopped, by Ctrl-C or by
    what `progress(done, total)` raises, goes on from there. `merge` takes them from all files that `field_shard` wrote with the same options.
    """
    asked = _asked(scene, output, entity) | _sampling(order, spheres, cells, range) | {"rays": rays, "seed": seed, "storage": storage}
    found = _lobe.field(asked | {"merge": expect_parts(merge) or None}, progress)
    report: FieldReport = found.pop("storage") | found
    return report


def field_shard(
    scene: Path | Scene,
    output: Path,
    shard: tuple[int, int],
    *,
    entity: str | None = None,
    order: int = 4,
    spheres: int = 16,
    cells: int = 16,
    range: tuple[float, float] = (0.25, 8.0),
    rays: int = 1024,
    seed: int = 0,
    progress: Progress | None = None,
) -> tuple[int, int]:
    """Bakes part i of n of the sample points of `field`, `shard=(i, n)` from 1 on, and writes them as a .safetensors file, as by `lobe field --shard`:
    how many they are, and how many in all.

    What was stopped goes on from its file. `field(.., merge=files)` makes the field of all.
    """
    asked = _asked(scene, output, entity) | _sampling(order, spheres, cells, range) | {"rays": rays, "seed": seed}
    found = _lobe.field(asked | {"shard": "{}/{}".format(*expect_shard(shard))}, progress)
    return found["points"], found["points_in_all"]


class VisibilityReport(TypedDict):
    """What `self_visibility` tells of its work."""

    vertices: int
    rays: int
    bytes: int
    """Of the numbers as they are stored, and in single precision."""
    bytes_before: int
    relative_error: float
    """Of storage: the root of the sum of squared differences over that of squares."""
    largest_error: float


def self_visibility(
    scene: Path | Scene,
    output: Path,
    *,
    entity: str | None = None,
    order: int = 4,
    rays: int = 1024,
    seed: int = 0,
    storage: str = "f32",
    progress: Progress | None = None,
) -> VisibilityReport:
    """Writes what each vertex sees of the sky past the entity itself, as `lobe field --self-visibility` does: by it the visibility that other entities leave is
    multiplied. With `rays` from each vertex. Of one `entity` as `field`, and kept, stopped and stored as that."""
    asked = _asked(scene, output, entity) | {"order": order, "rays": rays, "seed": seed, "storage": storage, "self_visibility": True}
    found = _lobe.field(asked, progress)
    report: VisibilityReport = found.pop("storage") | found
    return report


def _asked(scene: Path | Scene, output: Path | None, entity: str | None) -> dict[str, Any]:
    """What is asked of a job: of a scene, or of one entity of it."""
    expect(entity, (str, type(None)), "entity", "a name")
    return Scene.of(scene)._job() | {"output": output, "entity": entity}


def _sampling(order: int, spheres: int, cells: int, radii: object) -> dict[str, Any]:
    """The sample points of a field."""
    return {"order": order, "spheres": spheres, "cells": cells, "range": _pair(radii, "range")}


@dataclass(frozen=True)
class Spheres:
    """Spheres that stand for a mesh; see `spheres`."""

    centers: npt.NDArray[np.float32]
    """In the frame of the mesh, (k, 3)."""
    radii: npt.NDArray[np.float32]
    """(k,)."""
    outside_volume: float
    """The volumes of the spheres outside the solid, summed: where two overlap, it counts twice."""
    union_volume: float
    """The volume of the union of the spheres, where overlaps count once."""
    solid_volume: float
    """The volume of the solid."""
    history: Doubles
    """The first of them at the start and after each round."""
    certainty: float
    """The part of the mesh's box of which it is certain whether it is solid: below 0.9 the mesh is not closed."""


def spheres(
    scene: Path | Scene,
    count: int,
    output: Path | None = None,
    *,
    entity: str | None = None,
    method: str = "variational",
    points: int = 12288,
    rounds: int | None = None,
    seed: int = 0,
    progress: Progress | None = None,
) -> Spheres:
    """Fits spheres to the solid inside a mesh, as `lobe spheres` does: all of it is in some sphere, and little else.

    With `entity`, a mesh or a node of a glTF file by name or number, they are fitted to it in the shape that its skin was bound to, and the
    file has the joints that they follow. `method` is "variational", of `rounds` at most [default: 100], or "medial-axis", which is faster and worse. About
    `points` points of the solid have to be covered. With an output, a .safetensors file, its bytes are those of the command, and a
    variational fit that was stopped goes on from what is kept beside it.
    """
    asked = {"count": count, "method": method, "points": points, "rounds": rounds, "seed": seed}
    found = _lobe.spheres(_asked(scene, output, entity) | asked, progress)
    centers, radii, outside, union, solid, history, certainty = found
    return Spheres(centers, radii, outside, union, solid, np.array(history), certainty)


def sphere_table(output: Path, *, order: int = 4, window: float | None = None, clamp: float = 0.02) -> int:
    """Writes the table of what single spheres hide, as logarithms, as `lobe spheres table` does; its number of rows.

    `window` is the width of a window on the visibility, in bands; `clamp` the least eigenvalue of a logarithm as a part of the
    largest, above 0 to 1."""
    if window is not None and real(window, "window", 0.0) == 0.0:
        raise ValueError("window: expected a width above 0, found 0")
    if real(clamp, "clamp", 0.0, 1.0) == 0.0:
        raise ValueError("clamp: expected a number above 0, found 0")
    return _lobe.sphere_table(output, whole(order, "order", 1, 8), window, float(clamp))


def lamp(
    shape: str,
    output: Path,
    *,
    radius: float | None = None,
    size: tuple[float, float] | None = None,
    radiance: npt.ArrayLike = (1.0, 1.0, 1.0),
    pictures: Sequence[npt.ArrayLike] = (),
    patches: tuple[int, int] = (8, 8),
    fps: float = 24.0,
    two_sided: bool = False,
    order: int = 4,
    spheres: int = 16,
    cells: int = 16,
    range: tuple[float, float] = (0.25, 8.0),
    storage: str = "f32",
    progress: Progress | None = None,
) -> int:
    """Writes a lamp and its light at every point around it, as `lobe lamp` does: a .safetensors file; bytes of its numbers, in the `storage` of `field`.

    `shape` is "sphere", of a `radius` around the origin, or "rectangle", of a `size` along x and y around it, which shines towards +z. `radiance` is (3,). A
    rectangle may show `pictures`, (height, width, 3), to one who looks at it with x to the right and y up: in `patches` of one radiance along width and
    height, `fps` of them in a second, multiplied by `radiance`. `spheres`, `cells` and `range`, in half diagonals of the rectangle, are those of `field`.
    """
    if shape not in ("sphere", "rectangle"):
        raise ValueError(f"shape: expected sphere or rectangle, found {shape!r}")
    is_sphere = shape == "sphere"
    if is_sphere != (radius is not None) or is_sphere == (size is not None):
        raise ValueError(f"{shape}: expected a {'radius' if is_sphere else 'size'} alone")
    if is_sphere and (len(pictures) or two_sided):
        raise ValueError("pictures and two_sided: only of a rectangle")
    color = finite(numbers(radiance, "radiance").astype(np.float64, copy=False), "radiance")
    if color.shape != (3,):
        raise ValueError(f"radiance: expected three numbers, found an array of shape {color.shape}")
    settings = {
        "radiance": color.tolist(),
        "radius": None if radius is None else _above_zero(radius, "radius"),
        "size": None if size is None else [_above_zero(side, "size") for side in _pair(size, "size")],
        "two_sided": bool(two_sided),
        "patches": [whole(count, "patches", 1, MAX_PATCHES) for count in _pair(patches, "patches")],
        "fps": _above_zero(fps, "fps"),
    }
    tables = (_sampling(order, spheres, cells, range), {"storage": storage})
    return _lobe.lamp(output, settings, tables, [_shown(picture) for picture in pictures], progress)


def _shown(picture: npt.ArrayLike) -> npt.NDArray[np.float32]:
    """A picture mirrored, as the light goes out of it."""
    array = finite(np.asarray(numbers(picture, "picture"), dtype=np.float32), "picture")
    if array.ndim != 3 or array.shape[-1] != 3 or array.size == 0:
        raise ValueError(f"picture: expected an array of shape (height, width, 3), found {array.shape}")
    return np.ascontiguousarray(array[:, ::-1])


def _pair(values: object, what: str) -> tuple[object, object]:
    if not isinstance(values, (tuple, list, np.ndarray)) or len(values) != 2:
        raise ValueError(f"{what}: expected two numbers, found {values!r}")
    return values[0], values[1]


def _above_zero(value: object, what: str) -> float:
    number = real(value, what, 0.0)
    if number == 0.0:
        raise ValueError(f"{what}: expected a number above 0, found {value}")
    return number
