"""Any value in the place of any argument is taken, or refused by one readable message of our own."""

import traceback
from pathlib import Path

import pytest

import flatpunch as fp
from support.hostile_calls import hostile_calls

PACKAGE = Path(fp.__file__).parent


@pytest.mark.filterwarnings("ignore::flatpunch.FlatpunchWarning")
@pytest.mark.parametrize(("seed", "count"), [(1, 400), pytest.param(2, 20_000, marks=pytest.mark.slow)])
def test_hostile_arguments(seed, count):
    wrong = [found for call in hostile_calls(seed, count) if (found := mistake(*call))]
    assert not wrong, "\n".join(wrong[:20])


def mistake(label, function, given):
    """What is wrong with the answer to a call; empty where nothing is."""
    try:
        function(**given)
    except (TypeError, ValueError) as error:
        frames = traceback.extract_tb(error.__traceback__)
        # a single frame: Python itself refuses the names of the arguments
        ours = len(frames) == 1 or Path(frames[-1].filename).is_relative_to(PACKAGE)
        return "" if ours and len(str(error)) < 900 else f"{label}: {str(error)[:300]}"
    except Exception as error:
        return f"{label}: {type(error).__name__} {str(error)[:300]}"
    return ""
