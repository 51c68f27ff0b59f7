"""Slightly non-round contact: the method of Forsbach and Willert, and exact perturbation theory to second and fourth order."""
