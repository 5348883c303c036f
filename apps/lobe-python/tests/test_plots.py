"""What a notebook shows."""

import io

import numpy as np
import pytest

import lobe


def test_maps_show_themselves_as_png():
    shown = lobe.EnvMap.bundled("sunset")._repr_png_()
    assert shown.startswith(b"\x89PNG") and len(shown) > 1000
    assert lobe.EnvMap(np.ones((1, 2, 3)))._repr_png_().startswith(b"\x89PNG")


def test_a_function_shows_its_balloon_and_a_batch_its_words():
    pytest.importorskip("matplotlib", reason="matplotlib is not installed")
    shown = lobe.Sh([0.0, 0.0, 2.0, 0.0])._repr_png_()
    assert shown.startswith(b"\x89PNG") and len(shown) > 5000
    assert lobe.Sh(np.ones((4, 3)))._repr_png_().startswith(b"\x89PNG"), "of color"
    assert lobe.Sh(np.ones((2, 4)))._repr_png_() is None


def test_balloons_reach_as_far_as_the_largest_value():
    matplotlib = pytest.importorskip("matplotlib", reason="matplotlib is not installed")
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    ax = lobe.Sh([0.0, 0.0, 2.0, 0.0]).plot()
    assert ax.get_zlim()[1] == pytest.approx(2 * np.sqrt(3 / (4 * np.pi)), rel=1e-6)
    out = io.BytesIO()
    ax.figure.savefig(out)
    assert len(out.getvalue()) > 5000
    plt.close(ax.figure)
    with pytest.raises(ValueError, match="one function"):
        lobe.Sh(np.ones((2, 4))).plot()
