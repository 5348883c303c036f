"""What is read from files, on its way to other processes: as the bytes of a file, so that none has to be where it arrives."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable
from typing import TypeVar

Read = TypeVar("Read")


def bytes_of(write: Callable[[str], None]) -> bytes:
    """The bytes of the .safetensors file that `write` makes."""
    with tempfile.TemporaryDirectory(prefix="lobe-") as folder:
        path = _file_in(folder)
        write(path)
        with open(path, "rb") as file:
            return file.read()


def from_bytes(read: Callable[[str], Read], contents: bytes) -> Read:
    """What `read` makes of a .safetensors file of these bytes."""
    with tempfile.TemporaryDirectory(prefix="lobe-") as folder:
        path = _file_in(folder)
        with open(path, "wb") as file:
            file.write(contents)
        return read(path)


def _file_in(folder: str) -> str:
    return os.path.join(folder, "carried.safetensors")
