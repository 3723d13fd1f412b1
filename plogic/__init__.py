"""Δ: what is believed.

Measures, hypotheses, the perceptual cycle, program text, possible worlds, queries, explanations.

>>> from plogic import Camera, KnowledgeBase, perceive
>>> scene = perceive("photo.jpg", KnowledgeBase.load("mykb"), Camera.load("camera.yaml"))
>>> scene.query("present(H)")

Names load when they are used: ``import plogic`` alone takes no time.
"""

TYPE_CHECKING = False  # as typing's, which takes longer to import than all of this

__all__ = [
    "AnswerRow",
    "Answers",
    "Appearance",
    "Camera",
    "Error",
    "Explanation",
    "Gamma",
    "Hypotheses",
    "Hypothesis",
    "Interpretation",
    "KnowledgeBase",
    "Measure",
    "Measures",
    "Panorama",
    "PlacedObject",
    "PlacedObjects",
    "Predictions",
    "Program",
    "Relation",
    "Relations",
    "Session",
    "Settled",
    "SettledObject",
    "World",
    "Worlds",
    "detect",
    "perceive",
]

if TYPE_CHECKING:
    from geometry.errors import PlogicError as Error
    from plogic.face.python.asking import Explanation, Program
    from plogic.face.python.interpretation import Hypotheses, Hypothesis, Interpretation, Measures, Relation, Relations
    from plogic.face.python.knowledge import KnowledgeBase
    from plogic.face.python.panoramas import Panorama, PlacedObject, PlacedObjects
    from plogic.face.python.perceiving import detect, perceive
    from plogic.face.python.pictures import Camera, Gamma
    from plogic.face.python.sessions import Session
    from plogic.face.python.settled import Settled, SettledObject
    from plogic.face.session.results import AnswerRow, Answers, Predictions, World, Worlds
    from plogic.run.measured import Measure
    from sensing.appearance import Appearance
else:
    _PLACES = {
        "AnswerRow": "plogic.face.session.results",
        "Answers": "plogic.face.session.results",
        "Appearance": "sensing.appearance",
        "Camera": "plogic.face.python.pictures",
        "Error": "geometry.errors:PlogicError",
        "Explanation": "plogic.face.python.asking",
        "Gamma": "plogic.face.python.pictures",
        "Hypotheses": "plogic.face.python.interpretation",
        "Hypothesis": "plogic.face.python.interpretation",
        "Interpretation": "plogic.face.python.interpretation",
        "KnowledgeBase": "plogic.face.python.knowledge",
        "Measure": "plogic.run.measured",
        "Measures": "plogic.face.python.interpretation",
        "Panorama": "plogic.face.python.panoramas",
        "PlacedObject": "plogic.face.python.panoramas",
        "PlacedObjects": "plogic.face.python.panoramas",
        "Predictions": "plogic.face.session.results",
        "Program": "plogic.face.python.asking",
        "Relation": "plogic.face.python.interpretation",
        "Relations": "plogic.face.python.interpretation",
        "Session": "plogic.face.python.sessions",
        "Settled": "plogic.face.python.settled",
        "SettledObject": "plogic.face.python.settled",
        "World": "plogic.face.session.results",
        "Worlds": "plogic.face.session.results",
        "detect": "plogic.face.python.perceiving",
        "perceive": "plogic.face.python.perceiving",
    }

    def __getattr__(name: str) -> object:
        """Load a public name when it is first used.

        Raises ImportError where a file of the user's own hides what it needs.
        """
        if name not in _PLACES:
            raise AttributeError(f"module 'plogic' has no attribute {name!r}")
        from importlib import import_module

        from plogic.base.hidden import hidden

        told = hidden()
        if told is not None:
            raise ImportError(told)
        module, _, other = _PLACES[name].partition(":")
        value = globals()[name] = getattr(import_module(module), other or name)
        return value

    def __dir__() -> list[str]:
        """The public names, loaded or not."""
        return sorted({*globals(), *__all__})
