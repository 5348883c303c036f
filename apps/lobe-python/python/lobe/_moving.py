"""Scenes that move: their moments under light from everywhere, by transfer of their parts, and path traced."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from . import _lobe
from ._arrays import expect, real, whole
from ._bake import asked_of, expect_parts, expect_shard
from ._camera import Background, Camera, Picture, Suns, Traced, background_of, checked, lighting_of, merged, picture_of, size_of, tracing_of
from ._env import EnvMap
from ._option_fields import MovingFields
from ._scene import Path, Progress, Scene
from ._sh import Sh


@dataclass(frozen=True)
class MovingOptions(MovingFields):
    """How parts that move are baked and shaded, as by `lobe render moving`. An option that is out of its range, or excludes another, is refused when
    they are made."""

    order: int | None = None
    """Number of bands, 1 to 8; None: as many as what is baked already has, else 4."""

    def __post_init__(self) -> None:
        if self.order is not None:
            whole(self.order, "order", 1, 8)
        _lobe.check_moving(self.asked())

    def asked(self) -> dict[str, Any]:
        """The options that are not left at their defaults, without the order."""
        return {name: value for name, value in asked_of(self).items() if name != "order"}


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
        scene = Scene.of(scene)
        if scene.time or scene.animation is not None:
            raise ValueError("time and animation of the scene: what moves is shown at any time; give the animation here")
        name = None if animation is None else str(animation)
        self._moving = _lobe.Moving.load(scene, name, self.options.asked(), self.options.order, bool(loop))
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
        self._order = self._moving.bake(self.options.asked(), self.options.order, checkpoint, progress)
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
        suns: Suns = "auto",
        progress: Progress | None = None,
    ) -> Picture:
        """A moment, in seconds, under light from everywhere: radiance of shape (height, width, 3), row 0 on top, as by `lobe render`.

        `rays`, `background` and `suns` are those of `lobe.render`. A camera without an eye sees all of the scene at this time.
        """
        view = checked(light, camera)._view()
        size, seconds, count = size_of(width, height), _seconds(time), whole(rays, "rays", 1, 64)
        order = self.bake(progress=progress) if self._order is None else self._order
        lighting, behind = lighting_of(light, order, suns), background_of(background)
        return self._moving.render(seconds, lighting, behind, view, size, count, progress)

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
