"""Questions to a scene: P(goal), explanations, and scenes that one can observe in."""
