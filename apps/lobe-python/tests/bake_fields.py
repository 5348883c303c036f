"""The fields of `lobe.BakeOptions`, as the library has them: `python tests/bake_fields.py` writes them, the tests compare."""

from pathlib import Path
from textwrap import wrap

from lobe import _lobe

FILE = Path(__file__).parent.parent / "python/lobe/_bake_fields.py"

OF_JOBS = ("output", "max_memory", "fresh", "shard", "merge")
"""Options that are arguments of functions here, or of a scene."""

HEAD = '''"""Options of a bake. Written by tests/bake_fields.py from the options of the library: change those."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class BakeFields:
    """All options of a bake, in the names of the command."""

'''


def text() -> str:
    """The file."""
    out = HEAD
    for name, kind, default, doc in _lobe.bake_fields():
        if name not in OF_JOBS:
            lines = wrap(f'"""{doc[0].upper()}{doc[1:]}"""', 116)
            out += f"    {name}: {kind} = {default}\n" + "".join(f"    {line}\n" for line in lines)
    return out


if __name__ == "__main__":
    FILE.write_text(text())
