"""A small family of the tests' own, in a module of its own so that other processes can load it."""

import flatpunch as fp
from atlas_tables import Family, Parameter


def soft_on_stiffer(ratio):
    """Incompressible layer on an incompressible half-space."""
    return fp.Medium([fp.Layer(young=ratio, poisson=0.5, thickness=1.0)], base=fp.HalfSpace(young=1.0, poisson=0.5))


def fails_above_two(ratio):
    """The same, but some media cannot be made."""
    return soft_on_stiffer(ratio) if ratio <= 2 else fp.Medium([], base=None)


SMALL = Family(
    "small",
    "For tests",
    (Parameter("ratio", "E1/E2", 0.3, 3.0, "log"),),
    soft_on_stiffer,
    tolerance=1e-6,
    beta=(0.5, 2.0),
)

FAMILY_FILE = """
name = "gel-on-pdms"
tolerance = 1e-6
beta = { min = 0.5, max = 2.0 }
layers = [{ young = "1 kPa", poisson = 0.5, thickness = "1 um" }]
base = { kind = "half-space", young = "1 MPa", poisson = 0.5 }

[parameters.gel]
path = "layers.0.young"
min = "10 kPa"
max = "1000 kPa"
scale = "log"
"""
