"""Trees for the tests of this folder."""

import numpy as np
from hypothesis import strategies as st

from kb.clouds.lobes import Branch, Lobe


def turn(axis: int, angle: float):
    c, s = np.cos(angle), np.sin(angle)
    i, j = [k for k in range(3) if k != axis]
    R = np.eye(3)
    R[i, i], R[i, j], R[j, i], R[j, j] = c, -s, s, c
    return R


def seen(kind: str = "l_junction", axis=(0, 0, 1)) -> Branch:
    return Branch("appearance", "", kind, lobe=Lobe(np.array(axis, dtype=float), 1.0, 0.2, 20.0))


def feature(name: str, kind: str = "corner", **more) -> Branch:
    return Branch("feature", name, kind, **({"parts": [seen()]} | more))


def part(name: str, *parts: Branch, **more) -> Branch:
    return Branch("object", name, name, parts=parts, **more)


@st.composite
def trees(draw, depth: int = 4):
    """A random object: parts in parts, features, compounds, appearances; each step moved and turned."""

    def step():
        numbers = st.floats(-3, 3, allow_nan=False)
        return {
            "at": draw(st.tuples(numbers, numbers, numbers)),
            "rotation": turn(draw(st.integers(0, 2)), draw(numbers)),
        }

    def grow(kind: str, name: str, left: int) -> Branch:
        below = {"object": ["object", "feature"], "feature": ["feature", "appearance"]}[kind]
        inner = draw(st.sampled_from(below)) if left else None
        size = draw(st.integers(0, 3)) if inner else 0
        if inner == "appearance":
            return Branch(kind, name, kind, parts=[seen() for _ in range(size)], **step())
        return Branch(kind, name, kind, parts=[grow(inner, f"n{i}", left - 1) for i in range(size)], **step())

    root = grow("object", "thing", depth)
    return Branch("object", "thing", "thing", parts=root.parts)
