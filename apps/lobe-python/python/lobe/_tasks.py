"""What workers do. In a module of its own: a program's main module would be sent to them by value."""

from __future__ import annotations

import hashlib
import os
import platform
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict
from threading import Lock
from typing import Any

from . import __version__, _lobe
from ._bake import BakeOptions
from ._scene import Scene
from ._shards import Cost, measured

Pilot = tuple[int, float]
"""What the pilot of a bake has found: bounces, and an error."""

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
                raise RuntimeError(f"worker {_worker_name()}: {scene.name}: is not the client's: give all machines the same files")
            if pilot is not None:
                made.know(pilot)
            _read[identity] = made
        return _read[identity]


def bake_shard(
    sent: bytes | None,
    scene: Scene,
    options: dict[str, Any],
    identity: str,
    version: str,
    number: int,
    count: int,
    pilot: Pilot | None = None,
) -> bytes:
    """The task of a worker: a shard as the bytes of its file."""
    with _work_folder(version) as folder:
        made = _read_once(sent, scene, options, identity, folder, pilot)
        part = os.path.join(folder, f"{identity}.safetensors")
        made.write_shard(part, number, count, None)
        with open(part, "rb") as file:
            return file.read()


def measure(sent: bytes | None, scene: Scene, options: dict[str, Any], identity: str, version: str) -> Cost:
    """The first task of a worker: what shards cost."""
    with _work_folder(version) as folder:
        return measured(_read_once(sent, scene, options, identity, folder), folder)


@contextmanager
def _work_folder(version: str) -> Iterator[str]:
    """A folder for the files of a task of this version; what the system refuses is said with the worker's name."""
    if version != __version__:
        raise RuntimeError(f"this worker has lobe {__version__} and the client has {version}: install one version on all machines")
    try:
        with tempfile.TemporaryDirectory(prefix="lobe-") as folder:
            yield folder
    except OSError as error:
        raise OSError(f"worker {_worker_name()}: {error}") from error


def _worker_name() -> str:
    try:
        from distributed import get_worker

        return str(get_worker().address)
    except (ImportError, ValueError):
        return f"of process {os.getpid()} on {platform.node()}"
