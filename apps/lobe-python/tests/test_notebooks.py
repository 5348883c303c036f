"""The notebooks run, and assert what they show."""

import pathlib

import pytest

nbclient = pytest.importorskip("nbclient", reason="nbclient is not installed")
nbformat = pytest.importorskip("nbformat", reason="nbformat is not installed")
pytest.importorskip("ipykernel", reason="ipykernel is not installed")
pytest.importorskip("matplotlib", reason="matplotlib is not installed")

# Warnings of the client about its own sockets.
pytestmark = pytest.mark.filterwarnings("ignore")

NOTEBOOKS = sorted((pathlib.Path(__file__).parents[1] / "notebooks").glob("*.ipynb"))


def test_the_notebooks_are_there():
    assert len(NOTEBOOKS) == 4, NOTEBOOKS


def by_time(path):
    """All but the first at night: each takes ten seconds of a processor, and what is traced by paths longer."""
    return pytest.param(path, id=path.stem, marks=[] if path == NOTEBOOKS[0] else [pytest.mark.nightly])


@pytest.mark.parametrize("path", [by_time(path) for path in NOTEBOOKS])
def test_a_notebook_runs_and_is_stored_without_outputs(path, tmp_path):
    notebook = nbformat.read(path, as_version=4)
    nbformat.validate(notebook)
    code = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert all(cell.outputs == [] and cell.execution_count is None for cell in code), "clear the outputs"
    assert any("assert " in cell.source for cell in code)
    # Without a deadline, as a busy machine takes its time: a kernel that dies is a fault, and so is a cell that raises.
    nbclient.NotebookClient(notebook, timeout=None, kernel_name="python3", resources={"metadata": {"path": str(tmp_path)}}).execute()
    assert any("image/png" in output.get("data", {}) for cell in code for output in cell.outputs), "it shows nothing"
