"""``plogic bench``: which benchmarks there are, and which takes what."""

import sys
from importlib import import_module
from pathlib import Path
from typing import Any

import click

from plogic.face.shown.options import AS_JSON, SEED, Number
from plogic.face.shown.printed import emit, say

SIZED = (
    "watch",
    "photos",
    "support",
    "places",
    "sizes",
    "scale",
    "panorama",
    "stereo",
    "constancy",
    "look-again",
    "occlusion",
    "attention",
)
COMPARED = "towers", "worlds", "programs", "recognition", "box", "clutter", "many", "calibration", "batch", "start"
BENCHES = *COMPARED, *SIZED
OWN = {
    "picture": (("box", "calibration"), "--picture: `{}` draws none; `box` and `calibration` do"),
    "pictures": (("photos", "support"), "--pictures: `{}` draws none; `photos` and `support` do"),
    "peer": (("start",), "--peer: `{}` has none of this kind; `start` has"),
    "kb": (("photos", "support"), "--kb: `{}` learns its own; `photos` and `support` take one"),
    "part": (("photos",), "--simulated, --without: `{}` has no such parts; `photos` has"),
    "count": (("photos", "support"), "--count: `{}` has no such pictures; `photos` and `support` have"),
}
"""Options that some benchmarks alone take: which, and what is said to others."""


@click.command()
@click.argument("name", type=click.Choice(BENCHES))
@click.option("--scenes", type=click.IntRange(1), default=120, show_default=True, help="Scenes of `towers`.")
@click.option(
    "--limit",
    type=Number(0.0, min_open=True),
    default=60.0,
    show_default=True,
    help="Seconds of a stock run (`worlds`, `programs`) or of a peer (`recognition`, `clutter`, `many`).",
)
@click.option(
    "--quick",
    is_flag=True,
    help="Small sizes of `worlds` and `programs`, the box alone, few scenes or trials of the others; not of `towers`.",
)
@click.option(
    "--picture",
    type=click.Path(path_type=Path),
    help="JPEG of `box`: a frame at two focal lengths; SVG of `calibration`.",
)
@click.option(
    "--pictures",
    type=click.Path(path_type=Path, file_okay=False),
    help="Folder for a picture of each of the `photos`, or scenes of `support`: what is accepted beside the truth.",
)
@click.option(
    "--peer",
    type=click.Path(path_type=Path),
    help="Console script of another plogic, run in turn with ours by `start`.",
)
@click.option(
    "--kb",
    type=click.Path(path_type=Path, file_okay=False),
    help="Folder of the KBs of `photos` and `support`, named `ycb` and `lmo`: what is not there is learned into it.",
)
@click.option(
    "--simulated", "part", flag_value="simulated", help="Of `photos`: rendered pictures with the troubles of photos."
)
@click.option(
    "--without",
    "part",
    flag_value="without",
    help="Of `photos`: each type left out, and what is accepted in its place.",
)
@click.option(
    "--count",
    type=click.IntRange(1),
    help="Pictures of `photos --simulated`: 100, with --quick 12; scenes of `support`: 200, with --quick 12.",
)
@click.option("--seed", type=SEED, default=0, show_default=True)
@AS_JSON
def bench(name: str, scenes: int, limit: float, seed: int, *, quick: bool, as_json: bool, **own: Any) -> None:  # noqa: ANN401 - options of single benchmarks
    """Run one of the project's own benchmarks; it ends with its claims."""
    if quick and name == "towers":
        raise click.UsageError("--quick: `towers` takes --scenes")
    for option, (some, why) in OWN.items():
        if own[option] is not None and name not in some:
            raise click.UsageError(why.format(name))
    if own["count"] is not None and name == "photos" and own["part"] != "simulated":
        raise click.UsageError("--count: pictures are counted with --simulated")
    pictured, sized = {"quick": quick, "picture": own["picture"]}, {"quick": quick}
    others: dict[str, dict[str, Any]] = {"towers": {"scenes": scenes}, "box": pictured, "calibration": pictured}
    others |= dict.fromkeys(SIZED, sized)
    drawn = sized | {option: own[option] for option in ("pictures", "kb", "count")}
    others |= {"start": sized | {"peer": own["peer"]}, "photos": drawn | {"part": own["part"]}, "support": drawn}
    options: dict[str, Any] = others.get(name, {"limit": limit, "quick": quick})
    text, met = import_module(f"benchmarks.{name.replace('-', '_')}.bench").run(
        seed=seed, **options, as_json=as_json, say=say
    )
    emit(text)
    sys.exit(0 if met else 1)
