"""Whether ``plogic watch`` keeps up with a pipe."""
