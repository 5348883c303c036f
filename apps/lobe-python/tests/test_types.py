"""The types of the package, by the checker of editors and for a program that uses it, and its documentation; mypy runs beside these tests."""

import importlib
import inspect
import json
import os
import pathlib
import subprocess
import sys

import pytest

import lobe


@pytest.mark.nightly
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


USER = """
import numpy as np
import numpy.typing as npt

import lobe
import lobe.distributed


def brightest(paths: list[str]) -> tuple[str, float]:
    lights: list[lobe.Sh] = [lobe.EnvMap.load(path).project(3) for path in paths]
    values = [float(light.convolve("cosine").eval([0.0, 0.0, 1.0]).mean()) for light in lights]
    best = int(np.argmax(values))
    return paths[best], values[best]


def film(scene: lobe.Scene, light: lobe.Sh, turns: int) -> list[npt.NDArray[np.float32]]:
    report: lobe.BakeReport = lobe.distributed.bake(scene, "baked.glb", lobe.BakeOptions(order=4), shards=4)
    assert report is not None
    angles = np.linspace(0.0, 2.0 * np.pi, turns, endpoint=False)
    matrices = [np.array([[np.cos(a), -np.sin(a), 0.0], [np.sin(a), np.cos(a), 0.0], [0.0, 0.0, 1.0]]) for a in angles]
    return [lobe.render("baked.glb", light.rotate(matrix), width=64, height=48) for matrix in matrices]


def agree(scene: str, light: lobe.EnvMap) -> bool:
    one, other = (lobe.trace(scene, light, samples=64, seed=seed) for seed in (0, 1))
    least: lobe.Minimum = light.project(3).minimum()
    return lobe.z_test(one, other).passes and bool((least.at_least <= least.value).all())
"""


FAULTS = {
    "": None,
    "wrong: int = lobe.Sh([1.0]).mirror('x')": "Incompatible types",
    "lobe.bake('a.glb')": "Missing positional argument",
}
"""What follows the program in each file, and what is wrong with it."""


@pytest.mark.nightly
def test_programs_of_users_are_checked_strictly(tmp_path):
    files = {f"user_{k}.py": more for k, more in enumerate(FAULTS)}
    for name, more in files.items():
        (tmp_path / name).write_text(USER + more + "\n")
    environment = {**os.environ, "MYPYPATH": str(pathlib.Path(lobe.__file__).parent.parent)}
    # All at once: most of the time is spent on numpy.
    command = [sys.executable, "-m", "mypy", "--strict", "--no-error-summary", "--cache-dir=.cache", *files]
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    for name, more in files.items():
        faults = [line for line in done.stdout.splitlines() if line.startswith(name) and ": error: " in line]
        assert [FAULTS[more] in line for line in faults] == ([] if FAULTS[more] is None else [True]), done.stdout + done.stderr


def test_all_that_is_public_is_documented():
    modules = [lobe, importlib.import_module("lobe.distributed"), importlib.import_module("lobe.on_ray")]
    missing = [module.__name__ for module in modules if not module.__doc__]
    found = {f"{module.__name__}.{name}": getattr(module, name) for module in modules for name in getattr(module, "__all__", ["bake"])}
    for name, value in found.items():
        if not (inspect.isclass(value) or callable(value)):
            continue
        missing += [] if inspect.getdoc(value) else [name]
        for member, of in vars(value).items() if inspect.isclass(value) else ():
            if not member.startswith("_") and (callable(of) or isinstance(of, (property, classmethod, staticmethod))):
                missing += [] if inspect.getdoc(getattr(value, member)) else [f"{name}.{member}"]
    assert len(found) > 40 and missing == []
