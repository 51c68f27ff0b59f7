"""One valid call of each public name of the rooms beside the main one: atlas, bem, kernels, plug-ins, theories, pictures."""

import tempfile
from functools import cache, partial
from pathlib import Path

import numpy as np

import flatpunch as fp
from flatpunch import atlas, bem, kernels
from flatpunch.plugins import hosts
from flatpunch.plugins.force_models import write_nanite_model, write_softmech_model
from flatpunch.plugins.micromechanics import film
from flatpunch.plugins.slippy import write_slippy_material
from support.public_calls import BALL, BODY, CALLS, GEL, LAYER, ROUGH, drawn

CELLS = bem.Grid(16, 16, 1e-7)
BOUND = fp.Medium([fp.Layer(1e4, 0.3, 1e-6)], fp.RigidBase())
WAVES = {"medium": GEL, "qx": [1e6, 2e6], "qy": 1e6}


@cache
def side_calls():
    """Names with functions and arguments, all of them given."""
    table, kernel = atlas.table("bonded-layer"), fp.compliance(BODY)
    punch, disc = table.at(poisson=0.3), np.hypot(*np.meshgrid(CELLS.x, CELLS.y)) < 6e-7
    rough = fp.rough_contact(BODY, ROUGH, pressure=[1e1, 1e2])
    curve = fp.indent(BODY, BALL, depth=[1e-8, 2e-8])
    written = partial(Path(tempfile.mkdtemp()).joinpath, "model_written.py")
    return {
        **_numbers(table, punch, kernel, disc, rough),
        **_files(written()),
        **_pictures(curve, rough),
    }


def _numbers(table, punch, kernel, disc, rough):
    return {
        "atlas.dundurs": (atlas.dundurs, {"film": LAYER, "base": BODY}),
        "atlas.table": (atlas.table, {"name": "bonded-layer"}),
        "atlas.read_table": (atlas.read_table, {"path": "none.nc"}),
        "atlas.tabulated": (atlas.tabulated, {"medium": BOUND, "outside": "solve", "table": table}),
        "Table.at": (table.at, {"poisson": 0.3}),
        "Table.stiffness_and_moments": (
            table.stiffness_and_moments,
            {"beta": [1.0, 2.0], "exponents": [2.0], "poisson": 0.3},
        ),
        "Table.edge_coefficients": (table.edge_coefficients, {"beta": [1.0, 2.0], "poisson": 0.3}),
        "Solution.covers": (punch.covers, {"beta": np.ones(2)}),
        "Solution.summary": (punch.summary, {"beta": np.ones(2)}),
        "Solution.normalized_stiffness": (punch.normalized_stiffness, {"beta": [1.0, 2.0]}),
        "Solution.moment": (punch.moment, {"beta": 1.0, "exponent": 2.0}),
        "Solution.edge_coefficient": (punch.edge_coefficient, {"beta": 1.0}),
        "Solution.pressure": (punch.pressure, {"beta": 1.0, "rho": np.array([0.0, 0.5])}),
        "Solution.responses": (punch.responses, {"beta": 1.0, "order": 4, "exponent": 2.0}),
        "bem.required_bytes": (bem.required_bytes, {"grid": CELLS, "single": False}),
        "bem.trace_outline": (
            bem.trace_outline,
            {
                "grid": CELLS,
                "pressure": disc.astype(float),
                "angles": 16,
                "rim": 0.5,
                "length": np.inf,
                "sharp": True,
            },
        ),
        "bem.solve": (
            bem.solve,
            {
                "kernel": kernel,
                "indenter": BALL,
                "depths": 1e-8,
                "grid": 16,
                "tolerance": 1e-3,
                "limit": 50,
                "half_widths": [(2e-7, 2e-7)],
                "centers": [(0.0, 0.0)],
                "search": True,
                "stiffness": False,
                "angles": 16,
                "single": False,
            },
        ),
        "bem.solve forces": (bem.solve, {"kernel": kernel, "indenter": BALL, "forces": 1e-9, "grid": 16}),
        "bem.solve_punch": (
            bem.solve_punch,
            {
                "kernel": kernel,
                "planform": disc,
                "grid": CELLS,
                "depth": 1e-8,
                "tolerance": 1e-3,
                "limit": 50,
                "face": np.zeros(CELLS.shape),
                "angles": 16,
                "single": False,
            },
        ),
        "Grid.scaled": (CELLS.scaled, {"factor": 2.0}),
        "kernels.surface_compliance": (kernels.surface_compliance, {**WAVES, "rtol": 1e-6, "undetermined": 0.0}),
        "kernels.surface_stiffness": (kernels.surface_stiffness, {**WAVES, "rtol": 1e-6, "undetermined": 0.0}),
        "kernels.normal_compliance": (
            kernels.normal_compliance,
            {"medium": GEL, "q": [0.0, 1e6], "undetermined": 0.0},
        ),
        "kernels.influence_coefficients": (
            kernels.influence_coefficients,
            {"medium": BODY, "spacing": 1e-7, "shape": (4, 4)},
        ),
        "kernels.interior": (kernels.interior, {**WAVES, "z": [0.0, 1e-7], "side": "below"}),
        "homogenised": (fp.homogenised, {"layers": [LAYER, LAYER]}),
        "compliance": (fp.compliance, {"medium": BODY}),
        "full_contact": (fp.full_contact, {"medium": BODY, "spectrum": ROUGH}),
        "rough_stresses": (
            fp.rough_stresses,
            {
                "medium": BODY,
                "contact": fp.rough_contact(BODY, ROUGH, pressure=1e2, fields=True),
                "depths": [0.0, 1e-7],
                "step": 0,
                "friction": 0.1,
                "direction": 0.2,
                "strengths": fp.Strength(shear=1e3),
                "fields": False,
            },
        ),
        "rough_theories": (fp.rough_theories, {"contact": rough, "medium": BODY, "topography": ROUGH}),
        "FullContact.area_fraction": (fp.full_contact(BODY, ROUGH).area_fraction, {"pressure": [1.0, 2.0]}),
    }


