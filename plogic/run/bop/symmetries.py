"""Symmetries of ``models_info.json`` as motions: the discrete ones, and the continuous ones in steps.

Hodaň et al., BOP Challenge 2020 on 6D Object Localization (ECCVW 2020), §2.2: continuous symmetries are discretised
such that the vertex farthest from the axis travels no more than ``step`` of the diameter between two turns; half a
circle of the diameter as its diameter is the bound, so that ⌈π / step⌉ turns serve every object.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from geometry.frames import from_rotation_translation, rotation_from_quat_xyzw
from plogic.base.errors import InputError
from plogic.run.bop.json_files import MM, member, motion, numbers

if TYPE_CHECKING:
    from numpy.typing import NDArray

STEP = 0.01
"""``max_sym_disc_step`` of the BOP challenge: 315 turns about an axis of continuous symmetry."""


def symmetry_motions(info: object, place: str, step: float = STEP) -> NDArray[np.float64]:
    """The motions (S, 4, 4), metres, object frame, of one model's entry; the identity is among them.

    Every discretised turn after every discrete motion; turns about two axes are not multiplied, as in the benchmark.
    Raises InputError.
    """
    discrete = np.array([np.eye(4), *_discrete(info, place)])
    turns = _turns(info, place, step)
    return discrete if not len(turns) else np.asarray(turns[None] @ discrete[:, None]).reshape(-1, 4, 4)


def _discrete(info: object, place: str) -> list[NDArray[np.float64]]:
    motions = []
    for i, entry in enumerate(_entries(info, "symmetries_discrete", place)):
        at = f"{place}.symmetries_discrete.{i}"
        rows = numbers(entry, 16, at).reshape(4, 4)
        motions.append(motion(rows[:3, :3].ravel(), rows[:3, 3], at))
    return motions


def _turns(info: object, place: str, step: float) -> NDArray[np.float64]:
    """Turns (S, 4, 4) about each continuous axis, angle 0 first; none without one."""
    count = math.ceil(math.pi / step)
    half = np.arange(count) * (math.pi / count)
    turns = [np.zeros((0, 4, 4))]
    for i, entry in enumerate(_entries(info, "symmetries_continuous", place)):
        at = f"{place}.symmetries_continuous.{i}"
        axis = numbers(member(entry, "axis", at), 3, f"{at}.axis")
        offset = numbers(member(entry, "offset", at), 3, f"{at}.offset") / MM
        if not np.linalg.norm(axis) > 0:
            raise InputError(f"{at}.axis: must not be zero")
        quat = np.concatenate([np.sin(half)[:, None] * axis / np.linalg.norm(axis), np.cos(half)[:, None]], axis=1)
        R = rotation_from_quat_xyzw(quat)
        turns.append(from_rotation_translation(R, offset - R @ offset))
    return np.concatenate(turns)


def _entries(info: object, key: str, place: str) -> list[Any]:
    if not isinstance(info, dict):
        raise InputError(f"{place}: must be an object, not {info!r:.60}")
    value = info.get(key, [])
    if not isinstance(value, list):
        raise InputError(f"{place}.{key}: must be a list, not {value!r:.60}")
    return value
