"""What workers do. In a module of its own: a program's main module would be sent to them by value."""

from __future__ import annotations

import hashlib
import os
import platform
import tempfile
from dataclasses import asdict, dataclass
from threading import Lock
from typing import Any

from . import __version__, _lobe
from ._bake import BakeOptions
from ._scene import Scene

_read: dict[str, _lobe.Bake] = {}
"""The bake that this worker has had last, its scene read and its tree built."""

_reading = Lock()
"""Held while a scene is read: a worker of several threads reads it once, too."""


def identity_of(made: _lobe.Bake, scene: Scene, options: BakeOptions) -> str:
    """A name for this work, by all of the scene that decides it: shards of other work are not taken for its own."""
    digest = hashlib.blake2b(digest_size=8)
    work = (__version__, sorted(asdict(options).items()), os.path.basename(scene.name), made.scene_hash)
    digest.update(repr(work).encode())
    return digest.hexdigest()


def version() -> str:
    """The version of Lobe that this worker has."""
    return __version__


def one_line(text: object) -> str:
    """A message of others as a part of one of ours."""
    return " ".join(str(text).split())


@dataclass(frozen=True)
class Job:
    """What all tasks of a bake have in common, except the bytes of the scene; the version is the client's."""

    scene: Scene
    options: dict[str, Any]
    identity: str
    version: str


@dataclass(frozen=True)
class Refused:
    """What a task returns where the system of its worker has refused something, which the systems of others may not."""

    worker: str
    place: str
    """The address of a worker of Dask, the identity of a machine of Ray."""
    fault: str

    def __str__(self) -> str:
        return f"worker {self.worker}: {self.fault}"


def bake_shard(sent: bytes | None, job: Job, number: int, count: int) -> bytes | Refused:
    """The task of a worker: a shard's file. A refusal of the system is returned: an error would be tried again here."""
    if job.version != __version__:
        return Refused(*_worker(), f"has lobe {__version__}; install lobe {job.version} there")
    try:
        with tempfile.TemporaryDirectory(prefix="lobe-") as folder:
            made, path = _read_once(sent, job, folder), os.path.join(folder, f"{job.identity}.safetensors")
            made.write_shard(path, number, count, None)
            with open(path, "rb") as file:
                return file.read()
    except OSError as error:
        return Refused(*_worker(), f"{one_line(error)}; free space or mend that there, or stop that worker")


def _read_once(sent: bytes | None, job: Job, folder: str) -> _lobe.Bake:
    with _reading:
        if job.identity not in _read:
            _read.clear()
            scene, options = job.scene, BakeOptions(**job.options)
            if sent is not None:
                # The file's name is in the recipe, and its ending says what it is.
                scene = scene.at(os.path.join(folder, os.path.basename(scene.name)))
                with open(scene.name, "wb") as file:
                    file.write(sent)
            made = options.of(scene)
            if identity_of(made, scene, options) != job.identity:
                fault = f"{scene.name}: the file differs from the client's; give all machines the same files"
                raise RuntimeError(f"worker {_worker()[0]}: {fault}")
            _read[job.identity] = made
        return _read[job.identity]


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
