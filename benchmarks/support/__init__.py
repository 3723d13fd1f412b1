"""What things stand on, in rendered scenes whose planes and stances are known: ``plogic bench support``."""
