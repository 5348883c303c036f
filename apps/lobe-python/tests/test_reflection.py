"""Directional albedos and the DFG terms: closed forms, quadrature, each other, and the command."""

import numpy as np
import pytest

import lobe
from command import lobe_command, lobe_json


def read_pfm(path):
    """The texels of a .pfm of colors, row 0 on top."""
    kind, size, scale, numbers = path.read_bytes().split(b"\n", 3)
    width, height = (int(side) for side in size.split())
    assert kind == b"PF" and float(scale) < 0, (kind, scale)
    return np.frombuffer(numbers, "<f4").reshape(height, width, 3)[::-1]


def test_a_rough_white_metal_keeps_what_its_closed_form_says():
    a, b = lobe.dfg(1.0, 1.0)
    assert abs(a + b - (1 - np.log(2))) < 1e-13, (a, b)


def test_arguments_broadcast_and_each_pair_has_its_own_terms():
    cosines, widths = np.array([0.2, 0.5, 0.9]), np.array([[0.1], [0.6]])
    found = lobe.dfg(cosines, widths)
    assert found.shape == (2, 3, 2) and found.dtype == np.float64
    for i, alpha in enumerate(widths[:, 0]):
        for j, cosine in enumerate(cosines):
            np.testing.assert_array_equal(found[i, j], lobe.dfg(cosine, alpha))
    assert lobe.dfg(np.empty((0, 3)), 0.5).shape == (0, 3, 2)


def test_the_table_holds_the_terms_at_the_centers_and_is_that_of_the_command(tmp_path):
    table, size = lobe.dfg_table(6), 6
    at = (np.arange(size) + 0.5) / size
    np.testing.assert_array_equal(table, lobe.dfg(at[None, :], at[:, None] ** 2))
    lobe_command("env dfg --size 6 -o", tmp_path / "t.pfm")
    expected = read_pfm(tmp_path / "t.pfm")
    np.testing.assert_array_equal(table.astype(np.float32), expected[..., :2])
    assert not expected[..., 2].any()


def test_what_ggx_reflects_is_its_split_sum():
    cosines, alpha = np.linspace(0.05, 1, 9), np.array([[0.1], [0.3], [1.0]])
    f0 = 0.3
    a, b = np.moveaxis(lobe.dfg(cosines, alpha), -1, 0)
    np.testing.assert_allclose(lobe.directional_albedo("ggx", cosines, alpha=alpha, f0=f0), f0 * a + b, rtol=1e-13)


def test_what_phong_reflects_is_the_integral_of_its_lobe():
    exponent, theta_v = 5.0, np.radians(50.0)
    x, w = np.polynomial.legendre.leggauss(200)
    z, wz = 0.5 * (x + 1), 0.5 * w
    phi = 2 * np.pi * np.arange(400) / 400
    r = np.sqrt(1 - z**2)
    light = np.stack([np.outer(r, np.cos(phi)), np.outer(r, np.sin(phi)), np.outer(z, np.ones_like(phi))], axis=-1)

    def integral(view):
        mirrored = np.array([-np.sin(view), 0, np.cos(view)])
        lobe_values = np.maximum(light @ mirrored, 0) ** exponent
        return np.sum(lobe_values * z[:, None] * wz[:, None]) * 2 * np.pi / len(phi)

    # Along the normal all of the light is sent back, which says by what the lobe is scaled.
    found = lobe.directional_albedo("phong", [np.cos(theta_v), 1.0], exponent=exponent)
    np.testing.assert_allclose(found, [integral(theta_v) / integral(0.0), 1.0], rtol=1e-5)


@pytest.mark.parametrize(
    "text, brdf, parameters",
    [
        ("lambert:0.5", "lambert", {"albedo": 0.5}),
        ("phong:20", "phong", {"exponent": 20.0}),
        ("ggx:0.25,0.04", "ggx", {"alpha": 0.25, "f0": 0.04}),
    ],
)
def test_the_command_finds_the_same_reflectance(text, brdf, parameters):
    views = [0.0, 30.0, 75.0]
    told = lobe_json(f"env ambient --brdf {text}", *(f"--view {view}" for view in views))
    expected = [view["reflectance"] for view in told["views"]]
    np.testing.assert_array_equal(lobe.directional_albedo(brdf, np.cos(np.radians(views)), **parameters), expected)


def test_what_no_surface_does_is_refused():
    for call, error, message in [
        (lambda: lobe.dfg(1.5, 0.5), ValueError, "cos_view: expected numbers of 0 to 1, found 1.5"),
        (lambda: lobe.dfg(0.5, [0.1, np.nan]), ValueError, "alpha: expected finite numbers"),
        (lambda: lobe.dfg_table(2000), ValueError, "size: expected 1 to 1024"),
        (lambda: lobe.directional_albedo("matte", 1.0), ValueError, "brdf: expected lambert, phong, ggx"),
        (lambda: lobe.directional_albedo("ggx", 1.0, alpha=0.5), TypeError, "expected alpha and f0, found alpha"),
        (lambda: lobe.directional_albedo("ggx", 1.0, alpha=0.0, f0=1.0), ValueError, "alpha: expected numbers above 0"),
        (lambda: lobe.directional_albedo("lambert", 1.0, albedo=[0.5, 2.0]), ValueError, "albedo: expected numbers of 0 to 1, found 2"),
    ]:
        with pytest.raises(error, match=message):
            call()
