"""One synchronous sensor frame for the whole robot, and every command to its boards."""
