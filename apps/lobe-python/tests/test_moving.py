"""Pictures of scenes that move: the command's, and the truth."""

import warnings

import numpy as np
import pytest

import lobe
from command import lobe_command

SKY = lobe.EnvMap.bundled("sunset").project(3).dering()
# Twice as wide as high, so that a picture is read back as a lat-long map.
SIZE = {"width": 32, "height": 16}
SMALL = {"order": 3, "bake_samples": 8, "spheres": 2, "still_points": 27}
WORDS = "--order 3 --bake-samples 8 --spheres 2 --still-points 27 --size 32x16 --fov 40 --samples 4"


@pytest.fixture(scope="module")
def light(tmp_path_factory):
    path = tmp_path_factory.mktemp("light") / "sky.sh.json"
    SKY.save(path)
    return path


def read(path):
    with warnings.catch_warnings():
        # That the truth has an alpha, which is no light.
        warnings.simplefilter("ignore", lobe.LoadNote)
        return lobe.EnvMap.load(path, mapping="lat-long").texels


@pytest.mark.parametrize(
    "mode, words, options",
    [
        ("exponentials", "--time 0.7", {}),
        pytest.param("exponentials", "--time 0.2 --exponential hybrid --sphere-bounce --group 16 --sphere-window 6", {"exponential": "hybrid", "sphere_bounce": True, "group": 16, "sphere_window": 6.0}, marks=pytest.mark.nightly),
        ("fields", "--time 0.7 --interpolation cubic", {"interpolation": "cubic"}),
    ],
)
def test_a_moment_is_that_of_the_command(mode, words, options, light, tmp_path):
    lobe_command("render moving built-in:three-objects --env", light, f"--method {mode}", WORDS, words, "-o", tmp_path / "p.exr")
    moving = lobe.MovingScene("built-in:three-objects", lobe.MovingOptions(mode, **SMALL, **options))
    time = float(words.split()[1])
    np.testing.assert_array_equal(moving.render(SKY, time, **SIZE), read(tmp_path / "p.exr"))


def test_what_is_called_while_a_scene_is_at_work_cannot_ask_it():
    moving = lobe.MovingScene("built-in:three-objects", lobe.MovingOptions("exponentials", **SMALL))

    def ask(done, total):
        moving.bounds()

    with pytest.raises(RuntimeError, match="the scene is at work"):
        moving.bake(progress=ask)
    assert np.isfinite(moving.bounds()).all(), "afterwards it answers again"


@pytest.mark.nightly
def test_one_scene_gives_the_pictures_of_many_times():
    moving = lobe.MovingScene("built-in:three-objects", lobe.MovingOptions("exponentials", **SMALL))
    begin, end = moving.span
    assert begin < end and len(moving.parts) > 1
    camera = lobe.Camera((4, -6, 4), (0, 0, 0.5))
    first = moving.render(SKY, begin, camera=camera, **SIZE)
    later = moving.render(SKY, 0.5 * (begin + end), camera=camera, **SIZE)
    assert np.abs(first - later).max() > 0.05 * first.mean()
    np.testing.assert_array_equal(moving.render(SKY, begin, camera=camera, **SIZE), first)
    # What has come to its end rests there, unless it begins anew.
    resting = moving.render(SKY, end + 1.0, camera=camera, **SIZE)
    np.testing.assert_array_equal(resting, moving.render(SKY, end, camera=camera, **SIZE))
    again = lobe.MovingScene("built-in:three-objects", lobe.MovingOptions("exponentials", **SMALL), loop=True)
    np.testing.assert_allclose(again.render(SKY, end + begin, camera=camera, **SIZE), first, atol=1e-4)


