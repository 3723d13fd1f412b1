"""The click group ``plogic kb``: one function a command, which parses, calls and prints."""

from pathlib import Path
from typing import Any

import click

from plogic.base.errors import InputError
from plogic.face.shown.options import AS_JSON, PLACE, SEED, Learning, Photo, camera_options
from plogic.face.shown.printed import emit, hand_over, say
from plogic.run.cameras import GivenCamera

UNITS = ["m", "dm", "cm", "mm", "um", "km", "in", "ft"]
"""``kb.files.values.LENGTHS``, said again so that ``--help`` imports nothing; a test holds the two together."""
KB = click.option(
    "--kb", "kb_folder", required=True, type=click.Path(path_type=Path), help="Folder of the knowledge base."
)


@click.group(context_settings={"help_option_names": ["-h", "--help"]})
def kb() -> None:
    """Make, fill, check and show knowledge bases."""


@kb.command("new")
@click.argument("folder", type=click.Path(path_type=Path))
@click.option("--name", help="Name of the knowledge base (default: the folder's).")
@click.option("--example", is_flag=True, help="With a type written by hand, a box, to start from.")
def kb_new(folder: Path, name: str | None, example: bool) -> None:  # noqa: FBT001 - click hands over flags
    """Make a new knowledge base: kb.yaml, its schemas for the editor, rules.pl and objects/."""
    from plogic.face.authoring.kb_types import new_command

    emit(new_command(folder, name, example=example))


@kb.command("add")
@click.argument("name")
@click.option(
    "--mesh",
    type=click.Path(path_type=Path),
    required=True,
    help="Triangle mesh: OBJ, PLY, STL, GLB, GLTF, OFF or DAE.",
)
@click.option(
    "--units", type=click.Choice(UNITS), help="Unit of the mesh's coordinates. Required: no mesh format carries it."
)
@KB
@AS_JSON
def kb_add(name: str, mesh: Path, units: str | None, kb_folder: Path, as_json: bool) -> None:  # noqa: FBT001 - click hands over flags
    """Make the object type NAME from a mesh, repaired, its pieces as parts, with its texture kept for rendering."""
    from plogic.face.authoring.kb_types import add_command

    emit(add_command(name, mesh, units, kb_folder, as_json=as_json))


@kb.command("learn")
@click.argument("names", nargs=-1, metavar="[NAME]...")
@KB
@click.option(
    "--detector",
    type=click.Choice(["sift", "orb"]),
    default="sift",
    show_default=True,
    help="What looks; orb is the fast one.",
)
@click.option("--jobs", type=click.IntRange(1, 64), default=2, show_default=True, help="Processes.")
@click.option("--seed", type=SEED, default=0, show_default=True)
@click.option("--photo", type=click.Path(path_type=Path), help="A photo of the one type named, instead of a texture.")
@click.option(
    "--points", type=click.Path(path_type=Path), help="Clicked points of the photo: YAML, JSON or CSV of u, v, x, y, z."
)
@camera_options("Only with --photo; where no camera is given, the photo's focal length is recovered.")
@click.option(
    "--mesh", type=click.Path(path_type=Path), help="With --photo: the mesh of a type that is not there yet (kb add)."
)
@click.option("--units", type=click.Choice(UNITS), help="Unit of that mesh.")
@AS_JSON
def kb_learn(
    names: tuple[str, ...],
    kb_folder: Path,
    photo: Path | None,
    points: Path | None,
    camera: GivenCamera,
    mesh: Path | None,
    units: str | None,
    **options: Any,  # noqa: ANN401
) -> None:
    """Learn the features of types NAME from their textured meshes, all without features where none is named.

    With --photo: of one type, from a photo instead of a texture.

    The turns of a shape that its texture keeps are written into object.yaml as symmetries, unless some are stated
    there.
    """
    idle = {"--points": points, "--mesh": mesh, "--units": units}
    named = [*camera.named, *(name for name, value in idle.items() if value is not None)]
    if photo is None and named:
        raise InputError(f"{', '.join(named)}: only with --photo")
    if photo is None:
        from plogic.face.authoring.kb_learn import learn_command

        emit(learn_command(str(kb_folder), names, Learning(**options), say=say))
        return
    if points is None:
        raise InputError(
            "--photo needs --points, a file of clicked correspondences: u, v in pixels, x, y, z of the object"
        )
    from plogic.face.authoring.kb_learn_photo import learn_photo_command

    sources = Photo(photo, points, camera, mesh, units)
    emit(learn_photo_command(str(kb_folder), names, sources, Learning(**options), say=say))


