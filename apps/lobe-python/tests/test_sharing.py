"""Fields and path-traced pictures in shards, whose bytes are those of the command and of one machine."""

import os
import random

import numpy as np
import pytest

import lobe
from command import lobe_command

# The map of the program has negative texels, of which its reader tells.
pytestmark = pytest.mark.filterwarnings("ignore::lobe.LoadNote")

FIELD = {"order": 2, "spheres": 3, "cells": 4, "rays": 64}
PICTURE = {"width": 9, "height": 7, "samples": 16, "bounces": 1}


@pytest.mark.parametrize("count", [1, 3, 7])
def test_shards_of_a_field_have_the_bytes_of_one_machine(tmp_path, count):
    lobe.field("built-in:ball", tmp_path / "whole.safetensors", storage="f16", **FIELD)
    parts = [tmp_path / f"{number}.safetensors" for number in range(1, count + 1)]
    points = []
    for number, part in enumerate(parts, 1):
        own, in_all = lobe.field_shard("built-in:ball", part, (number, count), **FIELD)
        points.append(own)
        lobe_command("field built-in:ball --order 2 --spheres 3 --cells 4 --rays 64 --shard", f"{number}/{count}", "-o", tmp_path / "c.safetensors")
        assert part.read_bytes() == (tmp_path / "c.safetensors").read_bytes()
        (tmp_path / "c.safetensors").unlink()
    assert sum(points) == in_all, "each sample point is in one shard"
    random.Random(count).shuffle(parts)
    lobe.field("built-in:ball", tmp_path / "merged.safetensors", storage="f16", merge=parts, **FIELD)
    assert (tmp_path / "merged.safetensors").read_bytes() == (tmp_path / "whole.safetensors").read_bytes()
    assert not [name for name in os.listdir(tmp_path) if "checkpoint" in name]


@pytest.mark.parametrize("time", [None, 0.5])
@pytest.mark.parametrize("count", [1, 2, 7])
def test_shards_of_a_picture_make_the_picture_of_one_machine(tmp_path, count, time):
    scene = "built-in:ball" if time is None else "built-in:three-objects"
    light = lobe.EnvMap.bundled("sunset")
    whole = lobe.trace(scene, light, time=time, **PICTURE)
    parts = [tmp_path / f"{number}.safetensors" for number in range(1, count + 1)]
    for number, part in enumerate(parts, 1):
        lobe.trace_shard(scene, light, part, (number, count), time=time, **PICTURE)
    random.Random(count).shuffle(parts)
    merged = lobe.trace(scene, light, time=time, merge=parts, **PICTURE)
    np.testing.assert_array_equal(merged.mean, whole.mean)
    np.testing.assert_array_equal(merged.variance, whole.variance)
    assert len(os.listdir(tmp_path)) == count, "nothing else is left"


def test_a_shard_of_a_picture_is_that_of_the_command(tmp_path):
    lobe.EnvMap.bundled("sunset").save(tmp_path / "sky.exr")
    light = lobe.EnvMap.load(tmp_path / "sky.exr")
    lobe.trace_shard("built-in:ball", light, tmp_path / "a.safetensors", (2, 3), **PICTURE)
    options = "--size 9x7 --samples 16 --bounces 1 --shard 2/3 -o"
    lobe_command("render trace built-in:ball --env", tmp_path / "sky.exr", options, tmp_path / "b.safetensors")
    assert (tmp_path / "a.safetensors").read_bytes() == (tmp_path / "b.safetensors").read_bytes()


def test_shards_of_other_work_are_refused_by_name(tmp_path):
    light = lobe.Sh(np.ones((1, 3)))
    parts = [tmp_path / "1.safetensors", tmp_path / "2.safetensors"]
    for number, part in enumerate(parts, 1):
        lobe.trace_shard("built-in:ball", light, part, (number, 2), **PICTURE)
        lobe.field_shard("built-in:ball", tmp_path / f"f{number}.safetensors", (number, 2), **FIELD)
    fields = [tmp_path / "f1.safetensors", tmp_path / "f2.safetensors"]
    before = sorted(os.listdir(tmp_path))
    for work, message in [
        (lambda: lobe.trace("built-in:ball", light, merge=parts, **{**PICTURE, "samples": 32}), "1.safetensors: this shard and the others are not of this work"),
        (lambda: lobe.field("built-in:ball", tmp_path / "o.safetensors", merge=fields, **{**FIELD, "seed": 1}), "f1.safetensors: this shard and the others are not of this work"),
        (lambda: lobe.field("built-in:ball", tmp_path / "o.safetensors", merge=fields[:1], **FIELD), "2"),
        (lambda: lobe.field("built-in:ball", fields[0], merge=fields, **FIELD), "f1.safetensors is an input, which would be lost"),
        (lambda: lobe.trace("built-in:ball", light, merge=[*parts, parts[0]], **PICTURE), "1.safetensors"),
        (lambda: lobe.trace("built-in:ball", light, merge=fields, **PICTURE), "f1.safetensors"),
        (lambda: lobe.trace_shard("built-in:ball", light, tmp_path / "o.exr", (1, 2), **PICTURE), "o.exr: expected a name that ends in .safetensors"),
        (lambda: lobe.trace_shard("built-in:ball", light, tmp_path / "o.safetensors", (3, 2), **PICTURE), "shard: expected one of 2 from 1 on, found 3"),
        (lambda: lobe.field_shard("built-in:ball", tmp_path / "o.safetensors", (0, 2), **FIELD), "shard: expected 1 to"),
    ]:
        with pytest.raises(ValueError, match=message):
            work()
    for work in [
        lambda: lobe.trace("built-in:ball", light, merge="1.safetensors", **PICTURE),
        lambda: lobe.trace_shard("built-in:ball", light, tmp_path / "o.safetensors", 1, **PICTURE),
    ]:
        with pytest.raises(TypeError, match="parts: expected a list|shard: expected a pair"):
            work()
    assert sorted(os.listdir(tmp_path)) == before, "nothing is written or lost"


def test_a_shard_that_was_stopped_goes_on_from_its_file(tmp_path):
    class Enough(Exception):
        pass

    def stop(done, total):
        if 0 < done < total:
            raise Enough

    light = lobe.EnvMap.bundled("sunset")
    picture = {"width": 256, "height": 128, "samples": 8, "bounces": 0}
    path = tmp_path / "a.safetensors"
    with pytest.raises(Enough):
        lobe.trace_shard("built-in:ball", light, path, (1, 2), progress=stop, **picture)
    seen = []
    lobe.trace_shard("built-in:ball", light, path, (1, 2), progress=lambda done, total: seen.append(done), **picture)
    assert seen[0] > 0, "it begins with what was done"
    lobe.trace_shard("built-in:ball", light, tmp_path / "b.safetensors", (1, 2), **picture)
    assert path.read_bytes() == (tmp_path / "b.safetensors").read_bytes()
