"""One HTML file that works offline, and what every such page shares: its looks, its elements, the canvas that turns."""
