"""Bags of files and arrays on Dask, with a worker that is a process of its own."""

import numpy as np
import pytest

import lobe

distributed = pytest.importorskip("distributed", reason="dask's distributed is not installed")

import lobe.distributed as on_dask  # noqa: E402

# Warnings of Dask about its own processes.
pytestmark = pytest.mark.filterwarnings("ignore")


@pytest.fixture(scope="module")
def client():
    with (
        distributed.LocalCluster(n_workers=2, threads_per_worker=1, host="127.0.0.1", dashboard_address=None) as cluster,
        distributed.Client(cluster, set_as_default=False) as client,
    ):
        yield client


@pytest.fixture(scope="module")
def skies(tmp_path_factory):
    folder = tmp_path_factory.mktemp("skies")
    paths = [folder / f"sky-{k}.exr" for k in range(6)]
    for k, path in enumerate(paths):
        lobe.EnvMap.sky([1, 0.5, 0.2 + 0.3 * k], height=32).save(path)
    return paths


def test_many_skies_become_expansions_in_their_order(client, skies):
    told = []
    found = on_dask.map(lambda path: lobe.EnvMap.load(path).project(3), skies, client=client, progress=lambda *n: told.append(n))
    for path, light in zip(skies, found, strict=True):
        assert np.array_equal(light.coefficients, lobe.EnvMap.load(path).project(3).coefficients), path
    assert told == [(done, 6) for done in range(1, 7)]


def test_a_bad_file_is_named_after_all_others_are_done(client, skies, tmp_path):
    bad = tmp_path / "bad.exr"
    bad.write_bytes(skies[0].read_bytes()[:300])

    def prefilter(path):
        levels = lobe.EnvMap.load(path).prefilter(32, 16)
        for k, level in enumerate(levels):
            level.save(tmp_path / f"{path.stem}-{k}.exr")
        return len(levels)

    with pytest.raises(on_dask.Unfinished, match=r"^1 of 4 items failed: .*bad\.exr: ") as caught:
        on_dask.map(prefilter, [skies[0], bad, skies[1], skies[2]], client=client)
    results = caught.value.results
    assert results == [2, None, 2, 2] and list(caught.value.errors) == [1]
    assert "\n" not in str(caught.value)
    written = sorted(path.name for path in tmp_path.glob("sky-*.exr"))
    assert written == [f"sky-{k}-{level}.exr" for k in range(3) for level in range(2)]
    level = lobe.EnvMap.load(skies[1]).prefilter(32, 16)[1].texels
    # Pictures have half the bits of what is in memory.
    assert np.allclose(lobe.EnvMap.load(tmp_path / "sky-1-1.exr").texels, level, rtol=1e-3)


def test_splats_are_turned_in_partitions_of_a_file(client, tmp_path):
    sh = np.random.default_rng(0).normal(size=(1000, 16, 3)).astype(np.float32)
    path = tmp_path / "sh.npy"
    np.save(path, sh)
    out = np.lib.format.open_memmap(tmp_path / "turned.npy", mode="w+", dtype=np.float32, shape=sh.shape)
    out.flush()
    r = np.array([[0.0, -1.0, 0.0], [0.6, 0.0, -0.8], [0.8, 0.0, 0.6]])

    def turn(rows):
        part = np.load(path, mmap_mode="r")[slice(*rows)]
        whole = np.load(tmp_path / "turned.npy", mmap_mode="r+")
        whole[slice(*rows)] = lobe.Sh(part).rotate(r).coefficients
        whole.flush()
        return len(part)

    ranges = [(begin, min(begin + 300, 1000)) for begin in range(0, 1000, 300)]
    assert on_dask.map(turn, ranges, client=client) == [300, 300, 300, 100]
    assert np.array_equal(np.load(tmp_path / "turned.npy"), lobe.Sh(sh).rotate(r).coefficients)


def test_a_message_stays_short_whatever_fails(client):
    def fail(item):
        raise ValueError("no\nway")

    with pytest.raises(on_dask.Unfinished) as caught:
        on_dask.map(fail, [np.zeros(100_000), *range(9)], client=client)
    message = str(caught.value)
    assert message.startswith("10 of 10 items failed: [0.") and message.endswith("; and 7 more")
    assert len(message) < 300 and "\n" not in message


def test_an_empty_bag_is_done(client):
    assert on_dask.map(len, [], client=client) == []
