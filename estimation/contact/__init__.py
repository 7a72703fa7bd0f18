"""Contact detection and localisation: where, how hard, how sure."""
