"""Numbers that pages state and no other test holds."""

import csv
import re
from pathlib import Path

import numpy as np
import pytest

import flatpunch as fp
from flatpunch.contact.default import FORCE_LIMIT, NOTABLE_OUTLINE

ROOT = Path(__file__).resolve().parents[2]
STIFF = {f"film-{ratio}" for ratio in (2, 3, 4, 7, 10, 20, 30, 50, 100)} | {
    "film-2-sliding",
    "stiff-soft-stiff",
    "soft-stiff-soft",
}


def test_errors_of_the_methods():
    """The table on the page about methods is the largest error in the catalogue."""
    lines = (ROOT / "tests" / "catalogue" / "catalogue.csv").read_text(encoding="utf-8").splitlines()
    catalogue = list(csv.DictReader(line for line in lines if not line.startswith("#")))
    page = (ROOT / "docs" / "choose_method.md").read_text(encoding="utf-8")
    shown = re.findall(r"^\| ((?:\w+)-[\d.]+|rhombus) \| (.+) \|$", page, re.MULTILINE)
    assert len(shown) == 9
    for tip, cells in shown:
        printed = iter(cells.split(" | "))
        for stiff in (False, True):
            here = [row for row in catalogue if row["tip"] == tip and (row["medium"] in STIFF) == stiff]
            for method in ("first-order", "second-order", "fourth-order", "refined"):
                errors = [float(row[f"{method} force"]) for row in here if row[f"{method} force"] not in ("", "nan")]
                cell = next(printed)
                if cell == "-":
                    assert not errors
                else:
                    # two digits are printed
                    assert 100 * max(errors) == pytest.approx(float(cell), rel=0.05), (tip, method, stiff)


def test_promises_of_the_default():
    """Errors in the catalogue of the method that is chosen by the estimates in it."""
    lines = (ROOT / "tests" / "catalogue" / "catalogue.csv").read_text(encoding="utf-8").splitlines()
    force, outline, series = [], [], []
    for row in csv.DictReader(line for line in lines if not line.startswith("#")):
        estimates = [row[f"fourth-order {name}"] for name in ("estimate", "outline_estimate")]
        # general shapes have no fourth order
        fast = all(
            text and float(text) <= limit for text, limit in zip(estimates, (FORCE_LIMIT, NOTABLE_OUTLINE), strict=True)
        )
        method = "fourth-order" if fast else "refined"
        force.append(float(row[f"{method} force"]))
        series.append(fast)
        outline.append(float(row[f"{method} outline"] or "nan"))
    force, outline = np.array(force), np.array(outline)
    assert force.size > 600
    page = (ROOT / "docs" / "choose_method.md").read_text(encoding="utf-8")
    for method, chosen in (("fourth-order", series), ("refined", ~np.array(series))):
        promised = re.findall(rf"^\| .* \| `{method}` \| .* \| ([\d.]+) % \|$", page, re.MULTILINE)
        assert 100 * force[chosen].max() < float(promised[-1]), method
    assert (np.nan_to_num(outline, posinf=1.0) < 0.03).mean() > 0.97
    assert np.nanmedian(outline) < 0.003


@pytest.mark.long
@pytest.mark.parametrize(
    ("indenter", "sound", "lost"),
    [
        (fp.Pyramid(4, 0.2), 4.0, 5.0),
        (fp.EllipticParaboloid(0.05, 0.06), 7.0, 8.0),
        (fp.EllipticParaboloid(0.5, 1.0), 6.0, 6.5),
        (fp.EllipticParaboloid(0.36, 1.0), 5.0, 5.5),
    ],
    ids=["pyramid", "ellipse 0.83", "ellipse 0.5", "ellipse 0.36"],
)
def test_where_the_first_order_outline_ends(indenter, sound, lost):
    """Modulus ratios between which the outline is lost at some thickness, nu = 0.3 (theory page 7)."""
    radii = np.geomspace(0.05, 20, 100)

    def area(ratio):
        film = fp.Medium([fp.Layer(ratio, 0.3, 1.0)], base=fp.HalfSpace(1.0, 0.3))
        return fp.indent(film, indenter, radius=radii, method="first-order", angles=16).area.values

    assert np.isfinite(area(sound)).all()
    assert not np.isfinite(area(lost)).all()
