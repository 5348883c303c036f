"""What cannot be is refused by TypeError or ValueError, in one line that says what was expected."""

import numpy as np
import pytest

import lobe

F = lobe.Sh(np.arange(1.0, 10.0))
NAN = lobe.Sh(np.full(9, np.nan))
SCENE = "built-in:ball"
MASKED = np.ma.masked_array(np.ones((4, 8, 3)), mask=np.eye(4, 8)[..., None] * np.ones(3))

REFUSED = {
    "a light that is a number": (lambda p: lobe.trace(SCENE, 3), TypeError, "light: expected an EnvMap or an Sh, found int"),
    "a light that is an array": (lambda p: lobe.render(SCENE, np.ones(9)), TypeError, "light: expected an EnvMap or an Sh"),
    "light that is not finite": (lambda p: lobe.trace(SCENE, NAN), ValueError, "light: expected finite numbers, found nan"),
    "a camera that is none": (lambda p: lobe.trace(SCENE, F, camera=3), TypeError, "camera: expected a Camera"),
    "half a path": (lambda p: lobe.trace(SCENE, F, samples=2.5), TypeError, "samples: expected a whole number"),
    "a mode that is a number": (lambda p: lobe.BakeOptions(mode=3), TypeError, "mode: expected unshadowed"),
    "an energy that is text": (lambda p: lobe.BakeOptions(energy_stop="x"), TypeError, "energy_stop: expected a number"),
    "an energy that is NaN": (lambda p: lobe.BakeOptions(energy_stop=float("nan")), ValueError, "energy_stop: expected a number from 0 to below 1, found"),
    "a grid of one number": (lambda p: lobe.BakeOptions(grid=3), TypeError, "grid: expected 3 whole numbers from 2 to 4096, found 3"),
    "a box of one number": (lambda p: lobe.BakeOptions(grid=(2, 2, 2), grid_box=3.0), TypeError, "grid_box: expected 6 finite numbers"),
    "an edge that is text": (lambda p: lobe.BakeOptions(max_edge="a"), TypeError, "max_edge: expected a number"),
    "a shard that is a number": (lambda p: lobe.bake(SCENE, p / "o.glb", shard=3), TypeError, "shard: expected a pair"),
    "a shard of three numbers": (lambda p: lobe.bake(SCENE, p / "o.glb", shard=(1, 2, 3)), TypeError, "shard: expected a pair"),
    "a shard beyond the last": (lambda p: lobe.bake(SCENE, p / "o.glb", shard=(3, 2)), ValueError, "shard: expected a part I/N, such as 1/4"),
    "one part by its name": (lambda p: lobe.merge(SCENE, "part", p / "o.glb"), TypeError, "parts: expected a list of files"),
    "texels that are NaN": (lambda p: lobe.project(np.full((4, 8, 3), np.nan), 3), ValueError, "texels: expected finite numbers"),
    "an infinite texel": (
        lambda p: lobe.EnvMap(np.where(np.arange(4 * 8 * 3).reshape(4, 8, 3) == 50, np.inf, 1.0)),
        ValueError,
        "at row 2, column 0",
    ),
    "a number among texels that is NaN": (
        lambda p: lobe.project(np.where(np.arange(32).reshape(4, 8) == 10, np.nan, 1.0), 3),
        ValueError,
        "texels: expected finite numbers, found [NaN] at row 1, column 2",
    ),
    "texels in a row": (lambda p: lobe.project(np.ones(8), 3), ValueError, "image: expected an array of shape"),
    "texels of functions beyond the largest": (lambda p: F.texels(1 << 20, 4), ValueError, "size: expected 1 to 32768"),
    "texels that are masked": (lambda p: lobe.project(MASKED, 3), TypeError, "image: expected an array, found a masked one"),
    "a map without texels": (lambda p: lobe.project(np.ones((0, 0, 3)), 3), ValueError, "needs texels, but 0 x 0 has none"),
    "a map that is nothing": (lambda p: lobe.EnvMap(None), TypeError, "texels: expected numbers"),
    "a mapping that is a number": (lambda p: lobe.EnvMap(np.ones((4, 8, 3)), 3), TypeError, "mapping: expected a name"),
    "a mapping of no such name": (lambda p: lobe.EnvMap(np.ones((4, 8, 3)), "flat"), ValueError, "expected a mapping such as"),
    "a turbidity that is text": (lambda p: lobe.EnvMap.sky([0, 0, 1], turbidity="a"), TypeError, "turbidity: expected a number"),
    "a sun below the horizon": (lambda p: lobe.EnvMap.sky([0, 0, -1]), ValueError, "sun"),
    "pictures that are not finite": (
        lambda p: lobe.compare(np.full((4, 8, 3), np.nan), np.ones((4, 8, 3))),
        ValueError,
        "picture: expected finite numbers",
    ),
    "coefficients of objects": (lambda p: lobe.Sh(np.ones(9, object)), TypeError, "coefficients: expected numbers of float32 or float64"),
    "coefficients of bits": (lambda p: lobe.Sh(np.ones(9, bool)), TypeError, "found bool"),
    "complex coefficients": (lambda p: lobe.Sh(np.ones(9, complex)), TypeError, "found complex128"),
    "coefficients that are text": (lambda p: lobe.Sh("abc"), TypeError, "coefficients: expected numbers"),
    "a number that is no square": (lambda p: lobe.Sh(np.ones(8)), ValueError, "expected n² coefficients"),
    "an encoding of NaN": (lambda p: NAN.encode("zh3"), ValueError, "coefficients: expected finite numbers"),
    "the minimum of NaN": (lambda p: NAN.minimum(), ValueError, "expected finite coefficients"),
    "one function as a sequence": (lambda p: list(F), TypeError, "one function is no sequence"),
    "a direction without length": (lambda p: F.eval([0, 0, 0]), ValueError, "expected vectors with a length"),
    "a direction in a plane": (lambda p: F.eval([0, 1]), ValueError, "expected an array of shape (..., 3)"),
    "a matrix that scales": (lambda p: F.rotate(2 * np.eye(3)), ValueError, "expected a rotation matrix"),
    "a map beyond the largest": (lambda p: lobe.reconstruct(F, 1 << 20, 4), ValueError, "size: expected 1 to 32768"),
    "a map of NaN": (lambda p: lobe.reconstruct(NAN, 8, 4), ValueError, "coefficients: expected finite numbers"),
    "an order that is text": (lambda p: lobe.project(np.ones((4, 8, 3)), "3"), TypeError, "order: expected a whole number"),
    "an order beyond the highest": (lambda p: lobe.project(np.ones((4, 8, 3)), 257), ValueError, "order: expected 1 to 256"),
    "progress that is no function": (
        lambda p: lobe.bake(SCENE, p / "o.glb", lobe.BakeOptions(order=1, samples=2), progress=3),
        TypeError,
        "not callable",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_cannot_be_is_refused_in_one_line(case, tmp_path):
    call, kind, words = REFUSED[case]
    with pytest.raises(kind) as refused:
        call(tmp_path)
    line = str(refused.value)
    assert words in line and "\n" not in line, line
    assert not list(tmp_path.glob("*.glb")), "nothing is half written"


VIEWS = {
    "negative strides": lambda a: a[..., ::-1][..., ::-1],
    "columns": lambda a: np.asfortranarray(a),
    "read-only": lambda a: _frozen(a),
    "every second": lambda a: np.repeat(a, 2, axis=0)[::2],
    "across words": lambda a: _unaligned(a),
    "the other order of bytes": lambda a: a.astype(a.dtype.newbyteorder()),
}


def _frozen(array):
    array = array.copy()
    array.setflags(write=False)
    return array


def _unaligned(array):
    """Numbers at an odd place, as in a packed record."""
    moved = np.empty(array.nbytes + 1, np.uint8)[1:].view(array.dtype).reshape(array.shape)
    moved[...] = array
    assert not moved.flags.aligned
    return moved


@pytest.mark.parametrize("view", VIEWS)
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_how_numbers_lie_in_memory_changes_nothing(view, dtype):
    c = np.random.default_rng(0).normal(size=(7, 16)).astype(dtype)
    # No window helps a function whose mean is negative.
    c[:, 0] = 1
    seen = VIEWS[view](c)
    d = np.random.default_rng(1).normal(size=(5, 3))
    np.testing.assert_array_equal(lobe.Sh(seen).eval(d), lobe.Sh(c).eval(d))
    np.testing.assert_array_equal(lobe.Sh(c).eval(VIEWS[view](d)), lobe.Sh(c).eval(d))
    np.testing.assert_array_equal(np.asarray(lobe.Sh(seen).dering()), np.asarray(lobe.Sh(c).dering()))
    image = np.random.default_rng(2).random((4, 8, 3)).astype(dtype)
    np.testing.assert_array_equal(lobe.EnvMap(VIEWS[view](image)).texels, lobe.EnvMap(image).texels)
    np.testing.assert_array_equal(lobe.project(VIEWS[view](image), 3).coefficients, lobe.project(image, 3).coefficients)


def test_batches_without_functions_have_results_without_values():
    none = lobe.Sh(np.ones((0, 9)))
    assert none.eval([0, 0, 1]).shape == (0,) and none.rotate(np.eye(3)).shape == (0,)
    assert none.encode("zh3").shape == (0,) and none.log().shape == (0,) and len(none) == 0 and list(none) == []
