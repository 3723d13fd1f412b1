"""From a situation to a factor graph over its alternatives: ``plogic.factors.scene.scene_graph``."""
