"""What one view leaves to decide: hypotheses, the situation, the vocabulary, space and gravity, as plain data."""
