"""Base estimator: pose and velocity of the base link."""
