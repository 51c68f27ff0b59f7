"""Case files with the tips that people own."""

import math

import numpy as np
import pytest

import flatpunch as fp
from flatpunch.files import CaseError, describe, read_case

CASE = """
base = {{ kind = "half-space", young = "1 GPa", poisson = 0.3 }}
control = {{ depth = "10 nm" }}

[indenter]
{}
"""


@pytest.fixture
def read(tmp_path):
    def read_text(table):
        path = tmp_path / "case.toml"
        path.write_text(CASE.format(table), encoding="utf-8")
        return read_case(path)

    return read_text


@pytest.mark.parametrize(
    ("table", "expected"),
    [
        ('kind = "vickers"', fp.Vickers()),
        ('kind = "berkovich"', fp.Berkovich()),
        ('kind = "berkovich"\nmodified = false', fp.Berkovich(modified=False)),
        ('kind = "cube-corner"\ntip_radius = "0.5 m"', fp.CubeCorner(tip_radius=0.5)),
        ('kind = "knoop"\nheight_removed = "0.25 m"', fp.Knoop(height_removed=0.25)),
        (
            'kind = "afm-pyramid"\nfront = "0.25 rad"\nback = "0.5 rad"\nside = "0.375 rad"',
            fp.AfmPyramid(0.25, 0.5, 0.375),
        ),
        ('kind = "cone"\ninclination = "0.5 rad"\ntip_radius = "2 m"', fp.SpheroCone(0.5, 2.0)),
        ('kind = "cone"\ninclination = "0.5 rad"\ntip_radius = "2 m"', fp.Rounded(fp.Cone(0.5), 2.0)),
        (
            'kind = "cone"\ninclination = "0.5 rad"\ntip_radius = "2 m"\ntrue_sphere = false',
            fp.Rounded(fp.Cone(0.5), 2.0, true_sphere=False),
        ),
        (
            'kind = "pyramid"\nsides = 4\ninclination = "0.5 rad"\ntilt_y = "0.125 rad"',
            fp.Tilted(fp.Pyramid(4, 0.5), 0, 0.125),
        ),
        ('kind = "roller"\nradius = "5 mm"\nlength = "2 mm"\ncrown = "1 m"', fp.Roller(5e-3, 2e-3, crown=1.0)),
        ('kind = "rounded-punch"\nhalf_width = "1 mm"\ncorner_radius = "0.1 mm"', fp.RoundedPunch(1e-3, 1e-4)),
        ('kind = "superellipse"\nhalf_x = "2 m"\nhalf_y = "1 m"\nheight_at_axes = "0.5 m"', fp.Superellipse(2, 1, 0.5)),
        ('kind = "ellipsoid"\nhalf_x = "2 m"\nhalf_y = "1 m"\nhalf_z = "4 m"', fp.Ellipsoid(2, 1, 4)),
        (
            'kind = "area-function"\ncoefficients = [24.5, 0.5]\nunit = "1 m"\nlimit = "0.5 m"',
            fp.AreaFunction((24.5, 0.5), 0.5),
        ),
    ],
)
def test_tips(read, table, expected):
    """Every length and angle here is exact in binary, so the tips are equal."""
    case = read(table)
    assert case.indenter == expected
    assert type(expected).__name__ in "\n".join(describe(case))


def test_a_flat_is_level_however_the_tip_is_tilted(read):
    tip = read('kind = "vickers"\nheight_removed = "0.25 m"\ntilt_x = "0.125 rad"').indenter
    assert tip == fp.Truncated(fp.Tilted(fp.Vickers(), 0.125), 0.25)
    assert tip.height(tip.rings[0] * 0.999, np.linspace(0, 6, 99)).max() == 0


def test_a_height_map_beside_the_case(read, tmp_path):
    x = np.linspace(-1e-6, 1e-6, 41)
    np.savez(tmp_path / "tip.npz", x=x, y=x, z=-(x**2 + x[:, None] ** 2) / 4e-6)
    table = 'kind = "height-map"\nfile = "tip.npz"\napex = "highest"\nreach = "{}"'
    assert read(table.format("500 nm")).indenter.reach == pytest.approx(5e-7, rel=1e-12)
    case = read(table.format("usable"))
    assert case.indenter.height(4e-7, 0.3) == pytest.approx((4e-7) ** 2 / 4e-6, rel=1e-9)
    assert "HeightMap" in "\n".join(describe(case))


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ('kind = "vickers"\ntip_radius = "1 nm"\nheight_removed = "1 nm"', "not both"),
        ('kind = "vickers"\ntip_radius = "0 nm"', "Rounded.radius|tip_radius|radius"),
        ('kind = "afm-pyramid"\nfront = "95 deg"\nback = "25 deg"\nside = "20 deg"', "front"),
        ('kind = "height-map"\nfile = "none.npz"', "is no file"),
        ('kind = "height-map"\nfile = "tip.npz"\nnear = ["1 nm"]', "two lengths"),
        ('kind = "area-function"\ncoefficients = [24.5, -300.0]\nunit = "1 nm"\nlimit = "1 um"', "Set start to"),
    ],
)
def test_bad_tips(read, table, message):
    with pytest.raises(CaseError, match=message):
        read(table)


def test_degrees(read):
    tip = read('kind = "afm-pyramid"\nfront = "15 deg"\nback = "25 deg"\nside = "17.5 deg"').indenter
    assert tip.inclinations == pytest.approx([math.radians(a) for a in (75, 72.5, 65, 72.5)], rel=1e-14)


def test_worn_tips_are_described_by_their_own_numbers(tmp_path):
    """Neither by what they keep for themselves nor in radians and metres."""
    path = tmp_path / "case.toml"
    path.write_text(
        "base = { kind = 'rigid' }\nlayers = [{ young = '5 kPa', poisson = 0.5, thickness = '1 um' }]\n"
        "indenter = { kind = 'vickers', tip_radius = '20 nm', tilt_x = '1 deg' }\ncontrol = { depth = '10 nm' }\n",
        encoding="utf-8",
    )
    (line,) = [each for each in describe(read_case(path)) if each.startswith("Indenter")]
    assert "tilt_x 1 deg" in line
    assert "radius 20 nm, true_sphere yes" in line
    assert "_" not in line.replace("true_sphere", "").replace("tilt_", "")
