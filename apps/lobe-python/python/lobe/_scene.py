"""Scenes as inputs: files, and how they are read."""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from dataclasses import dataclass, fields, replace

from ._arrays import expect, whole

Path = str | os.PathLike[str]
Progress = Callable[[int, int], object]

MAX_TRIANGLES = (1 << 31) - 1
"""The most triangles that rays can be traced among."""


@dataclass(frozen=True)
class Scene:
    """A scene's file, and how it is read: wherever a scene is expected, a path alone is read as by the defaults here, which are those of the command."""

    path: Path
    """A .glb, .gltf, .vrm, .obj or .ply file, or "built-in:NAME"; of what moves also a scene description (.json)."""
    up: str = "y"
    """Which axis points up in an .obj or .ply file, y or z."""
    missing_normals: str | None = None
    """The normals of meshes without any: "flat", of their triangles, which takes more vertices, or "smooth"; None: flat of glTF, as it asks, and
    smooth of .ply and of .obj without smoothing groups."""
    default_material: str = "white"
    """The material of glTF meshes without any: "white", matte and double-sided, or "gltf", a single-sided white metal, on which transfer is black."""
    allow_outside: bool = False
    """The file is trusted: it may name others outside of its folder, which are read and may be copied into an output."""
    transparency: bool = False
    """Light goes straight through blended surfaces of a glTF file, by their alpha, and through glass, by its transmission."""
    time: float | None = None
    """What a glTF file moves, by animations, skins or morph targets, stands as at this time, in seconds; by default 0."""
    animation: str | int | None = None
    """The animation of a glTF file, by name or number; None: the first."""
    max_triangles: int | None = None
    """The most triangles, and the most vertices, that the file may hold, its instances counted [default: 67108864]."""
    max_texels: int | None = None
    """The most texels that all textures together may have [default: 268435456]."""
    max_bytes: int | None = None
    """The most bytes that the scene may take while it is read and traced; None: any. Set it for files that are not trusted."""

    def __post_init__(self) -> None:
        name = os.fspath(self.path)
        expect(name, str, "path", "a str or a path")
        is_gltf = name.lower().endswith((".glb", ".gltf", ".vrm"))
        leaves_up_open = name.lower().endswith((".obj", ".ply"))
        for value, what, allowed in [
            (self.up, "up", ("y", "z")),
            (self.missing_normals, "missing_normals", (None, "flat", "smooth")),
            (self.default_material, "default_material", ("white", "gltf")),
        ]:
            if value not in allowed:
                raise ValueError(f"{what}: expected {' or '.join(name for name in allowed if name)}, found {value!r}")
        for most, what, limit in [
            (self.max_triangles, "max_triangles", MAX_TRIANGLES),
            (self.max_texels, "max_texels", 2**60),
            (self.max_bytes, "max_bytes", 2**63),
        ]:
            if most is not None:
                whole(most, what, 1, limit)
        expect(self.time, (int, float, type(None)), "time", "a number of seconds")
        if self.time is not None and not math.isfinite(self.time):
            raise ValueError(f"time: expected a finite number of seconds, found {self.time!r}")
        expect(self.animation, (str, int, type(None)), "animation", "a name or a number")
        if isinstance(self.animation, int):
            object.__setattr__(self, "animation", str(self.animation))
        for is_refused, why in [
            ((self.time or self.animation is not None) and not is_gltf, "time and animation: only what a glTF file moves stands elsewhere then"),
            (self.up != "y" and not leaves_up_open, "up: only .obj and .ply files leave open which axis points up"),
            (self.default_material != "white" and not is_gltf, "default_material: only of glTF files, which say what a mesh without a material is"),
            (name.startswith("built-in:") and self._has_options(), "options: only of scenes in files"),
        ]:
            if is_refused:
                raise ValueError(why)

    @staticmethod
    def of(scene: Path | Scene) -> Scene:
        """The scene, of a path with the defaults."""
        if isinstance(scene, Scene):
            return scene
        if not isinstance(scene, (str, os.PathLike)):
            raise TypeError(f"scene: expected the path of a file or a lobe.Scene, found {type(scene).__name__}")
        return Scene(scene)

    @property
    def name(self) -> str:
        """The path as text."""
        return os.fspath(self.path)

    def at(self, path: Path) -> Scene:
        """The same under another path."""
        return replace(self, path=os.fspath(path))

    def _has_options(self) -> bool:
        return any(getattr(self, field.name) != field.default for field in fields(self) if field.name != "path")
