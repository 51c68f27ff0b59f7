"""The form of the page: case files become forms and forms case files, and problems find their field."""

import contextlib
import time
import tomllib
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flatpunch.app.form import FormError, address_of, case_data, case_text, fields_of, form_of, toml_text
from flatpunch.app.jobs.common import case_of, explained, field_of
from flatpunch.app.jobs.press import press
from flatpunch.app.tables import page_tables
from flatpunch.files import read_case, shipped_cases

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
GEL = {
    "layers.0.young": "5 kPa",
    "layers.0.poisson": "0.5",
    "layers.0.thickness": "1.2 um",
    "base.kind": "rigid",
    "indenter.kind": "sphere",
    "indenter.radius": "5 um",
    "control.quantity": "depth",
    "control.start": "10 nm",
    "control.stop": "300 nm",
    "control.points": "4",
}

texts = st.text(max_size=20)
values = st.recursive(
    texts | st.integers(-(2**62), 2**62) | st.floats(allow_nan=False) | st.booleans(),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(texts, inner, max_size=3),
    max_leaves=8,
)


@pytest.mark.long
@settings(max_examples=150, derandomize=True, deadline=None)
@given(st.dictionaries(texts, values, max_size=4))
def test_toml_is_read_back_as_it_was_written(data):
    assert tomllib.loads(toml_text(data)) == data


@pytest.mark.parametrize("path", shipped_cases(), ids=lambda path: path.stem)
def test_shipped_cases_become_forms_and_cases_again(path):
    form = form_of(tomllib.loads(path.read_text(encoding="utf-8")))
    assert fields_of(address_of(form)) == form
    case, original = case_of(form), read_case(path)
    # arrays compare entry by entry, formulas by their text
    assert repr(case.medium) == repr(original.medium)
    assert case.indenter == original.indenter
    assert repr(case.arguments) == repr(original.arguments)


@pytest.mark.parametrize("name", ["thin_gel", "sticky_gel", "relaxing_cell"])
def test_what_a_fit_looks_for_is_marked_and_kept(name):
    data = tomllib.loads((EXAMPLES / "fit" / f"{name}.toml").read_text(encoding="utf-8"))
    data.pop("correct", None)  # another tab's
    form = form_of(data)
    assert form["layers.0.young.fit"] == "on"
    assert case_data(form, "fit") == data
    # elsewhere the value to start from is the value
    assert case_data(form, "press")["layers"][0]["young"] == data["layers"][0]["young"]["fit"]


def test_every_tip_on_the_page_can_be_solved_with_the_proposed_values():
    for kind, table in page_tables()["indenter"].items():
        proposed = {f"indenter.{field['name']}": field["value"] for field in table["fields"] if field["value"]}
        form = {name: text for name, text in GEL.items() if not name.startswith("indenter.")} | proposed
        case = case_of({**form, "indenter.kind": kind})
        assert case.indenter is not None
    assert "height-map" not in page_tables()["indenter"], "needs a file"


def test_layers_are_in_the_order_of_their_numbers_and_gaps_do_not_count():
    form = {**GEL, "layers.7.young": "1 MPa", "layers.7.poisson": "0.3", "layers.7.thickness": "1 mm"}
    assert [layer["young"] for layer in case_data(form)["layers"]] == ["5 kPa", "1 MPa"]


