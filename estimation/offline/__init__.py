"""The same mathematics over logs: all samples are there, and none is late."""
