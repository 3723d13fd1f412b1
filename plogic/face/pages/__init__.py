"""Pages in one HTML file that work offline: of an interpretation, and of an object type."""
