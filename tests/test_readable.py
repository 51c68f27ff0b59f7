"""Objects show themselves in one line with sensible digits, as a table with units, and as HTML in notebooks."""

import re
from dataclasses import is_dataclass
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

import flatpunch as fp
from flatpunch._support.readable import source_of

GEL = fp.Medium([fp.Layer(young=5e3, poisson=0.5, thickness=1.2e-6)], base=fp.HalfSpace(young=70e9, poisson=0.22))
R = np.linspace(0, 1e-6, 50)
API = Path(__file__).resolve().parents[1] / "docs" / "api.md"
THINGS = [
    GEL,
    fp.TwoBodies(GEL, fp.RigidBase()),
    fp.GradedLayer(young=fp.LinearModulus(1e9, 2e9, 1e-6), poisson=0.3, thickness=1e-6),
    fp.PowerLawHalfSpace(1e9, 1e-6, 0.3, 0.3),
    fp.Prony([0.5], [1.0]),
    fp.Berkovich(tip_radius=50e-9),
    fp.Vickers(height_removed=1e-8),
    fp.Tilted(fp.Sphere(1e-6), 0.01),
    fp.RadialProfile(R, R**2),
    fp.HeightMap(R - 5e-7, R - 5e-7, ((R[:, None] - R[24]) ** 2 + (R - R[24]) ** 2) * 1e6),
    fp.Refined(),
    fp.BoundaryElements(grid=64),
    fp.Strength(yield_stress=1e9),
    fp.Curve(depth=R, force=R),
    fp.pull_off(GEL, fp.Sphere(5e-6), work_of_adhesion=1e-4),
    fp.flat_punch(GEL, 1e-6),
    fp.compliance(GEL),
    *fp.bem.solve(fp.compliance(fp.HalfSpace(1e6, 0.3)), fp.Paraboloid(1e-3), depths=1e-5, grid=64),
    fp.atlas.table("bonded-layer"),
    fp.atlas.table("bonded-layer").at(poisson=0.3),
    fp.read_case(next(path for path in fp.files.shipped_cases() if path.stem == "afm_pyramid_on_gel")),
    fp.Target("force", [1e-3], depth=[1e-7]),
]


@pytest.mark.parametrize("thing", THINGS, ids=lambda thing: type(thing).__name__)
def test_line_table_and_html(thing):
    line, table, html = repr(thing), str(thing), thing._repr_html_()
    assert line.startswith(f"{type(thing).__name__}(")
    assert "\n" not in line
    assert len(line) < 600
    assert len(table.splitlines()) > 1
    assert html.count("<tr>") >= len(table.splitlines()) - 1
    # no more than six digits anywhere
    assert "0000000" not in line + table


def test_every_public_class_of_data_shows_itself():
    names = re.findall(r"^   ([\w.]+)$", API.read_text(encoding="utf-8"), re.MULTILINE)
    parts = (
        (import_module(f"flatpunch.{name.rpartition('.')[0]}".rstrip(".")), name.rpartition(".")[2]) for name in names
    )
    things = [getattr(part, name, None) for part, name in parts]
    classes = [thing for thing in things if isinstance(thing, type) and is_dataclass(thing)]
    assert len(classes) > 60
    assert [each.__name__ for each in classes if not hasattr(each, "_repr_html_")] == []


def test_media_are_tables_of_layers_with_units():
    assert str(GEL).splitlines() == [
        "Medium, from the surface down",
        "           young   poisson  thickness   lower face",
        "  layer 1  5 kPa   0.5      1.2 µm      bonded",
        "  base     70 GPa  0.22     half-space",
    ]
    assert repr(fp.Pyramid(4, np.radians(55))) == "Pyramid(sides=4, inclination=0.959931)"
    assert str(fp.Pyramid(4, np.radians(55))) == "Pyramid\n  sides        4\n  inclination  55 deg"


def test_a_start_has_a_unit_where_it_is_a_depth():
    assert str(fp.Free(0.4, maximum=0.5)) == "Free\n  start    0.4\n  minimum  None\n  maximum  0.5"
    assert "start         20 nm" in str(fp.AreaFunction([24.5], limit=1e-6, start=20e-9))


def test_source_makes_the_same_again():
    made = eval(source_of(GEL), vars(fp) | {name: getattr(fp, name) for name in ("Medium", "Layer", "HalfSpace")})
    assert made == GEL
    tip = fp.AfmPyramid(0.3, 0.4, 0.5, tip_radius=1e-8 / 3)
    assert eval(source_of(tip), {name: getattr(fp, name) for name in ("Rounded", "FacetedPyramid")}) == tip


def test_fits_are_tables_of_estimates():
    depth = np.linspace(-2e-7, 4e-7, 300)
    force = np.zeros(300)
    force[depth > 0] = fp.indent(GEL, fp.Sphere(5e-6), depth=depth[depth > 0]).force
    curve = fp.Curve(depth=depth, force=force + 1e-11 * np.random.default_rng(0).normal(size=300), name="gel")
    result = fp.fit(curve, GEL, fp.Sphere(5e-6), ["layers[0].young"])
    assert repr(result).startswith("FitResult('gel': layers[0].young=")
    assert "Young's modulus of layer 1" in str(result)
    assert "95 % interval" in str(result)
    assert "<td>Young&#x27;s modulus of layer 1</td>" in result._repr_html_()
    batch = fp.fit_batch([curve], GEL, fp.Sphere(5e-6), ["layers[0].young"])
    assert repr(batch) == "Batch(1 curves, 0 left out)"
    assert "gel" in str(batch)
