"""What a process keeps is bounded by bytes."""

import pickle

import numpy as np
import pytest

import flatpunch as fp
from flatpunch._support import byte_cache
from flatpunch._support.byte_cache import ByteCache, byte_cached, size_of
from flatpunch.punch.family import punch_family


def kept_by(limit, size):
    """A cache, a function of it that returns `size` bytes, and its calls."""
    cache, calls = ByteCache(limit), []

    def make(number):
        calls.append(number)
        return np.zeros(size, dtype=np.uint8)

    return cache, byte_cached(make, cache), calls


def test_the_entries_used_longest_ago_are_dropped():
    _, make, calls = kept_by(10_000, 1000)
    for number in range(9):
        make(number)
    make(0)
    make(9)  # more than 10 kB with the keys: down to 7.5 kB
    assert calls == list(range(10))
    make(9), make(0), make(8)
    assert calls == list(range(10))
    make(1)
    assert calls[-1] == 1


def test_results_for_what_cannot_be_hashed_are_made_anew():
    _, make, calls = kept_by(10_000, 1000)
    for _ in range(2):
        make([1])
    assert calls == [[1], [1]]


@pytest.mark.long
def test_a_small_entry_outlives_large_ones_that_are_used_later():
    """A table of forces is small, and the series that it is made of are large and used after it."""
    cache, make, _ = kept_by(10_000, 1000)
    table = byte_cached(lambda name: [name], cache)
    first = table("forces")
    for number in range(100):
        make(number)
    assert table("forces") is first
    # all together stay below the limit
    for number in range(300):
        table(number)
    assert cache.bytes <= 10_000
    assert table("forces") is not first


@pytest.mark.long
def test_what_grows_is_measured_again():
    cache = ByteCache(10_000)
    lists = byte_cached(lambda number: [], cache)
    for number in range(20):
        lists(number).append(np.zeros(1000))
        cache.grown(8000)
    assert cache.bytes < 10_000 + 8000
    assert len(lists._kept) < 4


def test_an_entry_above_the_limit_is_kept_until_the_next_one():
    cache, make, calls = kept_by(1000, 5000)
    make(1), make(1)
    assert calls == [1]
    assert cache.bytes > 5000
    make(2), make(1)
    assert calls == [1, 2, 1]


@pytest.mark.parametrize(
    ("value", "collected"),
    [(np.zeros(100), 0), ((np.zeros(100), 1.0), 0), ([np.zeros(100)], 1), ((np.zeros(100), lambda: 0), 1)],
    ids=["array", "tuple of arrays", "list", "function"],
)
def test_a_collection_is_made_only_for_what_may_refer_to_itself(value, collected, monkeypatch):
    """It takes 0.1 s, and a series of many harmonics drops some hundred times."""
    calls = []
    monkeypatch.setattr(byte_cache.gc, "collect", lambda: calls.append(1))
    cache = ByteCache(100)
    kept = byte_cached(lambda number: value, cache)
    kept(1), kept(2)
    assert len(kept._kept) == 1
    assert bool(calls) == bool(collected)


def test_views_count_as_what_they_hold_and_everything_counts_once():
    whole = np.zeros(1000)
    assert 8000 <= size_of([whole[:3], whole[5:], {"again": whole}], set()) < 8000 + 1000


def test_closures_count():
    waves = np.zeros(1000)
    assert size_of([lambda: waves], set()) >= 8000


@pytest.mark.parametrize("text", ["many", "-1", "nan", "1e999"])
def test_a_limit_that_is_no_size_is_refused(text, monkeypatch):
    monkeypatch.setenv(byte_cache.LIMIT_VARIABLE, text)
    with pytest.raises(ValueError, match=r"FLATPUNCH_CACHE_MB = .*megabytes >= 0"):
        _ = ByteCache().limit


def test_the_environment_sets_the_limit(monkeypatch):
    monkeypatch.setenv(byte_cache.LIMIT_VARIABLE, "12.5")
    assert ByteCache().limit == 12_500_000


def test_functions_reach_other_processes_by_name():
    assert pickle.loads(pickle.dumps(punch_family)) is punch_family


@pytest.mark.long
def test_many_media_stay_within_the_limit(monkeypatch):
    """16 media would take some 80 MB; what is kept of them is measured here from outside."""
    limit = 20_000_000
    monkeypatch.setattr(byte_cache.PROCESS, "_limit", limit)
    # what other tests have left
    for entry in [*byte_cache.PROCESS._entries.values()]:
        byte_cache.PROCESS._drop(entry)
    rng = np.random.default_rng(5)
    held = []
    for i in range(16):
        moduli = np.sort(10 ** rng.uniform(8, 9.9, 1 + i % 2))
        medium = fp.Medium([fp.Layer(E, rng.uniform(0, 0.5), 1e-6) for E in moduli], base=fp.HalfSpace(10e9, 0.3))
        fp.flat_punch(medium, 1e-6)
        fp.indent(medium, fp.Pyramid(4, 0.3), radius=[1e-6, 2e-6], method="second-order")
        entries = byte_cache.PROCESS._entries.values()
        held.append(size_of([part for entry in entries for part in (entry.key, entry.value)], set()))
    # the entries of one call grow by a few MB before the next one is made
    assert 0.5 * limit < max(held) < 1.5 * limit
