"""Learning an object type: from pictures, by any rendering and detection handed in, to a cloud of features."""