@pytest.mark.parametrize(
    ("change", "field", "words"),
    [
        ({"layers.0.young": "5 kN"}, "layers.0.young", "dimension of a force"),
        ({"layers.0.young": "-5 kPa"}, "layers.0.young", "must be finite and > 0"),
        ({"layers.0.poisson": "0.7"}, "layers.0.poisson", "0.5"),
        ({"layers.0.thickness": ""}, "layers.0.thickness", "is missing"),
        ({"layers.0.young": '{ law = "linear", top = "5 kg", bottom = "9 kPa" }'}, "layers.0.young", "dimension"),
        ({"base.kind": "soft"}, "base.kind", "is unknown"),
        ({"indenter.radius": "5"}, "indenter.radius", "has no unit"),
        ({"indenter.kind": "pyramid", "indenter.sides": "x", "indenter.radius": ""}, "indenter.sides", "must be"),
        ({"control.start": "1 N"}, "control.start", "dimension of a force"),
        ({"control.points": "1"}, "control.points", "must be 2 or more"),
        ({"control.values": "-1 nm"}, "control.values", "work_of_adhesion"),
        ({"control.quantity": "force", "control.start": "1 nm"}, "control.start", "dimension of a length"),
        ({"method": "best"}, "method", "is unknown"),
        ({"angles": "3"}, "angles", "at least 8"),
        ({"work_of_adhesion": "1 Pa"}, "work_of_adhesion", "dimension"),
        ({"material.finite_strain": "gent"}, "material.finite_strain", "neo-hookean"),
        ({"material.finite_strain": "neo-hookean", "indenter.kind": "paraboloid"}, "material.finite_strain", "Sphere"),
        ({"more": "[history"}, "more", "not valid TOML"),
        ({"more": "[base]\nkind = 'rigid'"}, "more", "fields of its own"),
        ({"more": "a = " + "[" * 2000}, "more", "nested"),
        ({"more": "wether = 1"}, "", "no known field"),
        ({"indenter.kind": "height-map", "indenter.file": "/etc/passwd"}, "indenter.file", "reads no files"),
    ],
)
def test_problems_find_their_field(change, field, words):
    form = fields_of(address_of({**GEL, **change}))
    found = press(form, True)["problems"]
    assert any(problem["field"] == field and words in problem["text"] for problem in found), found


def test_law_of_large_strains_is_a_field_and_changes_the_forces():
    form = {**GEL, "material.finite_strain": "neo-hookean"}
    assert form_of(case_data(form))["material.finite_strain"] == "neo-hookean"
    assert case_data(form, "fit")["material"] == case_data(form, "compare")["material"]
    assert "material" not in case_data(form, "coating")
    large, small = press(form, True), press(GEL, True)
    factors = [big / linear for big, linear in zip(large["curve"]["force"], small["curve"]["force"], strict=True)]
    assert factors == pytest.approx(large["curve"]["strain_factor"], rel=1e-6)
    assert not large["exact"]
    assert small["exact"]


def test_places_in_case_files_are_fields():
    assert field_of("layers[0].young.top", GEL) == "layers.0.young"
    assert field_of("layers[2].thickness", GEL) == "layers.2.thickness"
    assert field_of("control.depth.stop", GEL) == "control.stop"
    assert field_of("depth[3]", GEL) == "control.start"
    assert field_of("nothing", GEL) == ""


def test_forms_that_are_too_long_are_refused():
    with pytest.raises(FormError, match="at most"):
        fields_of("a=" + "x" * 1_000_000)
    many = {f"layers.{i}.young": "1 kPa" for i in range(2001)}
    with pytest.raises(FormError, match="layers has 2001 entries"):
        case_text(many)


@pytest.mark.parametrize(
    "text",
    ["[", "(", "*", "((.*)*)*!", "(a+)+$", "0" * 50_000 + ":1:2", "a." * 50_000, " " * 50_000 + ":1:2", "9" * 50_000],
)
@pytest.mark.parametrize("field", ["control.quantity", "control.values", "layers.0.young", "indenter.kind", "title"])
def test_no_text_of_a_visitor_is_a_pattern(field, text):
    """Every text is answered in a moment, and none is a mistake of the package."""
    start = time.monotonic()
    try:
        case_of({**GEL, field: text})
    except Exception as error:
        told = explained(error, {**GEL, field: text})
        assert "mistake" not in str(told)
    with contextlib.suppress(ValueError):  # a form that is refused
        case_text({**GEL, field: text}, "press")
    # milliseconds; what grew with the square of the length took a minute
    assert time.monotonic() - start < 5
