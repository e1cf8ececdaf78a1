"""Work in the process of the one who asks leaves no trace in its threads."""

import pytest

import agrik_fast as ik
from agrik_fast.jobs import change_threads, using_threads


@pytest.mark.parametrize("own", [None, 5])
def test_the_number_is_put_back(own: int | None) -> None:
    ik.set_num_threads(own)
    before = ik.get_num_threads()
    try:
        change_threads(9)
        assert ik.get_num_threads() == before, "nothing is at work"
        with using_threads(1):
            assert ik.get_num_threads() == 1
            # Two tasks of a worker, of which the first ends first.
            second = using_threads(2)
            second.__enter__()
            change_threads(3)
            assert ik.get_num_threads() == 3
        assert ik.get_num_threads() == 3, "the other is at work"
        second.__exit__(None, None, None)
        assert ik.get_num_threads() == before
        with pytest.raises(ValueError, match="wrong"), using_threads(1):
            raise ValueError("wrong")
        assert ik.get_num_threads() == before
    finally:
        ik.set_num_threads(None)
