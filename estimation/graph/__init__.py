"""The Enhanced Oriented Graph as the thesis of Fumagalli has it: to be read, and for tests."""
