"""The wheel that users install: built by maturin, installed where nothing else is, used outside of the repository."""

import os
import pathlib
import subprocess
import sys
import zipfile

import pytest

import lobe

pytestmark = pytest.mark.nightly

SOURCES = pathlib.Path(__file__).resolve().parent.parent

BAKE = """
import lobe
lobe.bake("built-in:ball", "o.safetensors", lobe.BakeOptions(mode="shadowed", order=3, samples=64))
print(lobe.__file__)
"""


def run(folder, *command):
    """What a program says that sees nothing of this package's folder."""
    environment = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "VIRTUAL_ENV"))}
    done = subprocess.run(list(map(str, command)), cwd=folder, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, f"{command}: {done.stdout}{done.stderr}"
    return done.stdout


def environment_at(folder, *installed):
    """A new environment with these packages alone: the folder of its programs."""
    run(folder.parent, sys.executable, "-m", "venv", folder)
    programs = folder / ("Scripts" if sys.platform == "win32" else "bin")
    run(folder.parent, programs / "python", "-m", "pip", "install", "--quiet", "--disable-pip-version-check", *installed)
    return programs


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    folder = tmp_path_factory.mktemp("wheel")
    maturin = environment_at(folder / "builder", "maturin>=1.9,<2") / "maturin"
    # Not as it is released: what was compiled for the other tests serves here, too.
    run(SOURCES, maturin, "build", "--locked", "--out", folder)
    [wheel] = folder.glob("*.whl")
    return wheel


def test_the_wheel_has_the_package_with_its_types_and_one_library_for_all_versions(wheel):
    sources = {f"lobe/{path.name}" for path in (SOURCES / "python/lobe").iterdir() if path.is_file()}
    with zipfile.ZipFile(wheel) as held:
        names = {name for name in held.namelist() if name.startswith("lobe/")}
    [library] = names - sources
    assert sources <= names and "lobe/py.typed" in names and "lobe/_lobe.pyi" in names
    assert library.startswith("lobe/_lobe.") and "-abi3-" in wheel.name, (library, wheel.name)


def test_the_wheel_bakes_where_nothing_else_is_installed(wheel, tmp_path):
    programs = environment_at(tmp_path / "empty", wheel)
    assert run(tmp_path, programs / "lobe-dask", "--help").startswith("usage: ")
    at = run(tmp_path, programs / "python", "-c", BAKE).strip()
    assert pathlib.Path(at).is_relative_to(tmp_path / "empty"), at
    lobe.bake("built-in:ball", tmp_path / "here.safetensors", lobe.BakeOptions(mode="shadowed", order=3, samples=64))
    assert (tmp_path / "o.safetensors").read_bytes() == (tmp_path / "here.safetensors").read_bytes()
    without = subprocess.run([programs / "lobe-dask", "built-in:ball", "-o", "p.glb"], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (without.returncode, without.stderr) == (2, "error: No module named 'distributed'; pip install distributed\n")
