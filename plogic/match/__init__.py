"""From Γ to hypotheses (§6, §7): type models, expectation (D7), matching (D8), evidence, rivals."""
