"""Windows and exponentials with the options of the command."""

import numpy as np
import pytest

import lobe
from command import lobe_command


def light(order=5):
    c = np.random.default_rng(0).normal(size=(order**2, 3))
    c[0] = 3.0
    return lobe.Sh(c)


@pytest.mark.parametrize(
    "words, arguments",
    [
        ("--kind hanning", (("hanning",), {})),
        ("--kind lanczos", (("lanczos",), {})),
        ("--kind sinc4", (("sinc4",), {})),
        ("--kind sinc4 --width 7", (("sinc4:7",), {})),
        ("--kind lanczos --width 7 --power 2.5", (("lanczos:7:2.5",), {})),
        ("--kind lanczos --power 2.5", (("lanczos",), {"power": 2.5})),
        ("--kind lanczos --power 2.5 --peak 1.25", (("lanczos",), {"power": 2.5, "peak": 1.25})),
        ("--kind horizon", (("horizon",), {})),
        ("--kind hanning --peak 1.5", (("hanning",), {"peak": 1.5})),
        ("--kind lanczos --peak 1.25", (("lanczos",), {"peak": 1.25})),
        ("--kind sinc4 --peak 1 --content", (("sinc4",), {"peak": 1.0, "content": True})),
        ("--kind gauss --width 20", ((f"gauss:{np.radians(20)}",), {})),
        ("--kind laplacian --lambda 0.01", (("squared-laplacian:0.01",), {})),
        ("--kind laplacian --keep 0.3", (("squared-laplacian",), {"keep": 0.3})),
        ("--kind punctual", (("punctual-light",), {})),
        ("--kind hanning --content", (("hanning",), {"content": True})),
        ("--kind lanczos --content --order 8", (("lanczos",), {"content": True, "order": 8})),
    ],
)
def test_the_command_makes_the_same_function(words, arguments, tmp_path):
    f = light()
    f.save(tmp_path / "f.sh.json")
    lobe_command("sh window", tmp_path / "f.sh.json", words, "-o", tmp_path / "g.sh.json")
    (names, options) = arguments
    expected = lobe.Sh.load(tmp_path / "g.sh.json").coefficients
    np.testing.assert_allclose(f.window(*names, **options).coefficients, expected, rtol=1e-12, atol=1e-13)


def test_a_window_leaves_the_part_of_the_squared_laplacian_that_was_asked_of_each():
    c = np.random.default_rng(1).normal(size=(4, 36, 3)) * np.array([1, 5, 0.1, 2])[:, None, None]
    f = lobe.Sh(c)
    eigenvalue = np.array([(l * (l + 1)) ** 2 for l in range(6) for _ in range(2 * l + 1)])[:, None]
    before, after = (np.sum(eigenvalue * g.coefficients**2, axis=(1, 2)) for g in (f, f.window("squared-laplacian", keep=0.4)))
    np.testing.assert_allclose(after / before, 0.4, rtol=1e-10)


def test_a_window_of_the_content_leaves_the_peak_and_calms_the_far_side():
    sun = lobe.light("directional", 6, direction=(1, 0, 0), normalize="none")
    blend, plain = sun.window("hanning", content=True, order=12), sun.window("hanning")
    peak = sun.eval([1, 0, 0])
    np.testing.assert_allclose(blend.eval([1, 0, 0]), peak, rtol=2e-2)
    assert (plain.eval([1, 0, 0]) < 0.5 * peak).all()
    behind = lobe.Sh(sun.coefficients - blend.resized(6).coefficients).eval([-1, 0, 0])
    assert (np.abs(blend.eval([-1, 0, 0]) - plain.eval([-1, 0, 0])) < 0.2 * np.abs(behind) + 0.05).all()


@pytest.mark.parametrize("method", ["grid", "optimal-linear", "hybrid", "hybrid:4.8", "series:12", "eigen"])
def test_the_command_takes_the_exponential_by_the_same_method(method, tmp_path):
    log = lobe.Sh(np.array([-0.5, 0.1, -0.2, 0.05, 0.02, 0.0, 0.03, -0.04, 0.01]))
    log.save(tmp_path / "q.sh.json", "log-visibility")
    lobe_command("sh exp", tmp_path / "q.sh.json", f"--method {method} -o", tmp_path / "p.sh.json")
    np.testing.assert_array_equal(log.exp(method).coefficients, lobe.Sh.load(tmp_path / "p.sh.json", "visibility").coefficients)


def test_a_series_of_many_terms_comes_to_the_eigenvectors():
    f = light(4)
    np.testing.assert_allclose(f.exp("series:60").coefficients, f.exp("eigen").coefficients, rtol=1e-6, atol=1e-9)


def test_options_that_contradict_each_other_are_refused():
    f = light()
    for call, error, message in [
        (lambda: f.window("hanning", keep=0.5), ValueError, "keep: only of the window squared-laplacian"),
        (lambda: f.window("squared-laplacian", keep=0.0), ValueError, "keep: expected a number above 0"),
        (lambda: f.window("squared-laplacian"), ValueError, "expected hanning:WIDTH"),
        (lambda: f.window("gauss:0.2", peak=1.0), ValueError, "peak: only of the windows hanning"),
        (lambda: f.window("hanning", peak=2.0), ValueError, "peak: expected a value between 0.079577 and 1.989437 at order 5"),
        (lambda: f.window("hanning", peak=1.0, keep=0.5), ValueError, "keep: only of the window squared-laplacian"),
        (lambda: f.window("hanning", order=8), ValueError, "order: only with content"),
        (lambda: f.window("hanning", power=2.0), ValueError, "power: only of the window lanczos without a width, and above 0"),
        (lambda: f.window("lanczos:7", power=2.0), ValueError, "power: only of the window lanczos without a width"),
        (lambda: f.window("lanczos", power=0.0), ValueError, "power: only of the window lanczos without a width, and above 0"),
        (lambda: f.window(np.ones(5), power=2.0), ValueError, "power: only of the window lanczos"),
        (lambda: f.window("lanczos", power=0.01, peak=1.5), ValueError, "no width of this window has the peak 1.5; take a larger power"),
        (lambda: f.window("horizon", content=True), ValueError, "content: horizon knows no light"),
        (lambda: f.dering(3), TypeError, "method: expected a name"),
        (lambda: f.peaks("all"), ValueError, "search: expected grid or paper, found"),
        (lambda: f.peaks(3), TypeError, "search: expected grid or paper"),
        (lambda: f.window(np.ones(5), content=True), TypeError, "expected the name of a window with content"),
        (lambda: f.exp("best"), ValueError, "expected grid, optimal-linear"),
        (lambda: f.exp("series:0"), ValueError, "a number of terms from 1 to 100"),
        (lambda: f.exp(3), TypeError, "method: expected a name"),
    ]:
        with pytest.raises(error, match=message):
            call()
