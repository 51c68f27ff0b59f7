"""All figures, tables and the page that puts them side by side."""

from __future__ import annotations

import csv
import html
import io
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from flatpunch._support.checks import Array
from flatpunch._support.whole_file import write_whole
from flatpunch._version import __version__
from paper import base_stress, draw, statements, style
from paper.cases import LAYERS, TITLES, Body
from paper.data import FAST, METHODS, NAMES, Curves, Map, curves, eccentricity_map, outlines
from paper.plan import Plan
from paper.points import Store
from paper.statements import Statement


@dataclass
class Report:
    """What has been made so far.

    Attributes
    ----------
    folder : Path
        Where everything is written.
    sections : list of (title, text, picture names)
        Of the page, in order.
    deviations : list of rows
        (figure, case, quantity, method, largest deviation).
    statements : list of Statement
        The paper's statements.
    """

    folder: Path
    sections: list[tuple[str, str, list[tuple[str, str]]]] = field(default_factory=list)
    deviations: list[tuple[str, str, str, str, float]] = field(default_factory=list)
    statements: list[Statement] = field(default_factory=list)

    def picture(self, name: str, figure: Figure, header: str, rows: list[list[object]]) -> None:
        """Write a figure and its data."""
        style.save(figure, self.folder, name)
        _write_csv(self.folder / f"{name}.csv", header.split(), rows)


def make(plan: Plan, figures: tuple[int, ...], store: Store, folder: Path, step: Callable[[str], None]) -> Report:
    """Draw the chosen figures from a store that holds all its points, and write the page."""
    report = Report(folder)
    asked = set(figures)
    with style.look():
        maps = []
        for body, pair in zip(LAYERS, ((2, 3), (4, 5)), strict=True):
            if asked & set(pair):
                step(f"figures {pair[0]} and {pair[1]}")
                maps.append(_maps(report, plan, body, pair, store))
        sets: list[list[Curves]] = []
        for body, pair in zip(LAYERS, ((6, 7), (8, 9)), strict=True):
            if asked & set(pair):
                step(f"figures {pair[0]} and {pair[1]}")
                panels = [curves(plan, body, "ellipse", e, store) for e in plan.curve_eccentricities]
                _curves(report, panels, pair, f"elliptic paraboloid on the {TITLES[body]}")
                sets += panels
        if 10 in asked:
            step("figure 10")
            _outlines(report, plan, store)
        if asked & {11, 12}:
            step("figures 11 and 12")
            panels = [curves(plan, body, "pyramid", 0.0, store) for body in LAYERS]
            _curves(report, panels, (11, 12), "square pyramid; the paper leaves the bonded incompressible layer out")
            sets += panels
        step("statements")
        if maps:
            report.statements.append(statements.eccentricity_error(maps))
            if maps[0].body == "unbonded":
                report.statements.append(statements.never_below(maps[0]))
            report.statements.append(statements.half_space_range(maps))
        if 10 in asked:
            report.statements.append(statements.corners([outlines(plan, body, store) for body in LAYERS]))
        if sets:
            report.statements.append(statements.force_curves(sets))
            report.statements.append(statements.thin_layers())
        _base(report, plan, store, asked)
    _tables(report)
    write_whole(folder / "index.html", page(report).encode())
    return report


def _maps(report: Report, plan: Plan, body: Body, pair: tuple[int, int], store: Store) -> Map:
    found = eccentricity_map(plan, body, store)
    names = {"bem": f"figure_{pair[0]:02}", "first-order": f"figure_{pair[1]:02}"}
    pictures = []
    for method in METHODS:
        name = names.get(method, f"figure_{pair[1]:02}_second_order")
        e_g, log_h, excess = found.fine[method]
        rows: list[list[object]]
        if method == "bem":
            rows = [
                [e, x, y]
                for e, xs, ys in zip(
                    found.eccentricity[1:], found.log_thickness[1:], found.excess["bem"][1:], strict=True
                )
                for x, y in zip(xs, ys, strict=True)
            ]
        else:
            rows = [[e, x, excess[i, j]] for i, e in enumerate(e_g) for j, x in enumerate(log_h)]
        report.picture(name, draw.eccentricity(found, method), "e_g log10_h_over_a0 e_minus_e_g", rows)
        pictures.append((name, NAMES[method]))
    differences = []
    for method in FAST:
        name = f"figure_{pair[1]:02}_{method.replace('-', '_')}_minus_bem"
        delta = found.excess[method] - found.excess["bem"]
        rows = [
            [e, x, y]
            for e, xs, ys in zip(found.eccentricity[1:], found.log_thickness[1:], delta[1:], strict=True)
            for x, y in zip(xs, ys, strict=True)
        ]
        report.picture(name, draw.eccentricity_difference(found, method), "e_g log10_h_over_a0 difference_of_e", rows)
        differences.append((name, f"{NAMES[method]} minus boundary elements"))
        label = f"{pair[0]}, {pair[1]}"
        report.deviations.append((label, TITLES[body], "e, absolute", method, float(np.nanmax(np.abs(delta)))))
        relative = delta[1:] / (found.eccentricity[1:, None] + found.excess["bem"][1:])
        report.deviations.append((label, TITLES[body], "e, relative", method, float(np.nanmax(np.abs(relative)))))
    report.sections.append(
        (
            f"Figures {pair[0]} and {pair[1]}: contact eccentricity, {TITLES[body]}",
            "Difference between the eccentricities of contact and indenter. Thick layers are on the left, as in the paper. Dots: "
            "boundary element solutions, from which the map is interpolated.",
            pictures + differences,
        )
    )
    return found


