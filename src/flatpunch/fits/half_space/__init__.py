"""Half-space models in use, and what they make of a layer."""