@kb.command("import")
@click.argument("source", metavar="FILE_OR_FOLDER", type=click.Path(path_type=Path))
@KB
@click.option(
    "--units", type=click.Choice(UNITS), help="Unit of the meshes, if not the format's: m for URDF and SDF, mm for BOP."
)
@AS_JSON
def kb_import(source: Path, kb_folder: Path, units: str | None, as_json: bool) -> None:  # noqa: FBT001 - click hands over flags
    """Make object types from a URDF or SDF file, or from a BOP `models` folder with its symmetries."""
    from plogic.face.authoring.kb_types import import_command

    emit(import_command(source, kb_folder, units, as_json=as_json))


@kb.command("check")
@click.argument("folder", type=PLACE)
@AS_JSON
def kb_check(folder: str, as_json: bool) -> None:  # noqa: FBT001 - click hands over flags
    """Report every mistake of a knowledge base at its file, line and column, and what in it may be meant otherwise."""
    from plogic.face.authoring.kb_show import check_command

    emit(check_command(folder, as_json=as_json))


@kb.command("show")
@click.argument("folder", type=PLACE)
@click.argument("name", metavar="[TYPE]", required=False)
@click.option("--html", metavar="FILE", help="Write a page that shows TYPE in 3D instead; `-` is stdout.")
@click.option("--geometry", is_flag=True, help="Show mereology, faces, vector pencils and sets of four that converge.")
@AS_JSON
def kb_show(folder: str, name: str | None, html: str | None, geometry: bool, as_json: bool) -> None:  # noqa: FBT001 - click hands over flags
    """Show the trees of parts, of all types or of TYPE, the counts and dv.

    With --html: TYPE in 3D, with its features and their lobes.
    """
    if html is not None:
        if as_json or geometry:
            raise click.UsageError(f"--html and {'--json' if as_json else '--geometry'} do not go together")
        from plogic.face.authoring.kb_show import page_command

        page_command(folder, name, html, say=say, write=hand_over)
        return
    from plogic.face.authoring.kb_show import show_command

    emit(show_command(folder, name, geometry=geometry, as_json=as_json))


@kb.command("measures")
@click.argument("folder", type=PLACE)
@click.option("--gamma", type=PLACE, help="A Γ to rank the types by.")
@AS_JSON
def kb_measures(folder: str, gamma: str | None, as_json: bool) -> None:  # noqa: FBT001 - click hands over flags
    """Print |S(F)|, P(dv) and dv of every feature type; with a Γ, the rank of every object type."""
    from plogic.face.authoring.kb_show import measures_command

    emit(measures_command(folder, gamma, as_json=as_json))


@kb.command("schema")
@click.argument("which", type=click.Choice(["kb", "object"]))
def kb_schema(which: Any) -> None:  # noqa: ANN401 - click's choice
    """Print the JSON Schema of `kb.yaml` or `object.yaml`."""
    from plogic.face.authoring.kb_show import schema_command

    emit(schema_command(which))


@kb.command("learn-rates")
@click.argument("scenes", nargs=-1, required=True, metavar="SCENES...", type=PLACE)
@click.option(
    "--kb", "kb_folder", required=True, type=PLACE, help="Folder of the knowledge base whose kb.yaml is written."
)
@click.option("--add", is_flag=True, help="Add to the counts that the KB has, instead of starting anew.")
@click.option("--dry-run", is_flag=True, help="Only print: write nothing.")
@AS_JSON
def kb_learn_rates(scenes: tuple[str, ...], kb_folder: str, add: bool, dry_run: bool, as_json: bool) -> None:  # noqa: FBT001 - click hands over flags
    """Learn priors, hit rates and clutter from SCENES, folders with ground truth, into kb.yaml.

    A scene is what `plogic simulate` writes, or any folder with truth.json and an interpretation.json,
    a gamma.json, or an image.png with camera.json. Where truth.json says `"complete": false`, what was
    found beyond it may be there or not, and is weighed by EM.
    """
    from plogic.face.authoring.kb_learn_rates import learn_rates_command

    emit(learn_rates_command(scenes, kb_folder, add=add, dry_run=dry_run, say=say, as_json=as_json))


@kb.command("assimilate")
@click.argument("panorama", type=PLACE)
@click.argument("unknown", metavar="UNKNOWN_ID")
@click.option(
    "--kb", "kb_folder", required=True, type=PLACE, help="Folder of the knowledge base that the type goes into."
)
@click.option("--name", required=True, help="Name of the new type.")
@AS_JSON
def kb_assimilate(panorama: str, unknown: str, kb_folder: str, name: str, as_json: bool) -> None:  # noqa: FBT001 - click hands over flags
    """Make a draft type from an unknown object of PANORAMA, as `plogic perceive FRAME... --poses` writes it (or `-`).

    Its features stand where they were triangulated, with lobes about the viewpoints from which they were seen.
    Where they span a volume, its mesh is a hull of them.
    """
    from plogic.face.authoring.kb_types import assimilate_command

    emit(assimilate_command(panorama, unknown, kb_folder, name, as_json=as_json))
