"""The maths of the papers: NumPy in, NumPy out; no bus, no clock, no thread, no file."""
