"""The recorder: what is on the bus, in a file, when asked."""
