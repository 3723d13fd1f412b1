"""What every benchmark uses: claims, and the time of processors."""
