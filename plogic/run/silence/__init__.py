"""Why something was not found: in the knowledge base, in Γ, and in what would be found were one thing otherwise."""
