"""docs/guarantees.md: a late response is not published as a good value of another register, nor as newer than
it is. The long form of this test is tests/late_field.py."""
import concurrent.futures
import multiprocessing

import pytest

from late_field import run_field

# One device whose requests all look alike; three with requests of several shapes.
ALIKE = {"units": 1, "shapes": "abc"}
MIXED = {"units": 3, "shapes": "abcde"}
FIELDS = {
    f"{transport}-{f['units']}_units_1_in_{f['share']}_by_{f['factor']}_{f['order']}_order": f | {
        "transport": transport
    }
    for transport in ("pty", "tcp") for f in (
        ALIKE | dict(factor=4, share=40, order="in", late=1),
        ALIKE | dict(factor=4, share=10, order="out", late=1),
        ALIKE | dict(factor=1.2, share=4, order="in", late=1),
        MIXED | dict(factor=4, share=4, order="in", late=3),
        MIXED | dict(factor=1.2, share=10, order="out", late=3),
        MIXED | dict(factor=40, share=40, order="in", late=1),
    )
}


@pytest.fixture(scope="module")
def verdicts():
    """All fields at once, each in a process of its own: they mostly wait. A busy machine must not take as
    long as the time-out to run a program."""
    with concurrent.futures.ProcessPoolExecutor(len(FIELDS), multiprocessing.get_context("fork")) as pool:
        running = {
            name: pool.submit(run_field, seconds=12, timeout=0.3, **field)
            for name, field in FIELDS.items()
        }
        return {name: future.result() for name, future in running.items()}


@pytest.mark.parametrize("field", FIELDS)
def test_late_answers_are_never_good_values_of_another_register(verdicts, field):
    verdict, _, late, _, _ = verdicts[field]
    assert verdict.good > 0 and late > 0, f"{verdict}, {late} late: nothing was tried"
    assert verdict.wrong == 0, f"{verdict}\n" + "\n".join(verdict.examples)
    assert verdict.old == 0, f"{verdict}\n" + "\n".join(verdict.examples)
