"""Logs that other programs wrote, made into recordings that the replay driver plays."""
