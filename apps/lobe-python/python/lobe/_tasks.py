"""What workers do. In a module of its own: a program's main module would be sent to them by value."""

from __future__ import annotations

import errno
import hashlib
import os
import platform
import re
import tempfile
from collections.abc import Callable
from dataclasses import asdict, dataclass
from threading import Lock
from typing import Any, TypeVar

from . import __version__, _lobe
from ._bake import BakeOptions
from ._scene import Scene
from ._shards import Cost, measured

Pilot = tuple[int, int, float]
"""What the pilot of a bake has found: bounces, paths, and an error."""

_read: dict[str, _lobe.Bake] = {}
"""The bake that this worker has had last, its scene read and its tree built."""

_reading = Lock()
"""Held while a scene is read: a worker of several threads reads it once, too."""


def identity_of(made: _lobe.Bake, scene: Scene, options: BakeOptions) -> str:
    """A name for this work, by all of the scene that decides it: shards of other work are not taken for its own."""
    digest = hashlib.blake2b(digest_size=8)
    digest.update(repr((__version__, sorted(asdict(options).items()), os.path.basename(scene.name), made.scene_hash)).encode())
    return digest.hexdigest()


def _read_once(
    sent: bytes | None, scene: Scene, options: dict[str, Any], identity: str, folder: str, pilot: Pilot | None = None
) -> _lobe.Bake:
    with _reading:
        if identity not in _read:
            _read.clear()
            if sent is not None:
                # The file's name is in the recipe, and its ending says what it is.
                scene = scene.at(os.path.join(folder, os.path.basename(scene.name)))
                with open(scene.name, "wb") as file:
                    file.write(sent)
            asked = BakeOptions(**options)
            made = asked.of(scene)
            if identity_of(made, scene, asked) != identity:
                raise RuntimeError(f"worker {_worker()[0]}: {scene.name}: is not the client's: give all machines the same files")
            if pilot is not None:
                made.know(pilot)
            _read[identity] = made
        return _read[identity]


@dataclass(frozen=True)
class Refused:
    """What a task returns where the system of its worker has refused something, which those of others may not."""

    worker: str
    """What it is called in messages."""
    place: str
    """The address of a worker of Dask, the identity of a machine of Ray."""
    fault: str
    full: bool
    """Whether there is no room on its disk."""

    def __str__(self) -> str:
        return f"worker {self.worker}: {self.fault}"

    @property
    def remedy(self) -> str:
        return f"{'free space' if self.full else 'mend that'} there, or stop that worker"


FULL = {getattr(errno, name) for name in ("EDQUOT", "EFBIG", "ENOSPC") if hasattr(errno, name)}
"""What systems say where there is no room for a file."""

Result = TypeVar("Result")


def bake_shard(
    sent: bytes | None,
    scene: Scene,
    options: dict[str, Any],
    identity: str,
    version: str,
    number: int,
    count: int,
    pilot: Pilot | None = None,
) -> bytes | Refused:
    """The task of a worker: a shard as the bytes of its file."""

    def shard(folder: str) -> bytes:
        made = _read_once(sent, scene, options, identity, folder, pilot)
        part = os.path.join(folder, f"{identity}.safetensors")
        made.write_shard(part, number, count, None)
        with open(part, "rb") as file:
            return file.read()

    return _in_a_folder(version, shard)


def measure(sent: bytes | None, scene: Scene, options: dict[str, Any], identity: str, version: str) -> Cost | Refused:
    """The first task of a worker: what shards cost."""
    return _in_a_folder(version, lambda folder: measured(_read_once(sent, scene, options, identity, folder), folder))


def _in_a_folder(version: str, work: Callable[[str], Result]) -> Result | Refused:
    """Work in a folder for its files, of this version. What the system refuses is returned, not raised: it would be tried again here."""
    if version != __version__:
        raise RuntimeError(f"this worker has lobe {__version__} and the client has {version}: install one version on all machines")
    try:
        with tempfile.TemporaryDirectory(prefix="lobe-") as folder:
            return work(folder)
    except OSError as error:
        # The library has the number in its text alone.
        told = re.search(r"\(os error (\d+)\)", str(error))
        number = int(told[1]) if told and error.errno is None else error.errno
        return Refused(*_worker(), " ".join(str(error).split()), number in FULL)


def _worker() -> tuple[str, str]:
    """The name of the worker, and where it is."""
    try:
        from distributed import get_worker

        address = str(get_worker().address)
        return address, address
    except (ImportError, ValueError):
        pass
    name = f"of process {os.getpid()} on {platform.node()}"
    try:
        from ray import get_runtime_context

        return name, str(get_runtime_context().get_node_id())
    except (ImportError, RuntimeError):
        return name, ""
