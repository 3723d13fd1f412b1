"""Several views of one place: Δp, the panorama (§1), and what all views together say."""
