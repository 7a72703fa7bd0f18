"""Torque observer: joint torques and external wrenches from force/torque sensors."""
