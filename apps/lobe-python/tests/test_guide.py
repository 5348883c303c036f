"""The programs of the guide, of the README and of the package's own documentation."""

import doctest
import pathlib
import re

import pytest

import lobe

ROOT = pathlib.Path(__file__).parents[3]


# Of sharing some are warnings of Dask about its own processes, and of the reader about a map of the program.
@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("page", ["docs/guide/src/python.md", "docs/guide/src/sharing.md", "apps/lobe-python/README.md"])
def test_programs_of_a_page_run(page, tmp_path, monkeypatch):
    if page.endswith("sharing.md"):
        pytest.importorskip("distributed", reason="dask's distributed is not installed")
    monkeypatch.chdir(tmp_path)
    blocks = re.findall(r"^```python\n(.*?)^```", (ROOT / page).read_text(), flags=re.MULTILINE | re.DOTALL)
    assert blocks, "a page without programs"
    names = {}
    for block in blocks:
        exec(compile(block, page, "exec"), names)


def test_the_example_of_the_package_is_true():
    result = doctest.testmod(lobe)
    assert result.attempted > 3 and result.failed == 0


def test_recipes_for_batch_systems_share_all_of_a_bake_and_put_it_together():
    page = (ROOT / "docs/guide/src/sharing.md").read_text()
    for name in ["GNU parallel", "Slurm", "Kubernetes"]:
        recipe = page.split(f"**{name}**")[1].split("\n**")[0]
        assert "--shard " in recipe and "/64" in recipe and "--merge " in recipe, name
