"""The simulated table top: printed packages and scanned bodies, photographed with a depth sensor."""
