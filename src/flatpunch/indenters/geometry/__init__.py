"""Geometry of indenters: means and harmonics over the polar angle, symmetry, edges, flat ends."""
