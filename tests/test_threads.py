"""Linear algebra keeps to one thread beside small matrices, and gets back what it had."""

import threading

import numpy as np
import pytest
from threadpoolctl import ThreadpoolController

import flatpunch as fp
from flatpunch._support.threads import given_blas_threads, in_threads, one_blas_thread, threads
from flatpunch.bem.solver.levels import fitting_threads
from flatpunch.compliances import compliance
from support.punch_matrices import kernel_matrix


def blas_threads():
    return {library["num_threads"] for library in ThreadpoolController().select(user_api="blas").info()}


@pytest.fixture
def two_threads():
    with ThreadpoolController().limit(limits=2, user_api="blas"):
        if blas_threads() != {2}:
            pytest.fail(f"BLAS does not take two threads here: {blas_threads()}")
        yield


def test_one_thread_inside_and_as_before_outside(two_threads):
    with one_blas_thread():
        assert blas_threads() == {1}
        assert threads() == 2
        with one_blas_thread():
            assert blas_threads() == {1}
        assert blas_threads() == {1}
    assert blas_threads() == {2}


def test_given_back_after_an_error(two_threads):
    with pytest.raises(ValueError, match="depth"):
        fp.indent(fp.HalfSpace(1.0, 0.3), fp.Sphere(1.0), depth=-1.0)
    assert blas_threads() == {2}


def test_blocks_of_several_threads_may_overlap(two_threads):
    """Whichever ends first, linear algebra has its threads again when both have."""
    inside, leave = threading.Event(), threading.Event()

    def other():
        with one_blas_thread():
            inside.set()
            leave.wait(10)

    with one_blas_thread():
        worker = threading.Thread(target=other)
        worker.start()
        assert inside.wait(10)
        assert blas_threads() == {1}
    leave.set()
    worker.join()
    assert blas_threads() == {2}


def test_calls_are_made_where_another_thread_rules_linear_algebra(two_threads):
    seen = []
    worker = threading.Thread(target=in_threads, args=(seen.append, 20, 1e12))
    worker.start()
    worker.join()
    assert sorted(seen) == list(range(20))
    assert blas_threads() == {2}


def test_large_grids_have_all_threads_within(two_threads):
    with one_blas_thread():
        with fitting_threads(1024**2):
            assert blas_threads() == {2}
        assert blas_threads() == {1}
        with fitting_threads(256**2), given_blas_threads():
            assert blas_threads() == {2}
        assert blas_threads() == {1}
    assert blas_threads() == {2}


@pytest.mark.parametrize("operations", [0.0, 1e12])
def test_every_call_is_made_once_with_one_thread(two_threads, operations):
    seen, callers = [], set()

    def call(i):
        callers.add(threading.get_ident())
        seen.append((i, *blas_threads()))

    in_threads(call, 50, operations)
    assert sorted(seen) == [(i, 1) for i in range(50)]
    assert (callers == {threading.get_ident()}) == (operations == 0.0)
    assert blas_threads() == {2}


def test_an_error_in_a_thread_is_raised(two_threads):
    def call(i):
        if i == 7:
            raise ArithmeticError("seven")

    with pytest.raises(ArithmeticError, match="seven"):
        in_threads(call, 20, operations=1e12)
    assert blas_threads() == {2}


def test_matrices_do_not_depend_on_threads(two_threads):
    """Radii of one batch are shared out: 12 matrices of 200 terms are far above what starts a second thread."""
    kernel = compliance(fp.Medium([fp.Layer(50.0, 0.3, 1.0)], base=fp.HalfSpace(1.0, 0.3)))
    beta = np.geomspace(50.0, 100.0, 12)
    several = kernel_matrix(kernel, beta, 200)
    with ThreadpoolController().limit(limits=1, user_api="blas"):
        assert np.array_equal(kernel_matrix(kernel, beta, 200), several)
