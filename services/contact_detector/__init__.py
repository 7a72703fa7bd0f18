"""Contact detector: residuals, flags per limb, and where the robot is touched."""
