"""The commands that write, as ``benchmarks.fuzz.crashes`` kills them, and the folder in which each of them begins."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks.fuzz.seeds import robot_mesh, sdf, urdf
from kb.files.changes import CHANGE, LOCK

ROOT = Path(__file__).parents[2]
SIDES = np.array([0.12, 0.2, 0.08])
"""Of a box, m."""
CORNERS = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)]) * SIDES
FACES = (0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)
UV = ((0, 0), (0, 1), (1, 1), (1, 0))
BARE = "name: bare\nappearance_types: [l_junction, y_junction, arrow_junction, t_junction, multi_junction, patch]\n"


class Kind(Enum):
    """What a command writes: what is old or new as a whole."""

    KB = "a knowledge base, as it is read"
    FOLDER = "a new folder with all that is in it"
    FILES = "files, each by itself"
    LOG = "a file of lines, after --resume"


@dataclass(frozen=True)
class Command:
    """``arguments`` of the console script, run in a folder that has what it ``needs``; ``again``: after a kill."""

    name: str
    arguments: tuple[str, ...]
    outputs: tuple[str, ...]
    kind: Kind
    needs: str
    stdin: str | None = None
    again: tuple[str, ...] | None = None


def _command(line: str, outputs: str, kind: Kind, needs: str, stdin: str | None = None, again: str = "") -> Command:
    words = line.split()
    name = " ".join(word for i, word in enumerate(words) if i < 1 + (words[0] == "kb") or word in SAID)
    return Command(name, tuple(words), tuple(outputs.split()), kind, needs, stdin, (*words, again) if again else None)


SAID = {
    "--example",
    "--photo",
    "--gamma",
    "--robot",
    "--bop",
    "--paper",
    "--look-again",
    "--html",
    "--fix",
    "new",
    "all",
    "fresh",
    "robot.urdf",
    "robot.sdf",
    "--jobs=2",
}


def commands() -> list[Command]:
    """Every command that writes, with each option that writes."""
    asked = "perceive gamma.json --kb first -o i.out --report page.html --picture seen.png --timings t.json"
    view = "watch - --kb towers --camera scene/camera.json --jobs 1 --picture now.png --pictures every"
    batch = "batch shots --kb first --jobs 2 -o lines.jsonl"
    return [
        _command("kb new fresh", "fresh", Kind.KB, ""),
        _command("kb new fresh --example", "fresh", Kind.KB, ""),
        _command("kb add more --mesh painted.obj --units m --kb kb", "kb", Kind.KB, "types"),
        _command("kb add more --mesh painted.obj --units m --kb fresh", "fresh", Kind.KB, ""),
        _command("kb import models --kb kb", "kb", Kind.KB, "types"),
        _command("kb import models --kb fresh", "fresh", Kind.KB, ""),
        _command("kb import robot.urdf --kb kb", "kb", Kind.KB, "types"),
        _command("kb import robot.sdf --kb kb", "kb", Kind.KB, "types"),
        _command("kb learn --jobs 1 --kb kb", "kb", Kind.KB, "learned"),
        _command("kb learn --jobs=2 --seed 1 --kb kb", "kb", Kind.KB, "types"),
        _command("kb learn box --photo photo.png --points points.csv --jobs 1 --kb kb", "kb", Kind.KB, "photo"),
        _command("kb learn-rates story --kb book", "book", Kind.KB, "rates"),
        _command("kb assimilate panorama.json u1 --name draft --kb bare", "bare", Kind.KB, "unknown"),
        _command("kb check half", "half", Kind.KB, "half"),
        _command("doctor --fix --kb half", "half", Kind.KB, "half"),
        _command("kb show towers t1 --html page.html", "page.html", Kind.FILES, ""),
        _command(asked, "i.out page.html seen.png", Kind.FILES, ""),  # the seconds of t.json are never the same
        _command("report i.json -o page.html", "page.html", Kind.FILES, "asked"),
        _command("shell i.json", "x.session", Kind.FILES, "asked", "session.txt"),
        _command("settle scene.json --picture seen.png", "seen.png", Kind.FILES, "scene"),
        _command("bop bop --kb towers --ids bop/ids.json -o found.csv", "found.csv", Kind.FILES, "scene"),
        _command(view, "now.png every", Kind.FILES, "scene", "scene/image.png"),
        _command("demo -o demo", "demo", Kind.FILES, ""),
        _command("demo --look-again -o demo", "demo", Kind.FILES, ""),
        _command("demo --paper -o demo", "demo", Kind.FILES, ""),
        _command("simulate --kb first --gamma -o new", "new", Kind.FOLDER, ""),
        _command("simulate --kb towers -o new --bop all", "new all", Kind.FOLDER, ""),
        _command("simulate --kb first --gamma --robot ring:3 -o new", "new", Kind.FOLDER, ""),
        _command(batch, "lines.jsonl", Kind.LOG, "", again="--resume"),
    ]


Well = Callable[[Path, str], None]
"""Runs a command that must succeed, in a folder."""


def prepare(folder: Path, chosen: Sequence[Command], well: Well) -> None:
    """Write what the commands need into a folder; ``well`` runs other commands for it."""
    needs = {command.needs for command in chosen}
    _write_meshes(folder)
    robot_mesh(folder)
    (folder / "robot.urdf").write_bytes(urdf()[0])
    (folder / "robot.sdf").write_bytes(sdf()[0])
    shutil.copy(ROOT / "examples" / "first_gamma.json", folder / "gamma.json")
    (folder / "session.txt").write_text("present(h1).\nsave x.session\n")
    (folder / "shots").mkdir()
    for i in range(5):
        shutil.copy(folder / "gamma.json", folder / "shots" / f"{i}.json")
    for need, make in NEEDS.items():
        if need in needs:
            make(folder, well)


def _types(folder: Path, well: Well) -> None:
    """A knowledge base with two painted types and one that is not, none of them learned."""
    if not (folder / "kb").exists():
        well(folder, "kb new kb")
        for name, mesh in (("one", "painted"), ("two", "other"), ("box", "plain")):
            well(folder, f"kb add {name} --mesh {mesh}.obj --units m --kb kb")


def _learned(folder: Path, well: Well) -> None:
    """One of the types is learned; what the other will be is remembered."""
    _remembered(folder, well, "kb learn --jobs 1 --kb tried")


def _photo(folder: Path, well: Well) -> None:
    """So with a type from its photo."""
    _remembered(folder, well, "kb learn box --photo photo.png --points points.csv --jobs 1 --kb tried")


def _remembered(folder: Path, well: Well, line: str) -> None:
    _types(folder, well)
    well(folder, "kb learn one --jobs 1 --kb kb")
    shutil.copytree(folder / "kb", folder / "tried")
    well(folder, line)
    shutil.rmtree(folder / "tried")


def _asked(folder: Path, well: Well) -> None:
    well(folder, "perceive gamma.json --kb first -o i.json")


def _scene(folder: Path, well: Well) -> None:
    well(folder, "simulate --kb towers -o scene --bop bop")
    well(folder, "perceive scene/image.png --camera scene/camera.json --kb towers -o scene.json")


def _rates(folder: Path, well: Well) -> None:
    shutil.copytree(ROOT / "kb" / "first", folder / "book")
    well(folder, "simulate --kb first --gamma -o story")


def _unknown(folder: Path, well: Well) -> None:
    (folder / "bare").mkdir()
    (folder / "bare" / "kb.yaml").write_text(BARE)
    well(folder, "simulate --kb towers --type t1 --gamma --robot ring:4 -o tour")
    frames = " ".join(f"tour/frame-{i:03d}/gamma.json" for i in range(4))
    well(folder, f"perceive {frames} --poses tour/poses.json --kb bare -o panorama.json")


def _half(folder: Path, well: Well) -> None:
    """A knowledge base whose writer was killed when its change was in force and not moved."""
    well(folder, "kb new half")
    change = folder / "half" / CHANGE
    change.mkdir()
    (change / "kb.yaml").write_text((folder / "half" / "kb.yaml").read_text() + "# changed\n")
    (folder / "half" / LOCK).write_text("1")


NEEDS: dict[str, Callable[[Path, Well], None]] = {
    "types": _types,
    "learned": _learned,
    "photo": _photo,
    "asked": _asked,
    "scene": _scene,
    "rates": _rates,
    "unknown": _unknown,
    "half": _half,
}


def _write_meshes(folder: Path) -> None:
    """Boxes, two of them painted, a photo of one with its corners, and a folder of BOP models."""
    import cv2

    for seed, name in enumerate(("painted", "other", "plain")):
        (folder / f"{name}.obj").write_text(_obj(None if name == "plain" else f"{name}.mtl"))
        if name != "plain":
            cv2.imwrite(str(folder / f"{name}.png"), _paper(seed))
            (folder / f"{name}.mtl").write_text(f"newmtl paint\nKd 1 1 1\nmap_Kd {name}.png\n")
    _photograph(folder)
    (folder / "models").mkdir()
    for number in (1, 2):
        (folder / "models" / f"obj_{number:06d}.ply").write_text(_ply(number))
    (folder / "models" / "models_info.json").write_text('{"1": {"diameter": 100}, "2": {"diameter": 200}}')


def _obj(material: str | None) -> str:
    lines = [f"mtllib {material}\nusemtl paint"] if material else []
    lines += [f"v {x:g} {y:g} {z:g}" for x, y, z in CORNERS]
    lines += [f"vt {(i % 3 + u) / 3:.4f} {(i // 3 + v) / 2:.4f}" for i in range(6) for u, v in UV]
    for i, (a, b, c, d) in enumerate(FACES):
        for turn in ((a, 0), (b, 1), (c, 2)), ((a, 0), (c, 2), (d, 3)):
            lines.append("f " + " ".join(f"{at + 1}/{4 * i + k + 1}" for at, k in turn))
    return "\n".join(lines) + "\n"


def _ply(number: int) -> str:
    head = "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n"
    rows = "".join(f"{x:g} {y:g} {z:g}\n" for x, y, z in CORNERS * 500 * number)
    faces = "".join(f"3 {a} {b} {c}\n3 {a} {c} {d}\n" for a, b, c, d in FACES)
    return f"{head}element face 12\nproperty list uchar int vertex_indices\nend_header\n{rows}{faces}"


def _paper(seed: int) -> NDArray[np.uint8]:
    from benchmarks.tabletop.patterns import pattern

    tiles = [pattern("newsprint", np.random.default_rng(6 * seed + i), 256) for i in range(6)]
    return np.asarray(np.vstack([np.hstack(tiles[3:]), np.hstack(tiles[:3])]), np.uint8)


def _photograph(folder: Path) -> None:
    """``photo.png`` of the painted box, and ``points.csv`` with seven of its corners."""
    from dataclasses import replace

    import cv2

    from geometry.camera import centred_camera
    from geometry.frames import inverse, look_at, transform_points
    from sensing.simulated.body import Body, read_mesh
    from sensing.simulated.camera import render

    camera_from_world = look_at((0.45, 0.62, 0.42), SIDES / 2)
    camera = replace(centred_camera((640, 480), 900.0), world_from_camera=inverse(camera_from_world))
    body = Body("box", read_mesh(folder / "painted.obj"), np.eye(4))
    cv2.imwrite(str(folder / "photo.png"), render([body], camera).image)
    pixels = camera.project(transform_points(camera_from_world, CORNERS[1:]))
    rows = [",".join(f"{value:.6g}" for value in (*uv, *at)) for uv, at in zip(pixels, CORNERS[1:], strict=True)]
    (folder / "points.csv").write_text("u,v,x,y,z\n" + "\n".join(rows) + "\n")
