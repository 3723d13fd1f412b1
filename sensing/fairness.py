"""Fair shares of an image: what is taken from all of its parts, so that no textured floor drowns a plain object."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray


def fairly(uv: NDArray[np.float64], cell: float) -> NDArray[np.intp]:
    """(N,) order of what is at places (N, 2), the best first: by turns the best left and the next cell's best left; cells are ``cell`` pixels wide.

    The cells' turns: the first of every cell of the image, then the second of every one, and so on.
    """
    column, row = np.floor(uv / cell).astype(np.intp).T + 1
    number = row * (column.max(initial=0) + 1) + column
    order = np.argsort(number, kind="stable")
    turn, place = np.empty(len(uv), np.intp), np.empty(len(uv), np.intp)
    turn[order] = np.arange(len(uv)) - np.searchsorted(number[order], number[order])
    place[np.argsort(turn, kind="stable")] = np.arange(len(uv))
    return np.argsort(np.minimum(2 * np.arange(len(uv)), 2 * place + 1), kind="stable")
