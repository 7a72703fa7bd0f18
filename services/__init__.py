"""One folder per process of the robot."""
