"""The files of a new knowledge base, commented for whoever fills it."""

import json

from kb.errors import IntakeError
from kb.files.schema import json_schema
from kb.intake.new_type import SAFE_NAME

KB_YAML = """\
# yaml-language-server: $schema=./kb.schema.json
name: {name}
# What detectors report. Keypoints' visual words join these when types are learned.
appearance_types: [l_junction, y_junction, arrow_junction, t_junction, multi_junction, patch]
# The focal length, in pixels, that the ranges of lobes hold for.
f_ref: 600
detector:
  # Chance that an expected feature is detected, per feature type (0.8 where nothing stands here), such as {{corner: 0.9}}.
  hit: {{}}
  # Appearances of noise in an image, per appearance type, such as {{patch: 1.5}}.
  clutter: {{}}
  # Location noise, and how far from its predicted place a feature may be found; pixels.
  sigma: 1.0
  match_tolerance: 4.0
# Chance that an object is there, per object type (0.5 where nothing stands here), such as {{mug: 0.2}}.
priors: {{}}
# Whether things rest, as on a table: then what floats is less probable, and what is not found yet is looked for on the plane that others
# stand on. Instead of true, {{unknown_support: 0.1, ground: 0 m}}: the chance that something unknown holds what floats, the ground's height.
gravity: false
"""

RULES = """\
% Rules of your own, in ProbLog, for `plogic query` and `plogic shell`; the vocabulary is in docs/vocabulary.md. For example:
%
%   two_of(Type) :- object(X, Type), object(Y, Type), X \\= Y.
"""


def schema_files() -> dict[str, bytes]:
    """The JSON Schemas that the editor lines of ``kb.yaml`` and ``object.yaml`` point to, by name in the KB's folder."""
    return {"kb.schema.json": _schema("kb"), "object.schema.json": _schema("object")}


def _schema(which: str) -> bytes:
    return (json.dumps(json_schema("kb" if which == "kb" else "object"), indent=1) + "\n").encode()


def new_kb_files(name: str) -> dict[str, bytes]:
    """Every file of a new KB but the empty folder ``objects``, by relative path.

    Raises:
        IntakeError: for a name of other signs than a folder's.
    """
    if not SAFE_NAME.fullmatch(name):
        raise IntakeError(
            f"{name!r:.60} is no name for a knowledge base: letters, digits, '_', '-' and '.'; give one with --name"
        )
    return {"kb.yaml": KB_YAML.format(name=json.dumps(name)).encode(), "rules.pl": RULES.encode()} | schema_files()
