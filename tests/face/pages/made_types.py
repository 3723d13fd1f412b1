"""Types made for tests of the page: a learned one with a painted box, a hostile one, one without anything."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
from made_meshes import obj_text, split_box
from random_cloud import random_cloud, random_words

from kb.clouds.learned import cloud_bytes
from kb.clouds.words import words_bytes

HOSTILE = "</script><img src=x onerror=document.title='pwned'><!--<script>"
KB = "name: learned\nappearance_types: []\nf_ref: 600\nwords: {file: words.npz}\n"
OBJECT = "object: carton\nmesh: {file: mesh.obj, units: m}\nfeatures: []\ncloud: {file: cloud.npz}\n"


def write_learned(folder, cloud=None):
    """A KB of one learned type, a box of 0.2 m whose faces have different colours."""
    place = folder / "objects" / "carton"
    place.mkdir(parents=True)
    vertices, triangles, _ = split_box()
    uv = np.stack([(np.arange(len(vertices)) // 4 + 0.5) / 6, np.full(len(vertices), 0.5)], axis=1)
    place.joinpath("mesh.obj").write_text(obj_text((vertices - 0.5) * 0.2, triangles, uv, "mesh.mtl"))
    place.joinpath("mesh.mtl").write_text("newmtl paint\nKd 1 1 1\nmap_Kd paint.png\n")
    colours = np.array(
        [[200, 60, 60], [60, 200, 60], [60, 60, 200], [60, 200, 200], [200, 60, 200], [200, 200, 60]], np.uint8
    )
    cv2.imwrite(str(place / "paint.png"), np.repeat(np.repeat(colours[None], 16, axis=0), 16, axis=1))
    place.joinpath("object.yaml").write_text(OBJECT)
    place.joinpath("cloud.npz").write_bytes(cloud_bytes(cloud if cloud is not None else random_cloud(3, 400, 900)))
    folder.joinpath("words.npz").write_bytes(words_bytes(random_words()))
    folder.joinpath("kb.yaml").write_text(KB)
    return folder


def hostile(kb):
    """The KB with its first type, whose names are all markup; feature types, appearance types and features too."""
    kind = kb.types[0]
    features = [
        replace(f, type=HOSTILE, appearances=tuple(replace(a, type=HOSTILE) for a in f.appearances))
        if f.type == "corner"
        else f
        for f in kind.features
    ]
    evil = replace(kind, name=HOSTILE, features=tuple(features), all_features=tuple(features))
    return replace(kb, name=HOSTILE, types=(evil,)), evil


def bare(kb):
    """The KB with one type that has neither surface nor features."""
    kind = replace(kb.types[0], name="nothing", features=(), all_features=(), surface=None, mesh_file=None)
    return replace(kb, types=(kind,)), kind
