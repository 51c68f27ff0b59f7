"""Tables of curves on the command line and on the page."""

import numpy as np

import flatpunch as fp
from flatpunch.files.summary import curve_table


def test_areas_are_written_without_powers_of_ten():
    """Areas between two prefixes differ by a factor of up to a million."""
    curve = fp.indent(fp.HalfSpace(1e9, 0.3), fp.Sphere(1e-6), radius=np.geomspace(1e-9, 5e-7, 9))
    table = curve_table(curve)
    column = [name for name, _ in table.columns].index("area")
    assert table.columns[column] == ("area", "nm²")
    assert [row[column] for row in table.rows][::4] == ["3.142", "1571", "785400"]
