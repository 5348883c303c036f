"""Options of jobs: one table in the library, from which the package's are written."""

import json

import option_fields
import pytest
from command import lobe_command

import lobe

QUICK = {"order": 2, "samples": 4, "no_split": True}


def test_the_fields_are_those_of_the_library():
    assert option_fields.FILE.read_text() == option_fields.text(), "python tests/option_fields.py writes them anew"


def test_options_like_those_of_a_file_bake_its_bytes_again(tmp_path):
    first, again = tmp_path / "first.glb", tmp_path / "again.glb"
    lobe.bake("built-in:cornell", first, lobe.BakeOptions(seed=3, mode="shadowed", **QUICK))
    options = lobe.BakeOptions.like(first)
    assert (options.order, options.samples, options.seed, options.mode) == (2, 4, 3, "shadowed")
    lobe.bake("built-in:cornell", again, options)
    assert again.read_bytes() == first.read_bytes()


def test_backs_and_charts_are_there_as_in_the_command(tmp_path):
    sheet = tmp_path / "sheet.obj"
    sheet.write_text("v -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\nf 1 4 3 2\n")
    with pytest.warns(lobe.LoadNote, match="normals missing or zero"):
        lobe.bake(sheet, tmp_path / "o.glb", lobe.BakeOptions(order=1, samples=4, texels=16, unwrap="always", padding=1))
    assert lobe.BakeOptions.like(tmp_path / "o.glb").padding == 1
    with pytest.raises(ValueError, match="backs: not with texels"):
        lobe.BakeOptions(backs=True, texels=8)


def test_a_value_of_another_type_is_a_type_error_and_one_out_of_range_is_not():
    for options, error in [
        ({"order": "4"}, TypeError),
        ({"order": 4.5}, TypeError),
        ({"order": 0}, ValueError),
        ({"denoise": 1}, TypeError),
        ({"grid": "2,2,2"}, TypeError),
        ({"energy_stop": float("inf")}, ValueError),
        ({"seed": -1}, ValueError),
    ]:
        with pytest.raises(error, match=f"^{next(iter(options))}: expected .*, found "):
            lobe.BakeOptions(**options)


def test_the_command_reads_the_same_job(tmp_path):
    options = lobe.BakeOptions(seed=5, **QUICK)
    first, again, job = tmp_path / "first.glb", tmp_path / "again.glb", tmp_path / "job.toml"
    lobe.bake("built-in:cornell", first, options)
    values = options.asked() | {"scene": "built-in:cornell", "output": str(again)}
    job.write_text("".join(f"{name} = {json.dumps(value)}\n" for name, value in values.items()))
    lobe_command("bake --job", job)
    assert again.read_bytes() == first.read_bytes()
