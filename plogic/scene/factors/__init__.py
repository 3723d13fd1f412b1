"""From a situation to a factor graph over its alternatives: ``plogic.scene.factors.scene_graph.scene_graph``."""
