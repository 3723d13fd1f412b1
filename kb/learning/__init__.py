"""Learning an object type: from pictures of it, by whatever rendering and detection are handed in, to a cloud of features."""
