"""The measures of §5 (the paper's §7.2): pure functions over counts, with no pose and no program in them."""