def _curves(report: Report, panels: list[list[Curves]], pair: tuple[int, int], title: str) -> None:
    radius, force = (f"figure_{n:02}" for n in pair)
    header = "body shape e_g h_over_a_half_space d_over_d_max method a0_over_h F_over_F_exact F_over_F_same_method"
    rows = [row for group in panels for curve in group for row in _rows(curve)]
    report.picture(radius, draw.radii(panels), header, rows)
    report.picture(force, draw.forces(panels), header, rows)
    for group in panels:
        case = group[0]
        name = TITLES[case.body] + (f", e_g = {case.eccentricity:g}" if case.shape == "ellipse" else ", square pyramid")
        for method in FAST:
            worst = max(float(np.max(np.abs(c.radius_deviation(method)))) for c in group)
            report.deviations.append((str(pair[0]), name, "a0, relative", method, worst))
            for same in (True, False):
                worst = max(float(np.max(np.abs(c.force_deviation(method, same=same)))) for c in group)
                over = "same method" if same else "exact"
                report.deviations.append((str(pair[1]), name, f"F, half-space {over}", method, worst))
    report.sections.append(
        (
            f"Figures {pair[0]} and {pair[1]}: {title}",
            "Mean contact radius and force over depth; h is given over the contact radius of the half-space at the largest "
            "depth. The paper's text states neither its eccentricity nor by which method's half-space its force is normalised: "
            "both are varied here. Force: left, F over the largest force of the same method on a half-space; right, over the "
            "exact one.",
            [(radius, "mean contact radius"), (force, "force")],
        )
    )


def _rows(curve: Curves) -> list[list[object]]:
    head: list[object] = [curve.body, curve.shape, curve.eccentricity, curve.thickness]
    rows: list[list[object]] = []
    for method in METHODS:
        if method == "bem":
            depth, a, force = (np.asarray(curve.bem[name]) for name in ("depth", "radius", "force"))
        else:
            depth, a, force = (curve.lines[method][name].values for name in ("depth", "radius", "force"))
        own = curve.own.get(method, curve.exact)
        for d, r, f in zip(depth, a, force, strict=True):
            rows.append([*head, d / curve.deepest, method, r, f / curve.exact, f / own])
    return rows


def _outlines(report: Report, plan: Plan, store: Store) -> None:
    pair = [outlines(plan, body, store) for body in LAYERS]
    rows: list[list[object]] = [
        [found.body, method, phi, a]
        for found in pair
        for method in METHODS
        for phi, a in zip(found.phi, found.contours[method], strict=True)
    ]
    report.picture("figure_10", draw.pyramid_outlines(pair), "body method phi a_tan_alpha_over_d", rows)
    for found in pair:
        for method in FAST:
            ratio = np.abs(found.contours[method] / found.contours["bem"] - 1)
            report.deviations.append(
                ("10", TITLES[found.body], "a(phi), relative, largest", method, float(np.max(ratio)))
            )
            report.deviations.append(
                ("10", TITLES[found.body], "a(phi), relative, median", method, float(np.median(ratio)))
            )
    report.sections.append(
        (
            "Figure 10: contact outline under a square pyramid, h = a0",
            "Grey: cells in contact in the boundary element solution. Each outline is drawn at the same mean radius, over "
            "its own depth.",
            [("figure_10", "outline")],
        )
    )


def _base(report: Report, plan: Plan, store: Store, asked: set[int]) -> None:
    """Stress at the base: round contacts always, others as far as their points are there."""
    radii = (0.1, 0.2, 0.3, 0.5, 0.7, 1.0, 1.4, 1.7, 2.0, 2.5, 3.0, 4.0, 6.0, 10.0)
    solved = {a: base_stress.under_round(a) for a in radii}
    radius = np.array(radii)
    largest, pull = (np.array([getattr(solved[a], name) for a in radii]) for name in ("tension", "pull"))
    points = [p for p in plan.points(tuple(asked)) if p.base]
    others: dict[str, tuple[Array, Array]] = {}
    for name, wanted in (
        ("elliptic paraboloid, $e_g = 0.8$", [p for p in points if p.shape == "ellipse" and p.eccentricity == 0.8]),
        ("square pyramid", [p for p in points if p.shape == "pyramid"]),
    ):
        numbers = [store.load(p) for p in wanted]
        if numbers:
            others[name] = (
                np.array([float(n["radius"]) for n in numbers]),
                np.array([float(n["base_tension"]) for n in numbers]),
            )
    rows: list[list[object]] = [
        ["round paraboloid", a, s.tension, s.where, s.pull] for a, s in zip(radii, solved.values(), strict=True)
    ]
    rows += [
        [name.replace("$", ""), x, y, "", ""] for name, (xs, ys) in others.items() for x, y in zip(xs, ys, strict=True)
    ]
    header = "indenter a0_over_h tension_over_peak_pressure distance_over_h force_in_tension_over_force"
    report.picture("base_tension", draw.tension(radius, largest, pull, others), header, rows)
    plain = {name.replace("$", ""): values for name, values in others.items()}
    report.statements.append(statements.base_tension(solved, plain))
    report.sections.append(
        (
            "Stress at the base of an unbonded layer",
            "The paper neglects that a layer resting on its base would lift off around the contact. Largest tension that "
            "holds it down in the solutions above, over the peak pressure of the contact (under a pyramid, whose pressure has no "
            "bound, that of the innermost cell).",
            [("base_tension", "tension")],
        )
    )


