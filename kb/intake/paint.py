"""The paint of all pieces as one OBJ, one MTL and one picture, whatever the source had: the textured mesh that is rendered.

One picture travels as it is. Several, and colours of vertices, become one atlas.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from kb.intake.source import Picture, Piece, Source, pixels, png

Image = NDArray[np.uint8]
Painted = tuple[Piece, NDArray[np.float64]]


WIDEST = 8192
"""Most pixels of an atlas's side; pictures are halved until they fit."""
CELLS = 4096 * 4096
"""Pixels for the colours of vertices."""
MTL = "newmtl painted\nKa 1 1 1\nKd 1 1 1\nKs 0 0 0\nmap_Kd {}\n"


def painted_files(source: Source, scale: float) -> tuple[dict[str, bytes], str]:
    """``textured.obj`` in metres with its material and picture, and a word on the texture.

    No files where nothing is painted.

    ``scale`` is metres per unit of the source.
    """
    pictures = {piece.picture for piece in source.pieces}
    coloured = any(piece.colours is not None and len(np.unique(piece.colours, axis=0)) > 1 for piece in source.pieces)
    if pictures <= {None} and not coloured:
        return {}, "none"
    only = next(iter(pictures))
    if len(pictures) == 1 and only is not None:
        rows = [(p, p.uv) for p in source.pieces if p.uv is not None]
        return _files(rows, only, scale), f"one picture, {only.suffix}, as it is"
    rows, image = _atlas(source.pieces)
    number = len(pictures - {None})
    kinds = f"{number} picture{'s' if number > 1 else ''} and plain colours" if number else "the vertices' colours"
    return _files(rows, png(image), scale), f"{kinds}, in one atlas of {image.shape[1]}x{image.shape[0]} pixels"


def _files(rows: Sequence[Painted], picture: Picture, scale: float) -> dict[str, bytes]:
    name = f"texture.{picture.suffix}"
    return {
        "textured.obj": _obj_text(rows, scale).encode(),
        "textured.mtl": MTL.format(name).encode(),
        name: picture.data,
    }


def _obj_text(rows: Sequence[Painted], scale: float) -> str:
    """Each vertex with its own texture coordinate."""
    lines, first = ["mtllib textured.mtl", "usemtl painted"], 1
    for piece, uv in rows:
        lines += [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in (piece.vertices * scale).tolist()]
        lines += [f"vt {u:.7g} {v:.7g}" for u, v in uv.tolist()]
        lines += [f"f {a}/{a} {b}/{b} {c}/{c}" for a, b, c in (piece.triangles + first).tolist()]
        first += len(piece.vertices)
    return "\n".join(lines) + "\n"


def _atlas(pieces: Sequence[Piece]) -> tuple[list[Painted], Image]:
    """Every piece with its coordinates in one picture: tiles in columns, as high as they come."""
    budget = CELLS // max(1, sum(len(piece.triangles) for piece in pieces if piece.picture is None))
    cells = int(np.clip(np.sqrt(budget), 4, 16))
    pictures = list(dict.fromkeys(piece.picture for piece in pieces if piece.picture is not None))
    tiles: list[Image] = [tile for picture in pictures if (tile := pixels(picture.data)) is not None]
    laid: list[tuple[Piece, NDArray[np.float64], int]] = []
    for piece in pieces:
        if piece.picture is not None and piece.uv is not None:
            laid.append((*_within(piece, piece.uv), pictures.index(piece.picture)))
        else:
            own, uv, tile = _coloured(piece, cells)
            laid.append((own, uv, len(tiles)))
            tiles.append(tile)
    tiles = _fitting(tiles)
    width, height = sum(tile.shape[1] for tile in tiles), max(len(tile) for tile in tiles)
    image, left, rows = np.zeros((height, width, 3), dtype=np.uint8), np.cumsum([0] + [t.shape[1] for t in tiles]), []
    for tile, x in zip(tiles, left, strict=False):
        image[: len(tile), x : x + tile.shape[1]] = tile
    for piece, uv, number in laid:
        high, wide = tiles[number].shape[:2]
        places = np.stack([(left[number] + uv[:, 0] * wide) / width, 1 - (1 - uv[:, 1]) * high / height], axis=1)
        rows.append((piece, places))
    return rows, image


def _within(piece: Piece, uv: NDArray[np.float64]) -> tuple[Piece, NDArray[np.float64]]:
    """The piece with coordinates inside [0, 1], triangle by triangle.

    A triangle that repeats the picture gets its rim's pixels.
    """
    corners = uv[piece.triangles]
    shifted = np.clip(corners - np.floor(corners.mean(axis=1, keepdims=True)), 0.0, 1.0)
    count = 3 * len(piece.triangles)
    apart = replace(
        piece, vertices=piece.vertices[piece.triangles].reshape(-1, 3), triangles=np.arange(count).reshape(-1, 3)
    )
    return apart, shifted.reshape(-1, 2)


def _coloured(piece: Piece, cell: int) -> tuple[Piece, NDArray[np.float64], Image]:
    """A piece without a picture: a cell of the tile for each triangle, its corners' colours blended, or one plain tile."""
    if piece.colours is None:
        tile = np.tile(np.array(piece.colour[::-1], dtype=np.uint8), (8, 8, 1))
        return piece, np.full((len(piece.vertices), 2), 0.5), tile
    number = len(piece.triangles)
    across = int(np.ceil(np.sqrt(number)))
    steps = (np.arange(cell) - 1) / (cell - 3)
    u, v = steps[None, :, None], steps[:, None, None]
    a, b, c = np.moveaxis(piece.colours[piece.triangles].astype(np.float32)[..., ::-1], 1, 0)[:, :, None, None]
    blended = np.clip(a + (b - a) * u + (c - a) * v, 0, 255).astype(np.uint8)
    grid = np.zeros((across * across, cell, cell, 3), dtype=np.uint8)
    grid[:number] = blended
    tile = grid.reshape(across, across, cell, cell, 3).swapaxes(1, 2).reshape(across * cell, across * cell, 3)
    corner = np.stack([np.arange(number) % across, np.arange(number) // across], axis=1) * cell
    spots = corner[:, None] + np.array([[1.5, 1.5], [cell - 1.5, 1.5], [1.5, cell - 1.5]])
    uv = np.stack([spots[..., 0], across * cell - spots[..., 1]], axis=-1).reshape(-1, 2) / (across * cell)
    apart = replace(
        piece, vertices=piece.vertices[piece.triangles].reshape(-1, 3), triangles=np.arange(3 * number).reshape(-1, 3)
    )
    return apart, uv, tile


def _fitting(tiles: list[Image]) -> list[Image]:
    """The tiles, the largest halved until they stand side by side in the widest atlas."""
    import cv2

    while sum(tile.shape[1] for tile in tiles) > WIDEST or max(len(tile) for tile in tiles) > WIDEST:
        largest = max(range(len(tiles)), key=lambda i: max(tiles[i].shape[:2]))
        high, wide = (max(1, side // 2) for side in tiles[largest].shape[:2])
        if (high, wide) == tiles[largest].shape[:2]:
            break
        tiles[largest] = np.asarray(
            cv2.resize(tiles[largest], (wide, high), interpolation=cv2.INTER_AREA), dtype=np.uint8
        )
    return tiles
