"""What a session says: results as data, as text and as HTML, and the verbs that make them."""
