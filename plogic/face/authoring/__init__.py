"""The commands of ``plogic kb``: object types made, learned, shown and checked."""
