"""Feature clouds (§2): the tree of a type, its features and lobes, learned clouds and visual words."""
