"""Probabilities and explanatory values as people read them."""

NONE = "–"


def chance(p: float | None) -> str:
    """Return a probability to three places; what rounds to 0 or 1 without being it says so."""
    if p is None:
        return NONE
    if 0 < p < 0.0005:
        return "<0.001"
    return (
        ">0.999" if 0.9995 < p < 1 else f"{float(f'{p:.12g}'):.3f}"
    )  # so that noise in the last digits decides no tie


def signed(value: float | None) -> str:
    """Return an explanatory value to two places, or a dash where it is undefined."""
    return NONE if value is None else f"{value:+.2f}"


def interval(low: float, high: float) -> str:
    """Return one probability, or both bounds where they print differently."""
    return chance(low) if chance(low) == chance(high) else f"{chance(low)}..{chance(high)}"
