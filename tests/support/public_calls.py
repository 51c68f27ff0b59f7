"""One valid call of each public constructor and function, with all of its numbers."""

import numpy as np
from matplotlib.figure import Figure

import flatpunch as fp
from flatpunch import bem
from flatpunch.contact.physics import Physics
from flatpunch.fits import Sample, Settings, Tip, oliver_pharr
from flatpunch.fits.films.oliver_pharr import DIAMOND

LAYER = fp.Layer(5e3, 0.45, 2e-6)
GEL = fp.Medium([LAYER], fp.RigidBase())
BODY = fp.HalfSpace(5e3, 0.3)
BALL = fp.Paraboloid(5e-6)
AXIS = np.linspace(-1e-6, 1e-6, 15)
MAP = (AXIS[:, None] ** 2 + AXIS**2) / 2e-5
DEPTH = np.linspace(0, 2e-7, 40)
FORCE = np.abs(DEPTH) ** 1.5
CURVE = fp.Curve(DEPTH, FORCE)
CYCLE = fp.Curve(DEPTH, FORCE, stiffness=FORCE + 1e-9)
TIP = Tip.from_coefficients([24.5, 300.0])
DISC = fp.DiscLoad(1e3, 1e-6)
ROUGH = fp.self_affine(8, 1e-7, rms_height=1e-8)


def drawn(plot):
    """Draw into a figure that nobody keeps."""
    return lambda **given: plot(axes=Figure().add_subplot(), **given)


