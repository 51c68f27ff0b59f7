"""Finite elements at large strain: a rigid frictionless tip pressed into a hyperelastic layer or half-space.

Development only (`pip install flatpunch[strain]` brings scikit-fem): the table that ships with the package is made here.
"""
