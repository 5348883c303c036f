"""Scenes that move: their moments under light from everywhere, by transfer of their parts, and path traced."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass

import numpy as np

from . import _lobe
from ._arrays import expect, real, whole
from ._bake import expect_parts, expect_shard
from ._camera import Background, Camera, Picture, Traced, background_of, checked, colors_of, merged, picture_of, size_of, tracing_of
from ._env import EnvMap
from ._scene import Path, Progress, Scene
from ._sh import Sh


@dataclass(frozen=True)
class MovingOptions:
    """How parts that move are baked and shaded, as by `lobe render moving`."""

    method: str = "fields"
    """How parts hide the sky from each other: fields, by precomputed shadow fields, or by spheres where they change their shape; exponentials, by spheres
    alone, as exponentials of sums: less to bake."""
    order: int | None = None
    """Number of bands, 1 to 8; None: as many as what is baked already has, else 4."""
    samples: int | None = None
    """Paths from each vertex where a part is not baked yet; None: 1024, or up to 4096 where their noise is above 2 %."""
    bounces: int | None = None
    """Reflections within each part; None: 3, or those of the file."""
    exponential: str = "grid"
    """Of exponentials: grid, optimal-linear, hybrid or hybrid:NORM."""
    spheres: int | None = None
    """Spheres fitted to each part that is deformed, and with exponentials to each that moves, 1 to 4096; None: 64 and 16."""
    sphere_bounce: bool = False
    """Light that spheres send on, one bounce."""
    sphere_window: float | None = None
    """The width of a window on what single spheres leave visible, in bands."""
    interpolation: str = "linear"
    """Of fields between their spheres: linear has kinks that a moving shadow shows, cubic has none for twice the reads."""
    group: int = 0
    """Vertices, a multiple of 16, for which spheres far away are summed once; 0: for each vertex."""
    still_points: int = 4096
    """Points of the grid at which it is found how much of the sky the parts that stand still leave to those that move, 8 or more; 0: they
    hide nothing from them, and only receive shadows."""
    split: bool = True
    """Whether triangles of what stands still are split first, where shadows of what moves fall and where transfer is off."""
    max_vertices: int | None = None
    """The most vertices that this may leave; None: four times those of the scene, at least 20000."""

    def __post_init__(self) -> None:
        if self.method not in ("fields", "exponentials"):
            raise ValueError(f"method: expected fields or exponentials, found {self.method!r}")
        if self.exponential != "grid" and self.method != "exponentials":
            raise ValueError("exponential: only of the method exponentials")
        if self.exponential.partition(":")[0] not in ("grid", "optimal-linear", "hybrid"):
            raise ValueError(f"exponential: expected grid, optimal-linear or hybrid[:NORM], found {self.exponential!r}")
        for name, least, most in [("order", 1, 8), ("samples", 1, 1 << 20), ("bounces", 0, 255), ("spheres", 1, 4096)]:
            if getattr(self, name) is not None:
                whole(getattr(self, name), name, least, most)
        for name, least, most in [("group", 0, 4096), ("still_points", 0, 1 << 24)]:
            whole(getattr(self, name), name, least, most)
        if self.max_vertices is not None:
            whole(self.max_vertices, "max_vertices", 1, (1 << 32) - 1)
            if not self.split:
                raise ValueError("max_vertices: nothing is split with split=False")
        if self.group % 16:
            raise ValueError(f"group: expected a multiple of 16, found {self.group}")
        if 0 < self.still_points < 8:
            raise ValueError(f"still_points: expected 0, or 8 at least, found {self.still_points}")
        if self.sphere_window is not None and real(self.sphere_window, "sphere_window", 0.0) == 0.0:
            raise ValueError("sphere_window: expected a width above 0, found 0")


class MovingScene:
    """A scene whose parts move: an animated glTF file, a scene description (.json), or "built-in:three-objects" or "built-in:walking-figure".

    What `lobe bake`, `field` and `spheres` have not made before of its parts is baked by the first picture, or by `bake`. One picture at a time
    is made of a scene; others wait.
    """

    def __init__(
        self,
        scene: Path | Scene,
        options: MovingOptions | None = None,
        *,
        animation: str | int | None = None,
        loop: bool = False,
    ) -> None:
        """`animation` is that of a glTF file, by name or number [default: the first]. With `loop` it begins anew at its end, where it rests otherwise."""
        expect(options, (MovingOptions, type(None)), "options", "MovingOptions")
        expect(animation, (str, int, type(None)), "animation", "a name or a number")
        self.options = options or MovingOptions()
        name = None if animation is None else str(animation)
        asked = (self.options.order, self.options.bounces)
        scene = Scene.of(scene)
        if scene.time or scene.animation is not None:
            raise ValueError("time and animation of the scene: what moves is shown at any time; give the animation here")
        self._moving = _lobe.Moving.load(scene, name, bool(loop), asked)
        self._order: int | None = None

    @property
    def span(self) -> tuple[float, float]:
        """The times, in seconds, between which it moves; both 0 if nothing does."""
        begin, end = self._moving.span
        return begin, end

    @property
    def parts(self) -> list[str]:
        """The names of its parts; what stands still is mostly one."""
        return self._moving.parts()

    def bounds(self, time: float = 0.0) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
        """Two corners of the box around it at a time, in seconds."""
        low, high = self._moving.bounds(_seconds(time))
        return (low[0], low[1], low[2]), (high[0], high[1], high[2])

    def bake(self, *, checkpoint: Path | None = None, progress: Progress | None = None) -> int:
        """Bakes what the parts lack, which may take minutes; the order. Needs not be called twice.

        With `checkpoint` results are kept in files whose names begin with it, one for each part: what was stopped goes on from there, and another scene of the same
        file and options takes no time. They are those of `lobe render`, whose checkpoint is the name of its output with ".checkpoint"
        appended. Ctrl-C and what `progress(done, total)` raises stop it, which is called for one part after the other.
        """
        self._order = self._moving.bake(asdict(self.options), checkpoint, progress)
        return self._order

    def render(
        self,
        light: EnvMap | Sh,
        time: float = 0.0,
        *,
        camera: Camera | None = None,
        width: int = 512,
        height: int = 384,
        rays: int = 2,
        background: Background = "env",
        progress: Progress | None = None,
    ) -> Picture:
        """A moment, in seconds, under light from everywhere: radiance of shape (height, width, 3), row 0 on top, as by `lobe render`.

        `rays` and `background` are those of `lobe.render`. A camera without an eye sees all of the scene at this time.
        """
        view = checked(light, camera)._view()
        size, seconds, count = size_of(width, height), _seconds(time), whole(rays, "rays", 1, 64)
        order = self.bake(progress=progress) if self._order is None else self._order
        source, behind = light._map if isinstance(light, EnvMap) else None, background_of(background)
        colors = colors_of(light.project(order) if isinstance(light, EnvMap) else light)
        return self._moving.render(seconds, colors, source, behind, view, size, count, progress)

    def trace(
        self,
        light: EnvMap | Sh,
        time: float = 0.0,
        *,
        camera: Camera | None = None,
        width: int = 512,
        height: int = 384,
        samples: int = 64,
        bounces: int = 3,
        seed: int = 0,
        surfaces: str = "matte",
        background: Background = "env",
        merge: Sequence[Path] = (),
        progress: Progress | None = None,
    ) -> Traced:
        """A moment path traced, with the lamps of the scene: the truth beside `render`. Options are those of `lobe.trace`; nothing is baked for it."""
        asked = tracing_of(light, camera, width, height, samples, bounces, seed, surfaces, background)
        with merged(expect_parts(merge)) as share:
            return picture_of(self._moving.trace(_seconds(time), *asked, share, progress))

    def trace_shard(
        self,
        light: EnvMap | Sh,
        output: Path,
        shard: tuple[int, int],
        time: float = 0.0,
        *,
        camera: Camera | None = None,
        width: int = 512,
        height: int = 384,
        samples: int = 64,
        bounces: int = 3,
        seed: int = 0,
        surfaces: str = "matte",
        background: Background = "env",
        progress: Progress | None = None,
    ) -> None:
        """A shard of `trace`, as by `lobe.trace_shard`."""
        asked = tracing_of(light, camera, width, height, samples, bounces, seed, surfaces, background)
        self._moving.trace(_seconds(time), *asked, (output, expect_shard(shard)), progress)


def _seconds(time: object) -> float:
    return real(time, "time", -np.inf)
