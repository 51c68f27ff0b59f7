"""`plugin write`: a file for every host, and refusals by name."""

import ast

import pytest

from flatpunch.files import shipped_cases
from flatpunch.fits.case import read_fit_case
from flatpunch.plugins.hosts import HOSTS, write_plugin


@pytest.fixture(scope="module")
def case():
    return read_fit_case(next(path for path in shipped_cases() if "afm_pyramid" in path.name))


@pytest.mark.parametrize("host", HOSTS)
def test_every_host_has_a_file(tmp_path, case, host):
    path = write_plugin(host, tmp_path / f"flatpunch_{host}.py", case if HOSTS[host].case else None)
    ast.parse(path.read_text(encoding="utf-8"))


def test_what_does_not_belong_together_is_refused(tmp_path, case):
    target = tmp_path / "file.py"
    with pytest.raises(ValueError, match="HOST = 'abaqus' is unknown; it is one of 'contactmechanics'"):
        write_plugin("abaqus", target)
    with pytest.raises(ValueError, match="carries one case; give a case file"):
        write_plugin("nanite", target)
    with pytest.raises(ValueError, match="takes any medium; leave the case out"):
        write_plugin("tamaas", target, case)
    with pytest.raises(ValueError, match="only the file for slippy"):
        write_plugin("softmech", target, case, depths=[1e-6])
    with pytest.raises(ValueError, match="this file is a Python module"):
        write_plugin("tamaas", tmp_path / "no module.py")
    assert not list(tmp_path.iterdir())
