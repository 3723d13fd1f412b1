"""Several views of one place: the panorama, constancy, and the next view."""
