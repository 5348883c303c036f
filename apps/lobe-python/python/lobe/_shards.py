"""The files of a bake's shards, in a folder beside its output: what is done stays there until all is."""

from __future__ import annotations

import os
import re

from . import _lobe

SHARD = re.compile(r"([0-9a-f]{16})-[0-9]+-of-([0-9]+)\.safetensors")
"""The names of shards in their folder: their work, and how many there are."""


class Shards:
    """The files of so many shards of one work."""

    def __init__(self, folder: str, identity: str, count: int) -> None:
        self.folder, self.count = folder, count
        self.paths = [f"{folder}/{identity}-{number}-of-{count}.safetensors" for number in range(1, count + 1)]
        os.makedirs(folder, exist_ok=True)
        # A client that was killed while it wrote a shard has left a part of it; the files of a client at work stay.
        _lobe.clear_abandoned(self.paths[0])

    def missing(self) -> list[int]:
        """The numbers of those that are to be baked, from 1 on."""
        return [number for number, path in enumerate(self.paths, 1) if not os.path.exists(path)]

    def keep(self, number: int, shard: bytes) -> None:
        """Writes a shard; until it is whole and on the disk nothing has its name."""
        _lobe.write_whole(self.paths[number - 1], shard)

    def remove(self) -> None:
        """Removes all shards of the folder, also of earlier work, and the folder if nothing else is in it."""
        _lobe.clear_abandoned(self.paths[0])
        for found in found_in(self.folder):
            os.remove(os.path.join(self.folder, found[0]))
        if not os.listdir(self.folder):
            os.rmdir(self.folder)


def found_in(folder: str) -> list[re.Match[str]]:
    """The shards of a folder, of any work."""
    names = os.listdir(folder) if os.path.isdir(folder) else []
    return [found for name in names if (found := SHARD.fullmatch(name))]


def begun(folder: str, identity: str) -> int | None:
    """Of how many shards this work has some already; of several, where the largest share is done."""
    counts = [int(found[2]) for found in found_in(folder) if found[1] == identity]
    return max(counts, key=lambda count: counts.count(count) / count, default=None)