@pytest.mark.nightly
def test_the_shading_is_near_the_truth_of_the_same_moment(light, tmp_path):
    options = lobe.MovingOptions("exponentials", order=4, bake_samples=64, bounces=0, spheres=8, still_points=0)
    moving = lobe.MovingScene("built-in:three-objects", options)
    truth = moving.trace(SKY, 0.7, samples=64, bounces=0, seed=2, **SIZE)
    assert lobe.compare(moving.render(SKY, 0.7, **SIZE), truth.mean).psnr > 25
    same = lobe.trace("built-in:three-objects", SKY, time=0.7, samples=64, bounces=0, seed=2, **SIZE)
    np.testing.assert_array_equal(same.mean, truth.mean)
    words = "--time 0.7 --samples 64 --bounces 0 --seed 2 --size 32x16 --fov 40"
    lobe_command("render trace built-in:three-objects --env", light, words, "-o", tmp_path / "t.exr")
    np.testing.assert_array_equal(truth.mean, read(tmp_path / "t.exr"))


@pytest.mark.nightly
def test_what_is_baked_is_taken_up_again(tmp_path):
    class Stopped(Exception):
        pass

    options = lobe.MovingOptions("exponentials", **{**SMALL, "bake_samples": 64})
    calls = []

    def stop(done, total):
        calls.append((done, total))
        if done == total:
            raise Stopped

    with pytest.raises(Stopped):
        lobe.MovingScene("built-in:three-objects", options).bake(checkpoint=tmp_path / "c", progress=stop)
    kept = sorted(path.name for path in tmp_path.iterdir())
    assert kept and all(name.startswith("c.") for name in kept), kept
    resumed = []
    moving = lobe.MovingScene("built-in:three-objects", options)
    assert moving.bake(checkpoint=tmp_path / "c", progress=lambda done, total: resumed.append((done, total))) == 3
    assert resumed[0][0] > 0, "the first part is there already"
    anew = lobe.MovingScene("built-in:three-objects", options)
    np.testing.assert_array_equal(moving.render(SKY, 0.3, **SIZE), anew.render(SKY, 0.3, **SIZE))


@pytest.mark.nightly
def test_render_shows_what_moves_at_a_time():
    found = lobe.render("built-in:three-objects", SKY, mode="exponentials", order=2, bake_samples=4, time=0.4, **SIZE)
    moving = lobe.MovingScene("built-in:three-objects", lobe.MovingOptions("exponentials", order=2, bake_samples=4))
    np.testing.assert_array_equal(found, moving.render(SKY, 0.4, **SIZE))


def test_what_cannot_move_or_be_shown_is_refused(tmp_path):
    (tmp_path / "s.json").write_text("{}")
    for call, error, message in [
        (lambda: lobe.MovingOptions("glossy"), ValueError, "method: expected fields or exponentials"),
        (lambda: lobe.MovingOptions("fields", exponential="hybrid"), ValueError, "exponential: only of method exponentials"),
        (lambda: lobe.MovingOptions("exponentials", exponential="eigen"), ValueError, "exponential: expected grid"),
        (lambda: lobe.MovingOptions(group=8), ValueError, "group: expected a multiple of 16"),
        (lambda: lobe.MovingOptions(still_points=4), ValueError, "still_points: expected 0, or 8"),
        (lambda: lobe.MovingOptions(order=9), ValueError, "order: expected 1 to 8"),
        (lambda: lobe.MovingScene("built-in:ball", lobe.BakeOptions()), TypeError, "options: expected MovingOptions"),
        (lambda: lobe.MovingScene(tmp_path / "none.glb"), OSError, "none.glb"),
        (lambda: lobe.MovingScene(tmp_path / "s.json"), ValueError, "s.json"),
        (lambda: lobe.MovingScene(tmp_path / "s.json", animation=0), ValueError, "animation: only of glTF files"),
        (lambda: lobe.MovingScene("built-in:three-objects", animation="dance"), ValueError, "dance"),
        (lambda: lobe.MovingScene("built-in:three-objects").render(SKY, float("nan")), ValueError, "time"),
        (lambda: lobe.render("built-in:three-objects", SKY, time=1.0), ValueError, "time: only of the modes fields and exponentials"),
    ]:
        with pytest.raises(error, match=message):
            call()
