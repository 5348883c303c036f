"""The fields of `lobe.BakeOptions` and `lobe.MovingOptions`, as the library has them: `python tests/option_fields.py` writes
them, the tests compare."""

from pathlib import Path
from textwrap import wrap

from lobe import _lobe

FILE = Path(__file__).parent.parent / "python/lobe/_option_fields.py"

OF_JOBS = ("output", "max_memory", "fresh", "shard", "merge")
"""Options that are arguments of functions here, or of a scene."""

HEAD = '''"""Options of jobs. Written by tests/option_fields.py from the options of the library: change those."""

from __future__ import annotations

from dataclasses import dataclass
'''

CLASS = '''

@dataclass(frozen=True)
class {}:
    """{}, in the names of the command."""

'''


def text() -> str:
    """The file."""
    out = HEAD
    for name, what, fields in [
        ("BakeFields", "All options of a bake", _lobe.bake_fields()),
        ("MovingFields", "All options of what is baked of a scene that moves, and how it is shaded", _lobe.moving_fields()),
    ]:
        out += CLASS.format(name, what)
        for field, kind, default, doc in fields:
            if field not in OF_JOBS:
                lines = wrap(f'"""{doc[0].upper()}{doc[1:]}"""', 116)
                out += f"    {field}: {kind} = {default}\n" + "".join(f"    {line}\n" for line in lines)
    return out


if __name__ == "__main__":
    FILE.write_text(text())