def _tables(report: Report) -> None:
    rows: list[list[object]] = [list(row) for row in report.deviations]
    header = ["figures", "case", "quantity", "method", "largest_deviation_from_boundary_elements"]
    _write_csv(report.folder / "deviations.csv", header, rows)
    found: list[list[object]] = [
        [s.name, s.verdict, name, value] for s in report.statements for name, value in s.numbers.items()
    ]
    _write_csv(report.folder / "statements.csv", ["statement", "verdict", "number", "value"], found)


def _write_csv(path: Path, header: list[str], rows: list[list[object]]) -> None:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(header)
    writer.writerows([[f"{v:.8g}" if isinstance(v, float) else v for v in row] for row in rows])
    write_whole(path, text.getvalue().encode())


_STYLE = """body{font:16px/1.5 system-ui,sans-serif;max-width:76rem;margin:2rem auto;padding:0 1rem;color:#222}
figure{display:inline-block;margin:.4rem;vertical-align:top;max-width:24rem}figure.wide{max-width:46rem}img{width:100%}
figcaption{font-size:.85rem;text-align:center}table{border-collapse:collapse;margin:1rem 0}
td,th{border-bottom:1px solid #ccc;padding:.3rem .7rem;text-align:left;vertical-align:top}
.confirmed{color:#1a6b2f}.contradicted{color:#a4161a}.part{color:#8a5a00}"""


def page(report: Report) -> str:
    """The page, free of scripts and of anything from elsewhere."""
    lines = [
        "<!doctype html><html lang='en'><head><meta charset='utf-8'><title>Figures of Forsbach and Willert 2023</title>",
        f"<style>{_STYLE}</style></head><body><h1>Figures of Forsbach and Willert (2023), recomputed</h1>",
        "<p>F. Forsbach, E. Willert, <i>A General Approximate Solution for the Slightly Non-Axisymmetric Normal Contact Problem "
        f"of Layered and Graded Elastic Materials</i>, Lubricants 2023, 11, 450. Computed by flatpunch {__version__}.</p>",
        "<h2>What the paper says</h2><table><tr><th>Statement</th><th>Verdict</th><th>Found</th></tr>",
    ]
    for s in report.statements:
        colour = "part" if "part" in s.verdict or "only" in s.verdict else s.verdict.split()[0]
        lines.append(
            f"<tr><td>{html.escape(s.text)}</td><td class='{colour}'>{html.escape(s.verdict)}</td>"
            f"<td>{html.escape(s.finding)}</td></tr>"
        )
    lines.append("</table>")
    for title, text, pictures in report.sections:
        lines.append(f"<h2>{html.escape(title)}</h2><p>{html.escape(text)}</p><div>")
        for name, caption in pictures:
            wide = " class='wide'" if name in ("figure_10", *(f"figure_{n:02}" for n in (6, 7, 8, 9, 11, 12))) else ""
            links = " ".join(f"<a href='{name}.{ending}'>{ending}</a>" for ending in ("pdf", "csv"))
            lines.append(
                f"<figure{wide}><a href='{name}.png'><img src='{name}.png' alt='{html.escape(caption)}'></a>"
                f"<figcaption>{html.escape(caption)} ({links})</figcaption></figure>"
            )
        lines.append("</div>")
    lines.append(
        "<h2>Largest deviations from the boundary elements</h2><table><tr><th>Figure</th><th>Case</th><th>Quantity</th>"
        + "".join(f"<th>{html.escape(NAMES[m])}</th>" for m in FAST)
        + "</tr>"
    )
    table: dict[tuple[str, str, str], dict[str, float]] = {}
    for figure, case, quantity, method, value in report.deviations:
        table.setdefault((figure, case, quantity), {})[method] = value
    for key, values in table.items():
        cells = "".join(
            f"<td>{values[m]:.4f}</td>" if "absolute" in key[2] else f"<td>{100 * values[m]:.2f} %</td>" for m in FAST
        )
        lines.append("<tr>" + "".join(f"<td>{html.escape(part)}</td>" for part in key) + cells + "</tr>")
    lines.append("</table></body></html>")
    return "\n".join(lines)
