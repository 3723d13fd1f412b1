"""Any ICL program: read, held to the allow-list, grounded, compiled, answered and proved. Knows nothing of scenes."""
