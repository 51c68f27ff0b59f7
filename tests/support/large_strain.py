"""Layers and tips at large strain, and the records of the finite elements that made the tables."""

from pathlib import Path

import numpy as np

import flatpunch as fp
from flatpunch.contact.finite_strain.tables import DEEP, thick_end

H = 5e-6
GEL = fp.Medium([fp.Layer(5e3, 0.4999, H)], base=fp.RigidBase())
LAW = "neo-hookean"
POINTS = Path(__file__).parents[2] / "scripts/finite_strain"


def end_of_spheres(radius, thickness):
    """Largest depth of the tables of spheres."""
    return DEEP * thickness if thickness < radius else radius * thick_end(radius / thickness)


def large(ratio, share, poisson=0.4999):
    """Curve at depths over the thickness H, under a sphere of radius H/ratio."""
    gel = fp.Medium([fp.Layer(5e3, poisson, H)], base=fp.RigidBase())
    return fp.indent(gel, fp.Sphere(H / ratio), depth=np.asarray(share) * H, finite_strain=LAW)


def cone(angle):
    return fp.Cone(inclination=np.radians(angle))
