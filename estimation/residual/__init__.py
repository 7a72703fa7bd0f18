"""Momentum residuals: classical, internal and external."""
