"""Tone curves of Lobe beside those of three.js, whose shader is run here on numbers.

    npm pack three@0.187.0 && tar xzf three-0.187.0.tgz && python tone.py package

Needs the package lobe. The chunk `tonemapping_pars_fragment` of three.js is read as Python: statements are the same in both
languages, except for types, semicolons and the conditional. Bytes of planted colors differ by no more than one.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

import lobe
import numpy as np

CHUNK = "src/renderers/shaders/ShaderChunk/tonemapping_pars_fragment.glsl.js"

CURVES = {"aces": "ACESFilmicToneMapping", "agx": "AgXToneMapping", "neutral": "NeutralToneMapping"}


class Matrix:
    """A matrix of GLSL, made of its columns."""

    def __init__(self, *columns: object) -> None:
        self.rows = np.array(columns, dtype=float).reshape(3, 3).T

    def __mul__(self, v: np.ndarray) -> np.ndarray:
        return self.rows @ v


BUILT_IN = {
    "vec3": lambda *c: np.full(3, float(c[0])) if len(c) == 1 else np.array(c, dtype=float),
    "mat3": Matrix,
    "saturate": lambda x: np.clip(x, 0.0, 1.0),
    "clamp": np.clip,
    "log2": np.log2,
    "pow": np.power,
    "min": np.minimum,
    "max": np.maximum,
    "mix": lambda a, b, t: a + (b - a) * t,
    "toneMappingExposure": 1.0,
}


def python(statement: str) -> str:
    """A statement of GLSL in Python."""
    line = re.sub(r"\b(?:const )?(?:vec3|mat3|float) (?=\w+ =)", "", " ".join(statement.split()))
    line = re.sub(r"\.([rgb])\b", lambda m: f"[{'rgb'.index(m[1])}]", line)
    line = re.sub(r"= (.+) \? (.+) : (.+)", r"= (\2) if (\1) else (\3)", line)
    return re.sub(r"^if \( (.*?) \) return", r"if \1: return", line)


def functions(source: str) -> dict[str, object]:
    """The functions of a chunk of GLSL, which call each other, on numbers and vectors of double precision."""
    body = source[source.index("`") + 1 : source.rindex("`")]
    body = re.sub(r"//[^\n]*|^#[^\n]*|^uniform[^\n]*", "", body, flags=re.M)
    names = dict(BUILT_IN)
    rest = re.sub(r"vec3 \w+\( vec3 \w+ \) \{.*?\n?\}", "", body, flags=re.S)
    for constant in filter(None, map(str.strip, rest.split(";"))):
        exec(python(constant), names)
    for name, argument, text in re.findall(r"vec3 (\w+)\( vec3 (\w+) \) \{(.*?)\}", body, re.S):
        lines = [f"    {python(statement)}" for statement in text.split(";") if statement.strip()]
        exec("\n".join([f"def {name}({argument}):", *lines]), names)
    return names


def planted() -> np.ndarray:
    """Grays and saturated colors of many stops."""
    random = np.random.default_rng(5)
    grays = np.repeat(np.exp2(np.linspace(-8, 6, 64))[:, None], 3, axis=1)
    colors = np.exp2(random.uniform(-6, 5, (4032, 1))) * random.uniform(0, 1, (4032, 3))
    return np.concatenate([grays, colors])


def srgb(linear: np.ndarray) -> np.ndarray:
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * np.maximum(linear, 1e-9) ** (1 / 2.4) - 0.055)


def main() -> int:
    three = functions((Path(sys.argv[1]) / CHUNK).read_text())
    colors = planted().astype(np.float32)
    worst = 0
    print("curve     bytes differ by   light 0.18 is shown as   orange 2, 0.5, 0.1 as")
    for tone, name in CURVES.items():
        curve = three[name]
        expected = np.clip([curve(color.astype(float)) for color in colors], 0.0, 1.0)
        found = lobe.tone_mapped(colors[None], tone=tone, exposure=0)[0]
        off = int(np.abs(found - np.round(255 * srgb(expected))).max())
        gray, orange = (np.clip(curve(np.array(c)), 0.0, 1.0) for c in ([0.18] * 3, [2.0, 0.5, 0.1]))
        print(f"{tone:<9} {off:>15}   {gray[1]:.6f}                 {', '.join(f'{c:.6f}' for c in orange)}")
        worst = max(worst, off)
    return int(worst > 1)


if __name__ == "__main__":
    sys.exit(main())