CALLS = {
    "Layer": (fp.Layer, {"young": 5e3, "poisson": 0.45, "thickness": 2e-6}),
    "FreeLayer": (fp.FreeLayer, {"young": 5e3, "poisson": 0.45, "thickness": 2e-6}),
    "HalfSpace": (fp.HalfSpace, {"young": 5e3, "poisson": 0.3}),
    "GradedLayer": (fp.GradedLayer, {"young": 5e3, "poisson": 0.3, "thickness": 2e-6}),
    "GradedLayer table": (fp.GradedLayer, {"young": ([0.0, 2e-6], [1e3, 2e3]), "poisson": 0.3, "thickness": 2e-6}),
    "GradedLayer of five constants": (
        fp.GradedLayer,
        {
            "young": 2e3,
            "poisson": 0.3,
            "thickness": 2e-6,
            "young_axial": 3e3,
            "poisson_axial": ([0.0, 2e-6], [0.1, 0.2]),
            "shear": 1e3,
        },
    ),
    "TransverselyIsotropicHalfSpace": (
        fp.TransverselyIsotropicHalfSpace,
        {"young_in_plane": 5e3, "young_axial": 4e3, "poisson_in_plane": 0.3, "poisson_axial": 0.2, "shear": 2e3},
    ),
    "TransverselyIsotropicLayer": (
        fp.TransverselyIsotropicLayer,
        {
            "young_in_plane": 5e3,
            "young_axial": 4e3,
            "poisson_in_plane": 0.3,
            "poisson_axial": 0.2,
            "shear": 2e3,
            "thickness": 1e-6,
        },
    ),
    "Interface": (fp.Interface, {"normal": 5e9, "shear": 2e9}),
    "Membrane": (fp.Membrane, {"tension": 1e-3, "stretching": 0.1, "shear": 0.05, "bending": 1e-19}),
    "PowerLawHalfSpace": (fp.PowerLawHalfSpace, {"modulus": 5e3, "depth": 1e-6, "exponent": 0.3, "poisson": 0.3}),
    "LinearModulus": (fp.LinearModulus, {"top": 1e3, "bottom": 2e3, "thickness": 1e-6}),
    "ExponentialModulus": (fp.ExponentialModulus, {"top": 1e3, "bottom": 2e3, "thickness": 1e-6}),
    "PowerModulus": (fp.PowerModulus, {"top": 1e3, "bottom": 2e3, "thickness": 1e-6, "exponent": 2.0}),
    "DepthTable": (fp.DepthTable, {"depths": [0.0, 1e-6], "entries": [1e3, 2e3]}),
    "Prony": (fp.Prony, {"weights": [0.5, 0.2], "times": [1.0, 0.1], "equilibrium": 0.3}),
    "StandardLinearSolid": (fp.StandardLinearSolid, {"equilibrium": 0.3, "time": 1.0}),
    "PowerLawRelaxation": (fp.PowerLawRelaxation, {"exponent": 0.2, "time": 1.0}),
    "DiscLoad": (fp.DiscLoad, {"pressure": 1e5, "radius": 1e-6, "traction": 0.0}),
    "Strength": (fp.Strength, {"yield_stress": 1e9, "tensile": 1e9}),
    "Cylinder": (fp.Cylinder, {"radius": 1e-6}),
    "Paraboloid": (fp.Paraboloid, {"radius": 1e-6}),
    "Sphere": (fp.Sphere, {"radius": 1e-6}),
    "Cone": (fp.Cone, {"inclination": 0.3}),
    "Pyramid": (fp.Pyramid, {"sides": 4, "inclination": 0.3}),
    "PowerLaw": (fp.PowerLaw, {"exponent": 2.0, "angular": 1e5}),
    "PowerLaw table": (
        fp.PowerLaw,
        {"exponent": 2.0, "angular": ([0.0, 1.0, 2.0, 4.0], [1.0, 1.1, 1.0, 1.1]), "corners": [0.0, 1.0]},
    ),
    "EllipticParaboloid": (fp.EllipticParaboloid, {"A": 1e5, "B": 2e5}),
    "Ellipsoid": (fp.Ellipsoid, {"half_x": 1e-6, "half_y": 2e-6, "half_z": 1e-6}),
    "Spheroid": (fp.Spheroid, {"half_width": 1e-6, "half_height": 2e-6}),
    "Superellipse": (
        fp.Superellipse,
        {"half_x": 1e-6, "half_y": 2e-6, "height_at_axes": 1e-7, "power": 4.0, "exponent": 2.0},
    ),
    "FacetedPyramid": (fp.FacetedPyramid, {"directions": [0.0, 2.0, 4.0], "inclinations": [0.3, 0.3, 0.4]}),
    "Rounded": (fp.Rounded, {"tip": fp.Cone(0.3), "radius": 1e-7}),
    "SpheroCone": (fp.SpheroCone, {"inclination": 0.3, "radius": 1e-7}),
    "Truncated": (fp.Truncated, {"tip": fp.Cone(0.3), "height_removed": 1e-8}),
    "Truncated.across": (fp.Truncated.across, {"tip": fp.Cone(0.3), "radius": 1e-8}),
    "Tilted": (fp.Tilted, {"tip": fp.Cone(0.3), "tilt_x": 0.05, "tilt_y": 0.02}),
    "Vickers": (fp.Vickers, {"tip_radius": 1e-8}),
    "Vickers flat": (fp.Vickers, {"height_removed": 1e-8}),
    "Berkovich": (fp.Berkovich, {"tip_radius": 1e-8}),
    "CubeCorner": (fp.CubeCorner, {"tip_radius": 1e-8}),
    "Knoop": (fp.Knoop, {"height_removed": 1e-8}),
    "AfmPyramid": (fp.AfmPyramid, {"front": 0.5, "back": 0.6, "side": 0.4, "tip_radius": 1e-8}),
    "RadialProfile": (fp.RadialProfile, {"r": [0.0, 1.0, 2.0, 3.0], "f": [0.0, 1.0, 3.0, 5.0], "kinks": [1.0]}),
    "RadialProfile.from_area": (fp.RadialProfile.from_area, {"depth": [0.0, 1.0, 2.0], "area": [0.0, 1.0, 4.0]}),
    "AreaFunction": (fp.AreaFunction, {"coefficients": [24.5, 10.0], "limit": 1e-6, "unit": 1e-9, "start": 1e-8}),
    "HeightMap": (
        fp.HeightMap,
        {"x": AXIS, "y": AXIS, "z": MAP, "smoothing": 1e-8, "near": (0.0, 0.0), "reach": 5e-7},
    ),
    "indent depth": (fp.indent, {"medium": GEL, "indenter": BALL, "depth": 1e-7, "angles": 8}),
    "indent force": (fp.indent, {"medium": GEL, "indenter": BALL, "force": 1e-9}),
    "indent radius": (fp.indent, {"medium": GEL, "indenter": BALL, "radius": [1e-7, 2e-7]}),
    "indent adhesive": (
        fp.indent,
        {"medium": BODY, "indenter": BALL, "depth": 1e-7, "work_of_adhesion": 1e-5, "range_of_action": 1e-10},
    ),
    "indent history": (
        fp.indent,
        {
            "medium": BODY,
            "indenter": BALL,
            "depth": [0.0, 1e-7],
            "time": [0.0, 1.0],
            "relaxation": fp.StandardLinearSolid(0.5, 1.0),
        },
    ),
    "BoundaryElements": (fp.BoundaryElements, {"grid": 16, "tolerance": 1e-3, "limit": 50}),
    "Refined": (fp.Refined, {"rtol": 1e-2, "cells": 32}),
    "Target": (fp.Target, {"quantity": "force", "value": [1e-9, 2e-9], "depth": [1e-8, 2e-8]}),
    "LargestLoad": (fp.LargestLoad, {"strengths": fp.Strength(yield_stress=1e6), "friction": 0.1}),
    "Limit": (fp.Limit, {"quantity": "depth", "minimum": 1e-9, "maximum": 1e-8, "force": 1e-9}),
    "design": (
        fp.design,
        {
            "medium": BODY,
            "indenter": BALL,
            "vary": {"base.young": (1e3, 1e4)},
            "objective": fp.Target("force", 1e-9, depth=1e-7),
            "starts": 1,
        },
    ),
    "sensitivity": (fp.sensitivity, {"medium": GEL, "indenter": BALL, "depth": 1e-7, "z": [2e-7, 1e-6]}),
    "sensitivity radius": (fp.sensitivity, {"medium": BODY, "indenter": BALL, "radius": 1e-7}),
    "pressure": (fp.pressure, {"medium": GEL, "indenter": BALL, "x": 0.0, "y": [0.0, 1e-8], "depth": 1e-8}),
    "pressure adhesive": (
        fp.pressure,
        {
            "medium": BODY,
            "indenter": BALL,
            "x": 0.0,
            "y": 0.0,
            "depth": 1e-8,
            "work_of_adhesion": 1e-5,
            "range_of_action": 1e-10,
        },
    ),
    "pull_off": (
        fp.pull_off,
        {"medium": BODY, "indenter": BALL, "work_of_adhesion": 1e-5, "range_of_action": 1e-10},
    ),
    "adhesion_loop": (
        fp.adhesion_loop,
        {
            "medium": BODY,
            "indenter": BALL,
            "work_of_adhesion": 1e-5,
            "depth": 1e-7,
            "points": 10,
            "range_of_action": 1e-10,
        },
    ),
    "partial_slip": (
        fp.partial_slip,
        {
            "medium": BODY,
            "indenter": BALL,
            "friction": 0.3,
            "radius": [1e-7, 2e-7],
            "tangential_force": 0.0,
            "places": 3,
        },
    ),
    "flat_punch": (fp.flat_punch, {"medium": BODY, "radius": 1e-6}),
    "FlatPunch.pressure": (fp.flat_punch(BODY, 1e-6).pressure, {"r": 1e-7}),
    "FlatPunch.moment": (fp.flat_punch(BODY, 1e-6).moment, {"exponent": 1.0}),
    "compliance": (fp.compliance(BODY), {"k": [1e5, 1e6]}),
    "Curve": (
        fp.Curve,
        {"depth": DEPTH, "force": FORCE, "spring_constant": 0.1, "stiffness": FORCE, "time": 1e6 * DEPTH},
    ),
    "Curve.from_piezo": (fp.Curve.from_piezo, {"piezo": DEPTH, "force": FORCE, "spring_constant": 0.1}),
    "Free": (fp.Free, {"start": 1e3, "minimum": 1e2, "maximum": 1e4}),
    "Settings": (Settings, {"contact": 1e-8, "depth_to": 1e-7, "force_to": 1e-9, "level": 0.9}),
    "Sample": (
        Sample,
        {"medium": BODY, "indenter": BALL},
    ),
    "Physics": (Physics, {"work_of_adhesion": 1e-5, "range_of_action": 1e-10}),
    "fit": (
        fp.fit,
        {"curve": CURVE, "medium": BODY, "indenter": BALL, "free": ["base.young"], "contact": 0.0, "level": 0.9},
    ),
    "fit_together": (
        fp.fit_together,
        {
            "curves": [CURVE, fp.Curve(DEPTH, FORCE, name="other")],
            "medium": BODY,
            "indenter": BALL,
            "free": ["base.young"],
            "contact": 0.0,
            "level": 0.9,
        },
    ),
    "plot_medium": (drawn(fp.plot_medium), {"medium": GEL, "contact_radius": 1e-7}),
    "plot_tip": (drawn(fp.plot_tip), {"indenter": BALL, "extent": 1e-6}),
    "correct": (
        fp.correct,
        {"reported": 5e3, "medium": GEL, "indenter": BALL, "depth": 1e-8, "reported_poisson": 0.5, "over": "depth"},
    ),
    "compare_formulas": (fp.compare_formulas, {"medium": GEL, "indenter": BALL, "depth": [1e-8, 2e-8]}),
    "Tip": (Tip, {"area": np.square, "beta": 1.03, "epsilon": 0.75, "material": DIAMOND}),
    "Tip.from_coefficients": (Tip.from_coefficients, {"coefficients": [24.5, 3.0], "unit": 1e-9}),
    "oliver_pharr": (oliver_pharr, {"curve": CYCLE, "tip": TIP, "frame": 1e-9}),
    "Grid": (bem.Grid, {"nx": 16, "ny": 16, "spacing": 1e-7, "center": (0.0, 0.0)}),
    "Grid.around": (bem.Grid.around, {"half_widths": (1e-6, 1e-6), "cells": 32, "margin": 0.25}),
    "PatchLoad": (fp.PatchLoad, {"pressure": [[1e5, 2e5]], "spacing": 1e-7, "traction": 0.0, "center": (0.0, 0.0)}),
    "PatchLoad cells": (fp.PatchLoad, {"pressure": [[1e5, 2e5]], "spacing": 1e-7, "traction": [[0.0, 1e4]]}),
    "DiscLoad elsewhere": (fp.DiscLoad, {"pressure": 1e5, "radius": 1e-6, "center": (1e-6, 0.0)}),
    "fields depth": (
        fp.fields,
        {
            "medium": GEL,
            "indenter": BALL,
            "x": [0.0, 1e-7],
            "y": [1e-8, 0.0],
            "z": [0.0, 1e-6],
            "depth": 1e-8,
            "friction": 0.1,
            "direction": 0.2,
            "residual_stress": [1e2],
        },
    ),
    "fields force": (fp.fields, {"medium": GEL, "indenter": BALL, "x": 0.0, "y": 0.0, "z": 1e-7, "force": 1e-9}),
    "fields radius": (fp.fields, {"medium": GEL, "indenter": BALL, "x": 0.0, "y": 0.0, "z": 1e-7, "radius": 1e-7}),
    "fields adhesive": (
        fp.fields,
        {"medium": BODY, "indenter": BALL, "x": 0.0, "y": 0.0, "z": 1e-7, "depth": 1e-8, "work_of_adhesion": 1e-5},
    ),
    "fields load": (fp.fields, {"medium": GEL, "indenter": DISC, "x": 0.0, "y": 0.0, "z": 1e-7, "friction": 0.1}),
    "fields cells": (
        fp.fields,
        {"medium": BODY, "indenter": fp.EllipticParaboloid(1e5, 2e5), "x": 0.0, "y": 0.0, "z": 1e-7, "depth": 1e-8},
    ),
    "critical_load": (
        fp.critical_load,
        {
            "medium": GEL,
            "indenter": BALL,
            "strengths": fp.Strength(yield_stress=1e3),
            "friction": 0.1,
            "residual_stress": [1e2],
        },
    ),
    "shakedown_load": (
        fp.shakedown_load,
        {
            "medium": fp.HalfSpace(5e3, 0.4),
            "indenter": BALL,
            "strengths": fp.Strength(yield_stress=1e3),
            "friction": 0.1,
        },
    ),
    "conductance": (fp.conductance, {"medium": GEL, "contact": [1e-7, 2e-7], "conductivity": [1.0, 2.0]}),
    "energy_by_depth depth": (
        fp.energy_by_depth,
        {"medium": GEL, "indenter": BALL, "depth": 1e-8, "z": [1e-7, 1e-6]},
    ),
    "energy_by_depth force": (fp.energy_by_depth, {"medium": GEL, "indenter": BALL, "force": 1e-9}),
    "energy_by_depth radius": (fp.energy_by_depth, {"medium": GEL, "indenter": BALL, "radius": 1e-7}),
    "energy_by_depth adhesive": (
        fp.energy_by_depth,
        {"medium": GEL, "indenter": BALL, "radius": 1e-7, "work_of_adhesion": 1e-5},
    ),
    "Roller crown": (fp.Roller, {"radius": 1e-3, "length": 1e-3, "crown": 1.0}),
    "Roller ends": (fp.Roller, {"radius": 1e-3, "length": 1e-3, "end_radius": 1e-4}),
    "RoundedPunch": (fp.RoundedPunch, {"half_width": 1e-3, "corner_radius": 1e-4, "sides": 4}),
    "Topography": (fp.Topography, {"heights": np.eye(8) * 1e-8, "spacing": 1e-7}),
    "self_affine height": (
        fp.self_affine,
        {"shape": (8, 8), "spacing": 1e-7, "hurst": 0.8, "rms_height": 1e-8, "roll_off": 5e-7, "cut_off": 2e-7},
    ),
    "self_affine slope": (fp.self_affine, {"shape": 8, "spacing": 1e-7, "rms_slope": 0.1, "seed": 1}),
    "rough_contact hardness": (
        fp.rough_contact,
        {"medium": GEL, "topography": ROUGH, "pressure": 1e1, "hardness": 1e3, "tolerance": 1e-6},
    ),
    **{
        f"rough_contact {name}": (
            fp.rough_contact,
            {"medium": GEL, "topography": ROUGH, name: value, "tolerance": 1e-6},
        )
        for name, value in (("pressure", [1e1, 1e2]), ("force", 1e-11), ("depth", 1e-8))
    },
    **{
        f"asperities {name}": (
            fp.asperities,
            {"medium": BODY, "tips": BALL, "positions": [(0.0, 0.0), (1e-5, 0.0)], "heights": [0.0, 0.0], name: value},
        )
        for name, value in (("depth", [1e-8, 2e-8]), ("force", 1e-10))
    },
}
