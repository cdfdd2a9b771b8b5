"""A bar says how long is left when it can know, in words that are no number before."""

import io

import pytest

from combing.progress import Bar

CASES = [(0, 0, False), (0, 1, False), (0, 40, True), (50, 51, False), (50, 90, True)]


@pytest.mark.parametrize(("initial", "done", "told"), CASES)
def test_the_time_left_waits_for_some_work(initial, done, told):
    out = io.StringIO()
    with Bar(total=100.0, desc="scene", file=out, initial=initial, mininterval=0) as bar:
        bar.start_t -= 10.0  # s ago
        bar.update(done - initial)
        bar.refresh()
        line = out.getvalue().rpartition("\r")[2]
    assert f"{done}%" in line
    assert ("<" in line) == told
    if told:
        rate = (done - initial) / 10.0
        left = (100 - done) / rate
        minutes, seconds = line.rpartition("<")[2].split(":")
        assert int(minutes) * 60 + int(seconds) == pytest.approx(left, abs=1.5)
