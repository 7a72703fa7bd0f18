"""All tests may use the bus's own test kit."""

pytest_plugins = ["bus.testing"]
