"""What is done with recordings beside the bus: look at them, turn them into other formats."""
