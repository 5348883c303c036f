"""The simulation behind the chapter on sharing work, against cases with a closed form."""

import importlib.util
import math
import pathlib
import subprocess
import sys
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

GUIDE = pathlib.Path(__file__).parents[3] / "docs/guide/src"
PROGRAM = GUIDE / "sharing_model.py"

if not PROGRAM.exists():
    pytest.skip("docs/guide/src/sharing_model.py is only in the repository", allow_module_level=True)

spec = importlib.util.spec_from_file_location("sharing_model", PROGRAM)
model = importlib.util.module_from_spec(spec)
# Data classes look their module up.
sys.modules[spec.name] = model
spec.loader.exec_module(model)

NOTHING_BUT_WORK = model.Bake(work=4.0, setup=0.0, scene=0.0, result=0.0, shard=0.0, spread=0.0)


def test_equal_shards_take_their_rounds():
    for machines, count in [(1, 1), (2, 4), (3, 4), (4, 4), (5, 4)]:
        found = model.elapsed(NOTHING_BUT_WORK, machines, [4.0 / count] * count)
        assert found == pytest.approx(math.ceil(count / machines) * 4.0 / count), (machines, count)


def test_reading_and_sending_the_scene_is_paid_once():
    bake = replace(NOTHING_BUT_WORK, setup=7.0, scene=30.0, link=10.0)
    # To the scheduler and to the first; then three, nine machines have it after two more transfers each.
    for machines, transfers in [(1, 2), (2, 4), (3, 4), (4, 6), (9, 6), (10, 8)]:
        found = model.elapsed(bake, machines, [1.0] * machines)
        assert found == pytest.approx(3.0 * transfers + 7.0 + 1.0), machines


def test_a_slow_machine_holds_up_what_it_has_taken():
    bake = replace(NOTHING_BUT_WORK, slow=True)
    assert model.elapsed(bake, 2, [2.0, 2.0]) == pytest.approx(6.0)
    # The other machine does three of four in that time.
    assert model.elapsed(bake, 2, [1.0] * 4) == pytest.approx(3.0)


def test_what_a_machine_that_dies_had_in_hand_is_done_again():
    bake = replace(NOTHING_BUT_WORK, dies=True)
    # It dies after one second: of a shard of two seconds nothing is left, and the other does both.
    assert model.elapsed(bake, 2, [2.0, 2.0]) == pytest.approx(4.0)
    assert model.elapsed(bake, 2, [1.0] * 4) == pytest.approx(3.0)
    # Nobody knows for five seconds.
    assert model.elapsed(replace(bake, noticed=5.0), 2, [2.0, 2.0]) == pytest.approx(8.0)


def test_a_client_takes_one_shard_after_the_other():
    bake = replace(NOTHING_BUT_WORK, shard=2.0, result=60.0, link=10.0)
    # All are done after one second; each costs two, and its part of six.
    assert model.elapsed(bake, 4, [1.0] * 4) == pytest.approx(1.0 + 4 * 2.0 + 6.0)


@given(st.integers(1, 20), st.integers(1, 8), st.floats(0.0, 1.5), st.integers(0, 2**32))
def test_list_scheduling_is_within_its_bounds(machines, each, spread, seed):
    bake = replace(NOTHING_BUT_WORK, spread=spread)
    shards = model.costs(bake, machines * each, seed)
    assert math.fsum(shards) == pytest.approx(bake.work)
    found, share = model.elapsed(bake, machines, shards), bake.work / machines
    # Graham: no machine is free while a shard waits, so that the last one begins before the mean of what the others take.
    assert max(share, max(shards)) <= found * (1 + 1e-12)
    assert found <= (share + (1 - 1 / machines) * max(shards)) * (1 + 1e-12)


def test_all_shards_are_done_whatever_befalls_machines():
    for case in model.CASES.values():
        bake = replace(model.Bake(), **case)
        shards = model.costs(bake, 64, 0)
        assert len(model.done_times(bake, 16, shards)) == 64, case


@pytest.mark.nightly
def test_the_table_of_the_chapter_is_what_the_program_prints():
    printed = subprocess.run([sys.executable, PROGRAM], capture_output=True, text=True, check=True).stdout
    assert printed in (GUIDE / "sharing.md").read_text(encoding="utf-8")
