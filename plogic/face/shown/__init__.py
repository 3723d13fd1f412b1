"""Tables, pictures and options that several commands share."""
