"""Area lights against quadrature in numpy, identities, and the command."""

import numpy as np
import pytest

import lobe
from command import lobe_json

CENTER = (0.3, -0.2, 2.0)
LIGHTS = {
    f"sphere --center {CENTER} --radius 0.5": lobe.AreaLight.sphere(CENTER, 0.5),
    f"disc --center {CENTER} --shines (0,0.3,-1) --radius 0.7": lobe.AreaLight.disc(CENTER, (0, 0.3, -1), 0.7),
    f"rectangle --center {CENTER} --u (0.5,0,0.1) --v (0,-0.8,0)": lobe.AreaLight.rectangle(CENTER, (0.5, 0, 0.1), (0, -0.8, 0)),
    "polygon --vertex (0,0,1) --vertex (0,1,1.5) --vertex (1,0,1)": lobe.AreaLight.polygon([(0, 0, 1), (0, 1, 1.5), (1, 0, 1)]),
}


def places_and_normals(count):
    random = np.random.default_rng(0)
    return random.normal(size=(count, 3)) - [0, 0, 1.5], random.normal(size=(count, 3))


def test_a_rectangle_sends_what_quadrature_over_it_says():
    u, v = np.array([0.5, 0, 0.1]), np.array([0, -0.8, 0])
    light = lobe.AreaLight.rectangle(CENTER, u, v)
    x, w = np.polynomial.legendre.leggauss(40)
    points = np.array(CENTER) + x[:, None, None] * u + x[None, :, None] * v
    shines = np.cross(u, v)
    areas = np.outer(w, w) * np.linalg.norm(shines)
    shines = shines / np.linalg.norm(shines)
    for place, normal in zip(*places_and_normals(20)):
        n = normal / np.linalg.norm(normal)
        towards = points - place
        d = np.linalg.norm(towards, axis=-1)
        front = np.maximum(-(towards @ shines) / d, 0)
        expected = [np.sum(areas * front * (towards @ axis) / d / d**2) for axis in np.eye(3)]
        np.testing.assert_allclose(light.vector_irradiance(place), expected, rtol=1e-9, atol=1e-12)
        if (towards @ n > 0).all():
            np.testing.assert_allclose(light.irradiance(place, n), n @ expected, rtol=1e-9, atol=1e-12)


def test_a_ball_overhead_sends_pi_times_the_squared_sine():
    light = lobe.AreaLight.sphere((0, 0, 3), 0.6)
    np.testing.assert_allclose(light.irradiance((0, 0, 0)), np.pi * 0.2**2, rtol=1e-14)
    np.testing.assert_allclose(light.as_beam((0, 0, 0)), np.pi * 0.2**2, rtol=1e-14)


@pytest.mark.parametrize("words", LIGHTS)
def test_the_vector_is_the_difference_of_both_sides(words):
    light = LIGHTS[words]
    places, normals = places_and_normals(50)
    both = light.irradiance(places, normals) - light.irradiance(places, -normals)
    unit = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    np.testing.assert_allclose(np.sum(light.vector_irradiance(places) * unit, axis=1), both, atol=1e-12)


@pytest.mark.parametrize("words", LIGHTS)
def test_the_command_finds_the_same_irradiance(words):
    light = LIGHTS[words]
    place, normal, reference = (0.2, 0.1, -0.4), (0.1, 0.3, 1.0), (0.0, 0.0, 0.1)
    text = f"env area-light {words.replace(', ', ',')} --at {place} --normal {normal} --reference {reference}"
    told = lobe_json(text.replace(", ", ",").replace("(", "").replace(")", ""))
    found = {
        "irradiance": light.irradiance(place, normal),
        "vector": light.vector_irradiance(place),
        "point": light.as_point(place, normal),
        "directional": light.as_beam(reference, normal),
    }
    for name, values in found.items():
        np.testing.assert_array_equal(values, told[name], err_msg=name)


def test_places_and_normals_broadcast():
    light = LIGHTS[next(iter(LIGHTS))]
    places, normals = places_and_normals(4)
    found = light.irradiance(places[:, None], normals[None, :3])
    assert found.shape == (4, 3)
    np.testing.assert_array_equal(found[2, 1], light.irradiance(places[2], normals[1]))
    assert light.irradiance(np.empty((0, 3))).shape == (0,) and light.vector_irradiance(places[:, None]).shape == (4, 1, 3)


def test_lights_and_places_that_cannot_be_are_refused():
    ball = lobe.AreaLight.sphere((0, 0, 0), 1.0)
    for call, error, message in [
        (lambda: ball.irradiance([(0, 0, 2), (0, 0.5, 0)]), ValueError, r"expected some outside of the ball, found \[0.0, 0.5, 0.0\], number 1"),
        (lambda: ball.irradiance((0, 0)), ValueError, "at: expected an array of shape"),
        (lambda: ball.irradiance((0, 0, 2), (0, 0, 0)), ValueError, "expected vectors with a length"),
        (lambda: ball.irradiance(np.ones((2, 3)), np.ones((3, 3))), ValueError, "expected shapes that broadcast"),
        (lambda: lobe.AreaLight.sphere((0, 0, 0), 0), ValueError, "radius"),
        (lambda: lobe.AreaLight.sphere((0, 0), 1), ValueError, "center: expected three numbers"),
        (lambda: lobe.AreaLight.polygon([(0, 0, 0), (1, 0, 0)]), ValueError, "three vertices at least"),
        (lambda: lobe.AreaLight.disc((0, 0, 0), [(0, 0, 1)], 1), ValueError, "shines: expected one direction"),
        (lambda: lobe.AreaLight(), TypeError, "expected AreaLight.sphere"),
    ]:
        with pytest.raises(error, match=message):
            call()
