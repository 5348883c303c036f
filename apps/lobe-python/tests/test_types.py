"""The types of the package, by the checker of editors; mypy runs beside these tests."""

import json
import pathlib
import subprocess
import sys

import pytest

import lobe


def test_pyright_finds_no_error(tmp_path):
    pytest.importorskip("basedpyright", reason="basedpyright is not installed")
    settings = {
        "include": [str(pathlib.Path(lobe.__file__).parent)],
        "typeCheckingMode": "standard",
        "pythonVersion": "3.10",
        # Dask, Ray and matplotlib need not be there.
        "reportMissingImports": "none",
    }
    (tmp_path / "pyrightconfig.json").write_text(json.dumps(settings))
    command = [sys.executable, "-m", "basedpyright", "--project", str(tmp_path), "--pythonpath", sys.executable]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "0 errors" in done.stdout
