"""One engine for many points: records of failures, what is kept and used again, names, the order of work."""

import dataclasses
import os
import signal
import subprocess
import sys
import time
from functools import partial

import numpy as np
import pytest

from flatpunch import FlatpunchWarning, Layer
from flatpunch._support import whole_file
from flatpunch._support.whole_file import write_whole
from flatpunch.parallel import Folder, Outcome, content_key, engine, one_thread, solve_points
from flatpunch.parallel.calls import Item, Waiting
from flatpunch.parallel.store import Memory
from support import sample_points as functions


def test_a_point_that_fails_is_a_record_and_stops_no_other():
    found = solve_points(functions.square_but_not_of_three, range(6), workers=1)
    assert [outcome.ok for outcome in found.values()] == [True, True, True, False, True, True]
    assert found.failed == {3: "ValueError: x = 3 is refused"}
    assert found[3].numbers is None
    assert found[5].numbers["square"] == 25


@pytest.mark.parametrize("kept", [False, True])
def test_numbers_come_back_the_same_from_memory_and_disk(kept, tmp_path):
    found = solve_points(functions.square, {"a": 2.5}, workers=1, store=tmp_path / "new" / "points" if kept else None)
    numbers = found["a"].numbers
    assert numbers["square"] == 6.25
    assert numbers["name"] == "x = 2.5"
    np.testing.assert_array_equal(numbers["row"], [0, 2.5, 5])
    assert set(numbers) == {"square", "row", "name"}
    assert found["a"].seconds >= 0


def test_a_second_run_solves_what_is_missing(tmp_path):
    function, seen = functions.square_but_not_of_three, []
    assert solve_points(function, range(4), workers=1, store=tmp_path).fresh == 4
    again = solve_points(function, range(6), workers=1, store=tmp_path, progress=lambda *at: seen.append(at))
    assert again.fresh == 2  # the failed one is not tried again unless asked for
    assert seen == [(4, 6), (5, 6), (6, 6)]
    assert again.failed == {3: "ValueError: x = 3 is refused"}
    assert solve_points(function, range(6), workers=1, store=tmp_path, retry_failed=True).fresh == 1
    assert not list(tmp_path.glob(".unfinished-*"))


class _InterruptedAsItWrites(Memory):
    def write(self, key, outcome):
        signal.raise_signal(signal.SIGINT)
        super().write(key, outcome)


def test_what_is_solved_when_ctrl_c_comes_is_kept():
    before, store = signal.getsignal(signal.SIGINT), _InterruptedAsItWrites()
    with pytest.raises(KeyboardInterrupt):
        solve_points(functions.square, range(4), workers=1, store=store)
    assert signal.getsignal(signal.SIGINT) is before
    assert len(store.states(engine.point_keys(functions.square, dict(enumerate(range(4)))).values())) == 1


@pytest.mark.parametrize("change", ["version", "function", "arguments", "package"])
def test_what_may_move_the_numbers_moves_the_names(change, tmp_path, monkeypatch):
    assert solve_points(functions.square, range(3), workers=1, store=tmp_path).fresh == 3
    function, more = functions.square, {}
    if change == "version":
        more["version"] = 2
    elif change == "package":
        monkeypatch.setattr(engine, "__version__", "0.0.1")
    else:
        function = functions.square_but_not_of_three if change == "function" else partial(functions.square)
    assert solve_points(function, range(3), workers=1, store=tmp_path, **more).fresh == 3


def test_what_succeeds_at_last_is_no_failure_any_more(tmp_path):
    store = Folder(tmp_path)
    store.write("a", Outcome(None, "ValueError: once"))
    assert store.states(["a", "b"]) == {"a": False}
    store.write("a", Outcome({"x": 1.0}))
    assert store.states(["a", "b"]) == {"a": True}
    assert [path.name for path in tmp_path.iterdir()] == ["a.npz"]


