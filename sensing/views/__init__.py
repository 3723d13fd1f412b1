"""Poses of what has no print, from outlines, creases and colours: views of a type looked for all over a photo."""
