"""Numbers of the page for people from AFM and nanoindentation, recomputed by the examples that draw its pictures."""

import importlib.util
import re
from functools import lru_cache
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest

import flatpunch as fp

mpl.use("agg")
ROOT = Path(__file__).resolve().parents[2]


def example(name):
    """A script of the gallery as a module."""
    path = ROOT / "docs" / "examples" / "papers" / f"{name}.py"
    spec = importlib.util.spec_from_file_location(name, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def rows(columns):
    """Tables of the page with that many columns, as lists of cells."""
    text = (ROOT / "docs" / "afm.md").read_text(encoding="utf-8")
    lines = [[cell.strip() for cell in line.strip("| ").split(" | ")] for line in re.findall(r"^\|.*\|$", text, re.M)]
    return [cells for cells in lines if len(cells) == columns and "---" not in cells[0]][1:]


@lru_cache(maxsize=1)
def thin_layers():
    """Formula values and exact ones, by (tip, formula)."""
    module, x = example("plot_thin_layer_corrections"), np.geomspace(0.01, 2.0, 160)
    found = {(tip, name): (formula, exact) for name, tip, formula, exact in module.comparisons(x) + module.others(x)}
    return module, x, found


@pytest.mark.long
def test_ranges_of_thin_layer_formulas():
    module, x, found = thin_layers()
    shown = {(tip, name): [float(end) for end in ends] for tip, name, *ends in rows(5)}
    assert set(shown) == set(found)
    for key, ends in shown.items():
        # steps of 3.4 % in x, and two printed digits
        np.testing.assert_allclose(module.ranges(x, *found[key]), ends, rtol=0.035, atol=0.01, err_msg=str(key))


def test_new_formula_for_pyramids():
    module, _, found = thin_layers()
    assert len(rows(9)) == 4
    for sides, sample, force, *coefficients, within in rows(9):
        n, bonded = int(sides), sample == "bonded"
        numbers = [float(c.replace("−", "-")) for c in coefficients]
        assert numbers == list(module.PYRAMID[n, bonded])
        assert float(force) == pytest.approx(module.FORCE[n], abs=5e-5)
        tip = {4: "four", 3: "three"}[n] + "-sided pyramid" + ("" if bonded else ", sliding")
        formula, exact = found[tip, "new formula"]
        # `refined` has 0.03 % of its own
        assert np.abs(formula / exact - 1).max() < float(within.rstrip(" %")) / 100 - 3e-4
        moment = {True: 1.77022, False: 1.16758}[bonded]
        assert numbers[0] == pytest.approx(2 * module.FORCE[n] * moment / np.pi, abs=5e-5)
    # boundary elements, of which 128 cells leave 1e-4
    bem = float(
        fp.indent(module.layer(), fp.Pyramid(4, np.pi / 4), depth=0.7, method=fp.BoundaryElements(grid=128)).force[0]
    )
    assert bem / (module.FORCE[4] * 0.7**2) == pytest.approx(float(module.new_factor(0.7)), rel=1.5e-3)


def test_limits_and_signs_of_thin_layer_formulas():
    module, _, _ = thin_layers()
    published = module.published
    x = np.array([6.4, 9.6])
    # unit of pressure E* = 1, so E = 3/4
    chadwick = published.chadwick(1.0, x**2, 0.75, 1.0) / (4 / 3 * x**3)
    np.testing.assert_allclose(np.abs(chadwick / module.paraboloid(x) - 1), [0.10, 0.05], atol=0.002)
    # the general formula towards nu = 1/2 and the special case differ in the sign of the fourth coefficient
    nodes = np.array([0.5, 1.0, 1.5, 2.0, 2.5])
    vandermonde = np.vander(nodes, 5, increasing=True)
    general, special = (
        np.linalg.solve(vandermonde, published.dimitriadis(nodes, nu, True))[4] for nu in (0.5 - 1e-9, 0.5)
    )
    assert (general, special) == pytest.approx((-0.0975, 0.0975), abs=2e-5)
    # a sliding layer knows no Poisson ratio
    first = [np.linalg.solve(vandermonde, published.dimitriadis(nodes, nu, False))[1] for nu in (0.27, 0.5)]
    assert first == pytest.approx([0.7433, 0.884], abs=2e-3)


@pytest.mark.long
def test_ranges_of_film_formulas():
    module, y = example("plot_coated_half_space"), np.geomspace(0.05, 20, 100)
    exact = {ratio: module.exact(y, ratio) for ratio in (10.0, 2.0, 0.5, 0.1)}
    assert len(rows(6)) == 12
    for ratio, name, largest, *stretches in rows(6):
        values, truth = module.FORMULAS[name](y, float(ratio)), exact[float(ratio)]
        assert 100 * np.abs(values / truth - 1).max() == pytest.approx(float(largest.rstrip(" %")), abs=0.7)
        for limit, shown in zip((0.01, 0.05, 0.10), stretches, strict=True):
            printed = [float(end) for end in re.findall(r"[\d.]+", shown)]
            found = np.array(module.intervals(y, values, truth, limit)).ravel()
            # steps of 6 % in y, and two printed digits; narrow stretches may fall between two steps
            if len(found) == len(printed):
                np.testing.assert_allclose(found, printed, rtol=0.075, err_msg=f"{ratio} {name} {limit}")
            else:
                assert all(b / a < 1.15 for a, b in zip(printed[::2], printed[1::2], strict=True)), (name, limit)


def test_the_picture_is_drawn():
    figure = thin_layers()[0].main()
    assert len(figure.axes) == 2
    assert len(figure.legends[0].get_texts()) == 12
