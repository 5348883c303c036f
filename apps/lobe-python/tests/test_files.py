"""Files of expansions, against the command."""

import os
import subprocess

import numpy as np
import pytest

import lobe


@pytest.mark.parametrize("shape", [(16,), (9, 3)])
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_a_function_comes_back_from_its_file(tmp_path, shape, dtype):
    f = lobe.Sh(np.random.default_rng(0).normal(size=shape).astype(dtype))
    f.save(tmp_path / "f.sh.json", "irradiance")
    back = lobe.Sh.load(tmp_path / "f.sh.json", "irradiance")
    np.testing.assert_array_equal(np.asarray(back), np.asarray(f).astype(np.float64))
    with pytest.raises(ValueError, match="f.sh.json: expected radiance, found irradiance"):
        lobe.Sh.load(tmp_path / "f.sh.json", "radiance")


def test_files_are_those_of_the_command(tmp_path):
    command = os.environ.get("LOBE")
    if command is None:
        pytest.skip("LOBE names no command to compare with")
    sky = lobe.EnvMap.bundled("sunset").project(4)
    sky.save(tmp_path / "sky.sh.json")
    turn = "0,0,0.6,0.8"
    subprocess.run([command, "-q", "sh", "rotate", tmp_path / "sky.sh.json", "--quat", turn, "-o", tmp_path / "r.sh.json"], check=True)
    c, s = 0.8**2 - 0.6**2, 2 * 0.6 * 0.8
    expected = sky.rotate([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    np.testing.assert_allclose(np.asarray(lobe.Sh.load(tmp_path / "r.sh.json")), np.asarray(expected), atol=1e-12)
    lobe.Sh.load(tmp_path / "r.sh.json").save(tmp_path / "again.sh.json")
    assert (tmp_path / "again.sh.json").read_bytes() == (tmp_path / "r.sh.json").read_bytes()


def test_what_is_no_file_of_a_function_is_refused_in_one_line(tmp_path):
    (tmp_path / "bad.sh.json").write_text("{")
    f = lobe.Sh(np.ones(4))
    for call, kind, words in [
        (lambda: lobe.Sh.load(tmp_path / "none.sh.json"), OSError, "none.sh.json"),
        (lambda: lobe.Sh.load(tmp_path / "bad.sh.json"), ValueError, "bad.sh.json"),
        (lambda: f.save(tmp_path / "q.sh.json", "light"), ValueError, "radiance"),
        (lambda: f.save(tmp_path / "none" / "q.sh.json"), OSError, "q.sh.json"),
        (lambda: lobe.Sh(np.ones((2, 4))).save(tmp_path / "q.sh.json"), ValueError, "expected one function"),
    ]:
        with pytest.raises(kind) as refused:
            call()
        assert words in str(refused.value) and "\n" not in str(refused.value), refused.value
    assert not (tmp_path / "q.sh.json").exists()