def _files(path):
    case = {"path": path, "medium": BOUND, "indenter": BALL, "title": "a gel", "method": "auto"}
    return {
        "write_nanite_model": (write_nanite_model, {**case, "key": "gel"}),
        "write_softmech_model": (write_softmech_model, case),
        "write_slippy_material": (
            write_slippy_material,
            {"path": path, "medium": BOUND, "title": "", "depths": [1e-7], "spacing": 1e-7, "cells": 2},
        ),
        "write_plugin": (hosts.write_plugin, {"host": "tamaas", "path": path, "case": None}),
        "micromechanics.film": (partial(film, medium=BOUND), {"indentation": None}),
    }


def _pictures(curve, rough):
    plane = fp.fields(BODY, BALL, [[0.0], [1e-7]], 0.0, [0.0, 1e-7], depth=1e-8)
    designed = CALLS["design"][0](**CALLS["design"][1])
    fitted = CALLS["fit"][0](**CALLS["fit"][1])
    return {
        "plot_curve": (drawn(fp.plot_curve), {"result": curve, "stiffness": True, "label": "one"}),
        "plot_design": (drawn(fp.plot_design), {"result": designed}),
        "plot_fields": (
            drawn(fp.plot_fields),
            {
                "result": plane,
                "quantity": "von_mises",
                "medium": BODY,
                "strengths": [fp.Strength(yield_stress=1e3)],
            },
        ),
        "plot_fit": (drawn(fp.plot_fit), {"result": fitted, "label": "one"}),
        "plot_medium": (drawn(fp.plot_medium), {"medium": GEL, "contact_radius": 1e-7}),
        "plot_outline": (drawn(fp.plot_outline), {"result": curve, "indenter": BALL, "step": 0, "label": "one"}),
        "plot_pressure": (
            drawn(fp.plot_pressure),
            {"result": curve, "medium": BODY, "indenter": BALL, "step": 0},
        ),
        "plot_rough": (
            drawn(fp.plot_rough),
            {"contact": rough, "theories": fp.rough_theories(rough, BODY, ROUGH)},
        ),
        "plot_sensitivity": (
            drawn(fp.plot_sensitivity),
            {"result": fp.sensitivity(BODY, BALL, depth=1e-8), "label": "one"},
        ),
        "plot_tip": (
            drawn(fp.plot_tip),
            {"indenter": BALL, "extent": 1e-6, "view": "sections", "label": "one"},
        ),
        "axes": (fp.plot_rough, {"contact": rough, "axes": None}),
    }
