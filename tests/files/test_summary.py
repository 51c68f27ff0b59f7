"""Tables of curves on the command line and on the page."""

import numpy as np

import flatpunch as fp
from flatpunch.files.descriptions import curve_table, takes


def test_memory_is_said_in_megabytes():
    assert takes(2.4e6, 0.1).startswith("at most 2 MB of memory, ")


def test_areas_are_written_without_powers_of_ten():
    """Areas between two prefixes differ by a factor of up to a million."""
    curve = fp.indent(fp.HalfSpace(1e9, 0.3), fp.Sphere(1e-6), radius=np.geomspace(1e-9, 5e-7, 9))
    table = curve_table(curve)
    column = [name for name, _ in table.columns].index("area")
    assert table.columns[column] == ("area", "nm²")
    assert [row[column] for row in table.rows][::4] == ["3.142", "1571", "785400"]


def test_steps_without_a_value_have_a_dash():
    """A force below the pull-off force holds no contact."""
    body, tip = fp.HalfSpace(3e3, 0.5), fp.Sphere(5e-6)
    table = curve_table(fp.indent(body, tip, force=[1e-9, -1e-3], work_of_adhesion=2e-5))
    assert table.rows[1][0] == "-"
    assert not any("nan" in cell for row in table.rows for cell in row)
