"""`finite_strain` outside its tables is refused by name; notes of linear results give the factor."""

import re

import numpy as np
import pytest

import flatpunch as fp
from support.large_strain import GEL, LAW, H


@pytest.mark.parametrize(
    ("medium", "tip", "steps", "words"),
    [
        (
            GEL,
            fp.Pyramid(4, 1.1),
            {"depth": 1e-7},
            "edges and faces of pyramids.*10 to 60 degrees; here it is 63.02536 degrees",
        ),
        (GEL, fp.Knoop(), {"depth": 1e-7}, "here it is 3.75 degrees"),
        (GEL, fp.Berkovich(tip_radius=1e-8), {"depth": 1e-7}, "sharp pyramids; the tip is Rounded"),
        (GEL, fp.SpheroCone(1.1, 1e-6), {"depth": 1e-7}, "inclined by 10 to 60 degrees; here it is 63.02536 degrees"),
        (GEL, fp.Rounded(fp.Cone(0.5), 1e-6, true_sphere=False), {"depth": 1e-7}, "SpheroCone.*the tip is Rounded"),
        (GEL, fp.SpheroCone(0.5, 1e-6), {"depth": [1e-7, 2.5e-6]}, r"depth\[1\] = 2.5 µm .* end at 2.361 µm"),
        (GEL, fp.Paraboloid(1e-5), {"depth": 1e-7}, "the tip is Paraboloid"),
        (GEL, fp.Cone(np.radians(9)), {"depth": 1e-7}, "inclined by 10 to 60 degrees; here it is 9 degrees"),
        (GEL, fp.Cone(np.radians(70)), {"depth": 1e-7}, "inclined by 10 to 60 degrees; here it is 70 degrees"),
        (fp.HalfSpace(5e3, 0.3), fp.Cone(0.5), {"depth": 1e-7}, "Poisson ratios from 0.4 to 0.5; here"),
        (
            GEL,
            fp.Cone(0.5),
            {"depth": [1e-7, 3e-6]},
            r"depth\[1\] = 3 µm .* ends at 2.5 µm, half of the thickness\. Ask",
        ),
        (
            fp.HalfSpace(5e3, 0.3),
            fp.Sphere(1e-5),
            {"depth": 1e-7},
            "Poisson ratios from 0.4 to 0.5; here it is 0.3",
        ),
        (GEL, fp.Sphere(1e-3), {"depth": 1e-7}, "0.1 or more radii of the sphere; here it is 0.005"),
        (fp.Medium([GEL.layers[0]], base=fp.HalfSpace(1e9, 0.3)), fp.Sphere(1e-5), {"depth": 1e-7}, "RigidBase"),
        (
            fp.Medium([fp.Layer(5e3, 0.5, H, bonded=False)], base=fp.RigidBase()),
            fp.Sphere(1e-5),
            {"depth": 1e-7},
            "bonded",
        ),
        (GEL, fp.Sphere(1e-5), {"depth": [1e-7, 3e-6]}, r"depth\[1\] = 3 µm .* ends at 2.5 µm"),
        (GEL, fp.Sphere(1e-5), {"force": 1e-6}, r"force\[0\] = 1 µN .* ends at 2.5 µm"),
        (GEL, fp.Sphere(1e-5), {"radius": 1e-6}, "goes with depth or force"),
        (GEL, fp.Sphere(1e-5), {"depth": 1e-7, "work_of_adhesion": 1e-3}, "does not go with work_of_adhesion"),
    ],
)
def test_what_the_table_does_not_hold_is_refused_by_name(medium, tip, steps, words):
    with pytest.raises(ValueError, match=words):
        fp.indent(medium, tip, finite_strain=LAW, **steps)


def test_unknown_laws_are_refused():
    with pytest.raises(ValueError, match="neo-hookean"):
        fp.indent(GEL, fp.Sphere(1e-5), depth=1e-7, finite_strain="gent")


def test_notes_give_the_number_instead_of_a_warning():
    tip = fp.Sphere(10e-6)
    assert "2 µm a neo-Hookean solid takes" in fp.indent(GEL, tip, depth=2e-6).attrs["notes"]
    assert "trains" not in fp.indent(GEL, tip, depth=2e-6, finite_strain=LAW).attrs["notes"]


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ({"depth": 2.4e-6}, "at 2.4 µm a .* corrects it."),
        ({"depth": 2.6e-6}, "at 2.5 µm, where the table ends, .* corrects it up to there."),
        ({"depth": 2.4e-6, "work_of_adhesion": 1e-5}, "than linear theory.(\n|$)"),
        (
            {"depth": [0.0, 2.4e-6], "time": [0.0, 1.0], "relaxation": fp.Prony([0.5], [1.0])},
            "than linear theory.(\n|$)",
        ),
    ],
)
def test_the_correction_is_advised_where_it_goes(more, words):
    assert re.search(words, fp.indent(GEL, fp.Sphere(1e-5), **more).attrs["notes"])
