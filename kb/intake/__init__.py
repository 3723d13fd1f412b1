"""From somebody's mesh to an object type's files: reading, units, welding and repairing, paint, symmetries of the shape."""
