"""Functions on the sphere against scipy and quadrature."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import lobe
from command import lobe_command, lobe_json
from oracles import basis, directions, quadrature, rotation


def random(shape, seed=1, dtype=np.float64):
    return np.random.default_rng(seed).normal(size=shape).astype(dtype)


@pytest.mark.parametrize("order", [1, 2, 3, 4, 6, 10, 16])
def test_values_are_those_of_the_harmonics_of_scipy(order):
    d, c = directions(200), random((5, order**2))
    expected = c @ basis(order, d).T
    np.testing.assert_allclose(lobe.Sh(c).eval(d), expected, atol=1e-12 * order**2)
    single = lobe.Sh(c.astype(np.float32)).eval(d)
    assert single.dtype == np.float32
    np.testing.assert_allclose(single, expected, atol=2e-5 * order)
    # One function takes another way through the kernels than several.
    np.testing.assert_allclose(lobe.Sh(c[0]).eval(d), expected[0], atol=1e-12 * order**2)


def test_more_directions_than_a_block_have_their_values():
    d, c = directions(3000), random((2, 9))
    np.testing.assert_allclose(lobe.Sh(c).eval(d), c @ basis(3, d).T, atol=1e-12)
    np.testing.assert_allclose(lobe.Sh(c[1]).eval(d), c[1] @ basis(3, d).T, atol=1e-12)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize(("functions", "m", "tail"), [(1, 75, ()), (7, 2500, ()), (1030, 2100, ()), (1, 33, (3,)), (5, 2077, (3,))])
def test_a_value_is_the_same_whatever_else_is_computed(functions, m, tail, dtype):
    c = np.random.default_rng(5).normal(size=(functions, 9, *tail)).astype(dtype)
    d = directions(m)
    values = lobe.Sh(c).eval(d)
    expected = np.einsum("fi...,mi->fm...", c.astype(float), basis(3, d))
    np.testing.assert_allclose(values, expected, atol=1e-13 if dtype == np.float64 else 2e-5)
    for k in {0, functions // 2, functions - 1}:
        np.testing.assert_array_equal(lobe.Sh(c[k]).eval(d), values[k])


@settings(max_examples=40, deadline=None)
@given(
    batch=st.lists(st.integers(0, 3), max_size=3),
    order=st.integers(1, 6),
    is_color=st.booleans(),
    points=st.lists(st.integers(0, 3), max_size=2),
    single=st.booleans(),
    seed=st.integers(0, 1000),
)
def test_every_shape_has_the_values_of_its_functions_one_by_one(batch, order, is_color, points, single, seed):
    dtype = np.float32 if single else np.float64
    c = random((*batch, order**2, *([3] if is_color else [])), seed, dtype)
    d = random((*points, 3), seed + 1)
    f = lobe.Sh(c)
    values = f.eval(d)
    assert f.shape == tuple(batch) and f.order == order and f.is_color == is_color
    assert values.shape == (*batch, *points, *([3] if is_color else [])) and values.dtype == dtype
    unit = (d / np.linalg.norm(d, axis=-1, keepdims=True)).reshape(-1, 3)
    y = basis(order, unit)
    expected = np.einsum("...ic,ki->...kc", c, y) if is_color else np.einsum("...i,ki->...k", c, y)
    np.testing.assert_allclose(values.reshape(expected.shape), expected, atol=2e-5 if single else 1e-12)


@settings(max_examples=30, deadline=None)
@given(order=st.integers(1, 8), is_color=st.booleans(), single=st.booleans(), seed=st.integers(0, 1000))
def test_a_turned_function_has_towards_r_s_what_it_had_towards_s(order, is_color, single, seed):
    dtype = np.float32 if single else np.float64
    f = lobe.Sh(random((4, order**2, *([3] if is_color else [])), seed, dtype))
    d, r = directions(20, seed), rotation(seed)
    turned = f.rotate(r)
    assert turned.dtype == dtype and turned.shape == (4,)
    np.testing.assert_allclose(turned.eval(d @ r.T), f.eval(d), atol=2e-4 if single else 1e-11)


@settings(max_examples=30, deadline=None)
@given(a=st.integers(1, 5), b=st.integers(1, 5), out=st.integers(1, 8), seed=st.integers(0, 1000))
def test_products_are_their_projections(a, b, out, seed):
    f, g = lobe.Sh(random((2, a**2), seed)), lobe.Sh(random((2, b**2), seed + 1))
    d, w = quadrature(a + b + out)
    expected = (f.eval(d) * g.eval(d) * w) @ basis(out, d)
    np.testing.assert_allclose(np.asarray(f.product(g, out)), expected, atol=1e-12 * (a + b) ** 2)


@pytest.mark.parametrize("order", [1, 2, 3, 4, 6, 7, 10, 11])
@pytest.mark.parametrize("channels", [(), (3,)])
@pytest.mark.parametrize("rows", [9, 65, 300])
@pytest.mark.parametrize("verb", ["rotate", "product"])
def test_batches_of_single_precision_are_those_of_double_precision_wherever_a_function_is(verb, order, channels, rows):
    a, b = (random((rows, order**2, *channels), seed) for seed in (5, 6))
    a[4] = np.nan

    def work(f, g):
        return (lobe.Sh(f).rotate(rotation(7)) if verb == "rotate" else lobe.Sh(f).product(lobe.Sh(g))).coefficients

    single = [c.astype(np.float32) for c in (a, b)]
    found, expected = work(*single), work(a, b)
    assert found.dtype == np.float32 and found.shape == expected.shape
    np.testing.assert_array_equal(np.isnan(found).any(axis=1), np.isnan(expected).any(axis=1))
    finite = np.arange(rows) != 4
    assert np.abs(found - expected)[finite].max() < 2e-6 * order * np.abs(expected[finite]).max()
    # At other places of blocks of another length: the same bytes.
    others = [np.concatenate([c[1:], c]) for c in single]
    np.testing.assert_array_equal(work(*others)[: rows - 1], found[1:])


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("tail", [(16,), (16, 3)])
def test_one_function_is_done_as_the_first_of_two(dtype, tail):
    c = random((2, *tail), 3, dtype)
    for work in (lambda f: f.rotate(rotation(4)), lambda f: f.product(f), lambda f: f.convolve("cosine")):
        one, both = work(lobe.Sh(c[0])), work(lobe.Sh(c))
        assert one.dtype == dtype and one.shape == ()
        np.testing.assert_array_equal(one.coefficients, both.coefficients[0])


def test_batches_broadcast_and_numbers_multiply_colors():
    gray, color = lobe.Sh(random((5, 1, 9))), lobe.Sh(random((4, 9, 3)))
    product = gray.product(color)
    assert product.shape == (5, 4) and product.is_color
    one = lobe.Sh(gray.coefficients[2, 0]).product(lobe.Sh(color.coefficients[3, :, 1]))
    np.testing.assert_allclose(product.coefficients[2, 3, :, 1], one.coefficients, atol=1e-13)


def test_kernels_multiply_bands():
    f = lobe.Sh(random(16))
    d, w = quadrature(20)
    # The convolution with the clamped cosine towards z is the integral under it; two bands beyond the order suffice to no rule, so finer.
    fine, weights = quadrature(400)
    irradiance = np.sum(f.eval(fine) * np.maximum(fine[:, 2], 0) * weights)
    assert abs(f.convolve("cosine").eval([0, 0, 1]) - irradiance) < 1e-4
    np.testing.assert_allclose(f.convolve([1, 1, 1, 1]).coefficients, f.coefficients, atol=1e-15)
    np.testing.assert_allclose(f.convolve("phong", 1).coefficients * np.pi, f.convolve("cosine").coefficients, atol=1e-13)
    np.testing.assert_allclose(f.convolve("ggx", 0.0).coefficients, f.coefficients, atol=1e-13)
    assert f.window("hanning:4").band_energies()[3] < f.band_energies()[3]
    assert len(w) == len(d)


def test_dering_leaves_no_point_below_zero_and_the_mean():
    # The irradiance of a sun of order 3 rings.
    sun = lobe.Sh(basis(3, np.array([[0.0, 0.6, 0.8]]))[0]).convolve("cosine")
    assert sun.eval(directions(2000)).min() < -0.02
    clean = sun.dering()
    assert clean.eval(directions(2000)).min() > -1e-6
    np.testing.assert_allclose(clean.mean(), sun.mean(), rtol=1e-12)
    # Radiance may stay negative as long as its irradiance is not.
    light = lobe.Sh(basis(3, np.array([[0.0, 0.0, 1.0]]))[0])
    assert light.dering(of_irradiance=True).convolve("cosine").eval(directions(2000)).min() > -1e-6
    with pytest.raises(ValueError, match="positive mean"):
        lobe.Sh([-1.0, 0.5, 0.0, 0.0]).dering()


def test_the_minimum_is_the_least_of_many_values():
    f = lobe.Sh(random((3, 2, 16, 3)))
    values, where, at_least = f.minimum()
    assert values.shape == at_least.shape == (3, 2, 3) and where.shape == (3, 2, 3, 3)
    rms = np.sqrt((f.coefficients**2).sum(axis=-2) / (4 * np.pi))
    assert np.all(at_least <= values) and np.all(values - at_least <= 1.01e-6 * rms)
    sampled = f.eval(directions(20000)).min(axis=-2)
    assert np.all(values <= sampled + 1e-6) and np.all(values > sampled - 0.05 * np.abs(sampled) - 0.05)
    at = lobe.Sh(f.coefficients[1, 0]).eval(where[1, 0, 2])[2]
    assert abs(at - values[1, 0, 2]) < 1e-5


def test_the_closed_bound_is_below_the_minimum_and_that_of_the_command(tmp_path):
    f = lobe.Sh(random((3, 2, 9, 3)))
    bound = f.minimum_bound()
    assert bound.shape == (3, 2, 3) and np.all(bound <= f.minimum().value + 1e-12)
    f[1, 0].save(tmp_path / "f.sh.json")
    told = lobe_json("sh min --bound", tmp_path / "f.sh.json")
    np.testing.assert_array_equal(bound[1, 0], [channel["bound"] for channel in told["channels"]])
    with pytest.raises(ValueError, match="order 3 at most"):
        lobe.Sh(random((16,))).minimum_bound()
    with pytest.raises(ValueError, match="finite"):
        lobe.Sh([np.nan, 0.0, 0.0, 0.0]).minimum_bound()


def test_dering_has_the_short_names_of_the_command(tmp_path):
    f = lobe.EnvMap.bundled("sunset").project(4)
    f.save(tmp_path / "f.sh.json")
    for method in ["sinc4", "laplacian"]:
        lobe_command("sh dering", tmp_path / "f.sh.json", "--method", method, "-o", tmp_path / "g.sh.json")
        found = f.dering(method).coefficients
        np.testing.assert_allclose(found, lobe.Sh.load(tmp_path / "g.sh.json").coefficients, rtol=1e-12, atol=1e-13)


def test_a_planted_light_is_found():
    towards = np.array([0.48, 0.6, 0.64])
    light = 2.5 * basis(4, towards[None])[0] * 4 * np.pi / 10
    color = light[:, None] * np.array([1.0, 0.5, 0.25])
    found = lobe.Sh(color).lights()
    assert found.directions.shape == (1, 3) and found.intensities.shape == (1, 3) and found.ambient.shape == (3,)
    np.testing.assert_allclose(found.directions[0], towards, atol=1e-4)
    np.testing.assert_allclose(found.intensities[0] / found.intensities[0, 0], [1, 0.5, 0.25], rtol=1e-6)
    two = lobe.Sh(np.stack([color, color])).lights(count=3)
    assert two.intensities.shape == (2, 3, 3) and np.all(two.intensities[:, 1:] >= 0)


@pytest.mark.parametrize(("axis", "k"), [("x", 0), ("y", 1), ("z", 2)])
def test_a_mirror_has_the_value_of_the_other_side(axis, k):
    for f in [lobe.Sh(random((2, 25))), lobe.Sh(random((2, 25, 3)).astype(np.float32))]:
        n = directions(50)
        other = n * np.where(np.arange(3) == k, -1.0, 1.0)
        mirrored = f.mirror(axis)
        assert mirrored.dtype == f.dtype
        np.testing.assert_allclose(mirrored.eval(n), f.eval(other), rtol=1e-4, atol=1e-5)
        np.testing.assert_array_equal(mirrored.mirror(axis).coefficients, f.coefficients)
    with pytest.raises(ValueError, match="axis: expected x, y or z, found \"w\""):
        f.mirror("w")


LIGHTS = {
    "--count 3 --refine --metric radiance": {"count": 3, "refine": True, "metric": "radiance"},
    "--count 2 --choose height": {"count": 2, "choose": "height"},
    "--closed": {"closed": True},
    "--count 2 --per-channel": {"count": 2, "per_channel": True},
    "--direction 0,0,1 --direction 3,4,0 --metric radiance": {"directions": [[0, 0, 1], [3, 4, 0]], "metric": "radiance"},
}


@pytest.mark.parametrize("options", LIGHTS)
def test_lights_of_every_option_are_those_of_the_command(tmp_path, options):
    f = lobe.EnvMap.bundled("sunset").project(5)
    f.save(tmp_path / "f.sh.json")
    found = f.lights(**LIGHTS[options])
    expected = lobe_json("sh lights", tmp_path / "f.sh.json", options)
    parts = expected["channels"] if "--per-channel" in options else [expected]
    for c, part in enumerate(parts):
        one = (c,) if "--per-channel" in options else ()
        for k, light in enumerate(part["lights"]):
            np.testing.assert_allclose(found.directions[(*one, k)], light["dir"], atol=1e-9)
            np.testing.assert_allclose(np.ravel(found.intensities[(*one, k)]), light["intensity"], rtol=1e-9)
            np.testing.assert_allclose(np.ravel(found.irradiances[(*one, k)]), light["irradiance"], rtol=1e-9)
        assert not found.intensities[one][len(part["lights"]) :].any()
        np.testing.assert_allclose(np.ravel(found.ambient[one]), part["ambient"], rtol=1e-9)
        np.testing.assert_allclose(np.ravel(found.residual[one]), part["residual"], rtol=1e-6, atol=1e-12)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"metric": "luck"}, "metric: expected irradiance or radiance"),
        ({"choose": "luck"}, "choose: expected"),
        ({"closed": True, "count": 2}, "closed: expected no other"),
        ({"directions": [[0, 0, 1]], "count": 2}, "directions: expected no other option but metric"),
        ({"directions": [0, 0, 1]}, "directions: expected an array of shape"),
        ({"directions": np.zeros((0, 3))}, "directions: expected 1 to 64, found 0"),
        ({"directions": [[0, 0, 0]]}, "directions: expected vectors with a length"),
    ],
)
def test_lights_that_cannot_be_chosen_say_so(options, message):
    with pytest.raises(ValueError, match=message):
        lobe.Sh(random((16,))).lights(**options)


def test_exp_undoes_log_and_sums_become_products():
    # A cap that is open, smoothed so that no eigenvalue reaches the clamp.
    c = np.zeros(16)
    c[0], c[2] = 0.6 * np.sqrt(4 * np.pi), 0.5
    f = lobe.Sh(c)
    np.testing.assert_allclose(f.log().exp().coefficients, c, atol=0.01)
    constant = lobe.Sh([np.log(0.5) * np.sqrt(4 * np.pi), 0, 0, 0])
    np.testing.assert_allclose(constant.exp().coefficients, [0.5 * np.sqrt(4 * np.pi), 0, 0, 0], atol=1e-14)


def test_numpy_sees_the_coefficients_themselves():
    c = random((2, 9))
    f = lobe.Sh(c)
    assert np.asarray(f) is c, "nothing is copied"
    assert np.shares_memory(lobe.Sh(f).coefficients, c)
    np.testing.assert_array_equal(np.array(f + f - f), c)
    np.testing.assert_array_equal((2 * f).coefficients, 2 * c)
    assert f[1].shape == () and f[:, None].shape == (2, 1) and len(f) == 2
    assert repr(f) == "Sh(order 3, float64, shape (2,))"
    assert f.resized(2).coefficients.shape == (2, 4) and f.resized(4).coefficients[0, 9:].tolist() == [0.0] * 7


def test_results_are_the_same_for_any_number_of_functions_at_once():
    c = random((5000, 16, 3), dtype=np.float32)
    all_at_once = lobe.Sh(c).rotate(rotation(3)).coefficients
    one = lobe.Sh(c[4321]).rotate(rotation(3)).coefficients  # without matrices, thus not to the bit
    np.testing.assert_allclose(one, all_at_once[4321], atol=2e-6)
    values = lobe.Sh(c).eval([[0.0, 0.6, 0.8]])
    assert np.array_equal(lobe.Sh(c[4321]).eval([[0.0, 0.6, 0.8]]), values[4321])
