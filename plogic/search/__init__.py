"""Generation of Δh (§6.3, §7.1): from typed appearances to posed hypotheses, most distinctive first."""
