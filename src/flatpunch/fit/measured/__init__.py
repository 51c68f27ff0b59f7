"""Reading measured curves."""
