"""Any value in the place of any argument of the other public names is taken, or refused by a message that names it."""

import random
import re
import traceback
from pathlib import Path

import pytest
import xarray as xr

import flatpunch as fp
from flatpunch._support.checks import refused_overflow
from support.hostile_calls import VALUES
from support.side_calls import side_calls

PACKAGE = Path(fp.__file__).parent
INSTEAD = {
    "centers": "depth|half_widths",  # where the tip does not touch
    "factor": "Grid.spacing",
    "indenter": "method",  # on this body
    "medium": "Layer|HalfSpace",  # constants given as tuples
}
"""Arguments whose wrong values are refused by what follows from them."""


def wrong_calls():
    for label, (_, given) in side_calls().items():
        yield from ((label, name, value) for name in given for value in (*VALUES, xr.Dataset()))


@pytest.mark.long
@pytest.mark.filterwarnings("ignore")  # the libraries' own
@pytest.mark.parametrize("count", [600, pytest.param(None, marks=pytest.mark.slow)])
def test_wrong_arguments(count):
    calls = list(wrong_calls())
    wrong = [found for call in random.Random(1).sample(calls, count or len(calls)) if (found := mistake(*call))]
    assert not wrong, "\n".join([str(len(wrong)), *wrong[:20]])


def mistake(label, name, value):
    """What is wrong with the outcome of a call; empty where nothing is."""
    function, given = side_calls()[label]
    try:
        function(**{**given, name: value})
    except (TypeError, ValueError, OSError) as error:
        if callable(value) and name in ("planform", "pressure"):
            return ""  # a function of the caller's own
        last, text = traceback.extract_tb(error.__traceback__)[-1], str(error)
        named = re.search(rf"\b({name}|{INSTEAD.get(name, name)})\b", text, re.IGNORECASE)
        # messages about files begin with their path
        named = named or (label in ("atlas.table", "atlas.read_table") and not isinstance(error, TypeError))
        ours = named and Path(last.filename).is_relative_to(PACKAGE)
        return "" if ours and len(text) < 900 else f"{label}, {name}: {type(error).__name__} {text[:300]}"
    except Exception as error:
        return f"{label}, {name}: {type(error).__name__} {str(error)[:300]}"
    return ""


@pytest.mark.parametrize("reason", ["", "Unable to allocate 7.45 GiB for an array with shape (1000000000,)"])
def test_memory_that_runs_out_is_called_memory(reason):
    with pytest.raises(ValueError, match=rf"not enough memory.*{re.escape(reason)}.* Take fewer"), refused_overflow():
        raise MemoryError(*[reason] * bool(reason))
