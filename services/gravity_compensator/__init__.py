"""Gravity compensator: joint torques that hold the robot against gravity."""
