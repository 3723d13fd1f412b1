"""The weights of worlds in the score and in the posterior reading (§8)."""