def test_equal_points_are_solved_once(tmp_path):
    found = solve_points(functions.square, {"first": 2, "second": 2}, workers=1, store=tmp_path)
    assert found.fresh == 1
    assert found["first"].numbers["square"] == found["second"].numbers["square"] == 4


def test_a_damaged_file_is_named(tmp_path):
    found = solve_points(functions.square, [1], workers=1, store=tmp_path)
    (path,) = tmp_path.glob("*.npz")
    whole = path.read_bytes()
    path.write_bytes(b"PK spoilt")
    with pytest.raises(ValueError, match=rf"{path.name}: damaged or changed after it was written"):
        found[0]
    # one bit of a number, which NumPy reads without a word
    for damaged in (whole[:-200] + bytes([whole[-200] ^ 1]) + whole[-199:], whole[:40], whole + b"x", b""):
        path.write_bytes(damaged)
        with pytest.warns(FlatpunchWarning, match=rf"{path.name}: damaged.*set aside, and its point is solved again"):
            again = solve_points(functions.square, [1], workers=1, store=tmp_path)
        assert again.fresh == 1
        assert again[0].numbers["square"] == 1
        assert path.with_name(f"{path.name}.damaged").read_bytes() == damaged


def test_a_planted_file_is_not_believed(tmp_path):
    solve_points(functions.square, [1], workers=1, store=tmp_path)
    (path,) = tmp_path.glob("*.npz")
    np.savez(path, square=7.0, _seconds=0.0)
    with pytest.warns(FlatpunchWarning, match="it has no seal"):
        assert solve_points(functions.square, [1], workers=1, store=tmp_path)[0].numbers["square"] == 1


def test_a_full_disk_costs_no_result(tmp_path, monkeypatch):
    def full(path, content):
        raise OSError(28, "No space left on device", str(path))

    monkeypatch.setattr("flatpunch.parallel.store.write_whole", full)
    with pytest.warns(FlatpunchWarning, match="points cannot be kept .No space left on device.") as told:
        found = solve_points(functions.square, [1, 2, 3], workers=1, store=tmp_path)
    assert len(told) == 1
    assert [found[i].numbers["square"] for i in range(3)] == [1, 4, 9]
    assert not found.failed


