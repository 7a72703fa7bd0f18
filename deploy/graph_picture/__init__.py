"""Pictures of Enhanced Oriented Graphs."""
