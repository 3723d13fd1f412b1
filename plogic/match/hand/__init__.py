"""Hand-modelled types, by places alone: triples of all types in one index, links of junctions, votes, refinement."""
