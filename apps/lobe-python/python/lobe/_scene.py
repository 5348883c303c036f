"""Scenes as inputs: files, and how they are read."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from typing import Any

from . import _lobe
from ._arrays import expect, whole

Path = str | os.PathLike[str]
Progress = Callable[[int, int], object]


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
        expect(self.animation, (str, int, type(None)), "animation", "a name or a number")
        if isinstance(self.animation, int):
            object.__setattr__(self, "animation", str(self.animation))
        if self.max_bytes is not None:
            whole(self.max_bytes, "max_bytes", 1, 2**63)
        _lobe.check_scene(self._asked())
        if (self.time or self.animation is not None) and not name.lower().endswith((".glb", ".gltf", ".vrm")):
            raise ValueError("time and animation: only what a glTF file moves stands elsewhere then")

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

    def _job(self) -> dict[str, Any]:
        """The same, and the limit of memory, as options of a job."""
        # Without a limit any memory may be taken.
        limit = sys.float_info.max if self.max_bytes is None else self.max_bytes / 2**30
        return self._asked() | {"max_memory": limit}

    def _asked(self) -> dict[str, Any]:
        """The options that are not left at their defaults, as the library names them."""
        given = {field.name: getattr(self, field.name) for field in fields(self) if field.name not in ("path", "max_bytes")}
        return {name: value for name, value in given.items() if value != getattr(Scene, name)} | {"scene": os.fspath(self.path)}
