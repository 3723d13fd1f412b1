"""One file a detector, the protocol that all follow, and ``detect``: one image to Γ."""
