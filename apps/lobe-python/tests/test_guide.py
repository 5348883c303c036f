"""The programs of the guide, of the README and of the package's own documentation."""

import doctest
import pathlib
import re

import pytest

import lobe

ROOT = pathlib.Path(__file__).parents[3]


@pytest.mark.parametrize("page", ["docs/guide/src/python.md", "apps/lobe-python/README.md"])
def test_programs_of_a_page_run(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    blocks = re.findall(r"^```python\n(.*?)^```", (ROOT / page).read_text(), flags=re.MULTILINE | re.DOTALL)
    assert blocks, "a page without programs"
    names = {}
    for block in blocks:
        exec(compile(block, page, "exec"), names)


def test_the_example_of_the_package_is_true():
    result = doctest.testmod(lobe)
    assert result.attempted > 3 and result.failed == 0