def test_folders_that_cannot_be_written_are_refused_before_the_work(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(OSError, match="no folder to keep points in"):
        solve_points(functions.square, [1], workers=1, store=tmp_path / "file")


def test_what_a_dead_process_left_goes_at_once(tmp_path):
    dead = subprocess.Popen([sys.executable, "-c", "pass"])
    dead.wait()
    ours, other = (f".unfinished-{whole_file._machine()}-{pid}-abcdefgh" for pid in (os.getpid(), dead.pid))
    for name in (ours, other):
        (tmp_path / name).touch()
    Folder(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == [ours]


def test_files_are_whole_and_what_was_left_unfinished_goes(tmp_path):
    with pytest.raises(TypeError):
        write_whole(tmp_path / "a", "not bytes")
    assert list(tmp_path.iterdir()) == []
    for name, age in ((".unfinished-0000000f-1-old_file.nc", 7200), (".unfinished-0000000f-1-new_file.nc", 0)):
        (tmp_path / name).touch()
        os.utime(tmp_path / name, (time.time() - age,) * 2)
    Folder(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == [".unfinished-0000000f-1-new_file.nc"]


def test_what_cannot_be_kept_is_a_failure():
    assert "the result 'thing' is a object" in solve_points(functions.unkeepable, [1], workers=1).failed[0]


@pytest.mark.parametrize(
    ("function", "points", "more", "error", "words"),
    [
        (lambda x: {}, [1], {}, TypeError, "must be a function of a module"),
        (functions.square, [object()], {}, TypeError, "content of a object cannot be read"),
        (functions.square, [1], {"workers": 0}, ValueError, "workers = 0 must be"),
        (functions.square, [1], {"workers": 1.5}, ValueError, "workers = 1.5 must be"),
    ],
)
def test_bad_input(function, points, more, error, words):
    with pytest.raises(error, match=words):
        solve_points(function, points, **more)


def test_a_folder_that_cannot_be_made_is_named(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(OSError, match="no folder to keep points in"):
        solve_points(functions.square, [1], store=tmp_path / "file" / "points")


def test_names_hold_all_of_the_content():
    @dataclasses.dataclass
    class Twin:
        young: float

    layer = Layer(young=1e3, poisson=0.3, thickness=1e-6)
    different = [
        1, 1.0, "1", True, None, b"1", (1,), [1], (1, (2, 3)), (1, 2, 3), ("ab", "c"), ("a", "bc"), 0.0, -0.0, 0.1 + 0.2, 0.3,
        {"a": 1}, {"a": 2}, {"b": 1}, {"a": {"b": 1}}, np.arange(4), np.arange(4.0), np.arange(4).reshape(2, 2),
        layer, dataclasses.replace(layer, poisson=0.31), Twin(1.0), Twin(1),
    ]  # fmt: skip
    assert len({content_key(thing) for thing in different}) == len(different)
    assert content_key({"a": 1, "b": [2]}) == content_key({"b": [2], "a": 1})
    # a stored folder is of use as long as names stay what they are
    assert content_key("flatpunch", 1.5, [None, {"a": (1, 2)}]) == "09ad3de78ecc5d539a9df006b8010c05"


def test_long_points_first_groups_together_and_lost_ones_alone():
    groups = [(group, i, cost) for group, cost in (("a", 1), ("b", 5), ("c", 2)) for i in range(3)]
    items = [Item(index, group, cost) for index, (group, _, cost) in enumerate(groups)]
    waiting = Waiting(items, workers=2, tries=2)
    names = lambda taken: [f"{item.group}{item.index % 3}" for item in taken]  # noqa: E731
    assert names(waiting.take(0)) == ["b0"]
    assert names(waiting.take(1)) == ["c0"]
    assert names(waiting.take(0)) == ["b1"]
    waiting.give_back([items[4]])
    assert [names(waiting.take(0)) for _ in range(3)] == [["b1"], ["b2"], ["a0"]]
    assert [names(waiting.take(1)) for _ in range(3)] == [["c1"], ["c2"], ["a1"]]  # helps with the last group
    assert waiting.lose(items[:2], alone=False) == []  # two at once: nobody knows which of them it was
    assert names(waiting.take(0, suspects=False)) == ["a2"]
    assert waiting.take(0, suspects=False) == []
    assert [names(waiting.take(0)) for _ in range(2)] == [["a0"], ["a1"]]
    assert waiting.lose(items[:1], alone=True) == []
    assert names(waiting.take(1)) == ["a0"]
    assert waiting.lose(items[:1], alone=True) == items[:1]
    assert waiting.take(0) == []


def test_short_points_go_together_and_long_ones_one_by_one():
    waiting = Waiting([Item(i) for i in range(1000)], workers=2, tries=1)
    assert len(waiting.take(0)) == 1  # nothing is known yet
    waiting.learn(50, 50 * 1e-5)
    assert len(waiting.take(0)) == 499  # the share of one worker of two
    waiting.learn(50, 50 * 0.03)
    assert len(waiting.take(0)) == 3
    waiting.learn(1, 10.0)
    assert len(waiting.take(0)) == 1


def test_one_thread_and_back(monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "2")
    monkeypatch.delenv("MKL_NUM_THREADS", raising=False)
    with one_thread():
        assert os.environ["OMP_NUM_THREADS"] == os.environ["MKL_NUM_THREADS"] == "1"
        assert functions.threads(None)["threads"] == 1
    assert os.environ["OMP_NUM_THREADS"] == "2"
    assert "MKL_NUM_THREADS" not in os.environ
