"""The script that strict type checkers read also runs: what its types promise is what calls return."""

import runpy
from pathlib import Path

import numpy as np
import pytest

import flatpunch as fp


@pytest.mark.long
def test_the_typed_script_runs():
    made = runpy.run_path(str(Path(__file__).parent / "typing" / "user_script.py"))
    kinds = {"sharp": fp.Pyramid, "worn": fp.Rounded, "flat": fp.Truncated, "rounded": fp.Rounded, "knoop": fp.Rounded}
    assert all(type(made[name]) is kind for name, kind in kinds.items())
    assert type(made["front"]) is fp.FacetedPyramid
    # the curve that is fitted is linear between five points, which costs per mille
    np.testing.assert_allclose(made["modulus"], 5e3, rtol=0.1)
