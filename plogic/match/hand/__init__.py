"""Hand-modelled types, by places alone: pairs in view cells, votes, sets of four, POSIT."""
