"""Priors, hit rates and clutter rates from scenes with ground truth (§8, posterior)."""
