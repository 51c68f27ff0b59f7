"""The equations that the code cites are in the theory pages, under the number that it cites."""

import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
NUMBER = re.compile(r"\((T\d+\.\d+)\)")


def numbers(paths):
    """Equations by number, with where they stand."""
    return [(number, path.name) for path in paths for number in NUMBER.findall(path.read_text(encoding="utf-8"))]


def written():
    """Numbers of the equations on the theory pages, in the order of the pages' text."""
    found = []
    for page in sorted((ROOT / "docs" / "theory").glob("*.md")):
        found += re.findall(r"^\$\$ \((T\d+\.\d+)\)$", page.read_text(encoding="utf-8"), re.MULTILINE)
    return found


def test_every_cited_equation_is_written():
    known = set(written())
    cited = numbers([*(ROOT / "src").rglob("*.py"), *(ROOT / "tests").rglob("*.py"), *(ROOT / "docs").rglob("*.md")])
    assert len(cited) > 50
    assert [(number, where) for number, where in cited if number not in known] == []


def test_equations_are_numbered_once_and_in_order():
    found = written()
    assert len(set(found)) == len(found)
    for page in {number.split(".")[0] for number in found}:
        places = [int(number.split(".")[1]) for number in found if number.split(".")[0] == page]
        assert places == list(range(1, len(places) + 1)), page


def test_nothing_cites_a_text_that_is_not_here():
    """Equations are cited by page and number, "(T3.2)", not by the sections of a design."""
    paths = [*(ROOT / "src").rglob("*.py"), *(ROOT / "tests").rglob("*.py"), *(ROOT / "docs").rglob("*.md")]
    wrong = re.compile(r"\bdesign \d|\bDESIGN\b")
    found = [path.name for path in paths if path != Path(__file__) and wrong.search(path.read_text(encoding="utf-8"))]
    assert found == []
