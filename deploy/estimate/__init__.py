"""``wrenchbus estimate``: torques, wrenches and contacts of a log, without a bus."""
