"""The command `lobe`, which tests compare the package with."""

import json
import os
import shutil
import subprocess

import pytest


def lobe_command(*arguments):
    """What the command prints, by its arguments; a test is skipped where it is not built."""
    command = os.environ.get("LOBE") or shutil.which("lobe")
    if command is None:
        pytest.skip("the command lobe is not built: set LOBE to it")
    words = [str(word) for argument in arguments for word in (argument.split() if isinstance(argument, str) else [argument])]
    return subprocess.run([command, *words, "--quiet"], check=True, capture_output=True, text=True).stdout


def lobe_json(*arguments):
    """The JSON that the command prints."""
    return json.loads(lobe_command(*arguments, "--json"))
