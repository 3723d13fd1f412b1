"""Looking ahead: what a camera elsewhere would see in each world, and how much that would tell (§7)."""
