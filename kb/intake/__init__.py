"""From somebody's mesh, robot description or BOP models to an object type's files."""
