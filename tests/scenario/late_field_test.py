"""docs/guarantees.md: a late response is not published as a good value of another register, nor as newer than it is. The long form
of this test is tests/late_field.py."""
import pytest

from late_field import run_field

# One device whose requests all look alike; three with requests of several shapes.
ALIKE = {"units": 1, "shapes": "abc"}
MIXED = {"units": 3, "shapes": "abcde"}


@pytest.mark.parametrize("transport", ["pty", "tcp"])
@pytest.mark.parametrize("field", [
    ALIKE | {
        "factor": 4,
        "share": 40,
        "order": "in",
        "late": 1
    },
    ALIKE | {
        "factor": 4,
        "share": 10,
        "order": "out",
        "late": 1
    },
    ALIKE | {
        "factor": 1.2,
        "share": 4,
        "order": "in",
        "late": 1
    },
    MIXED | {
        "factor": 4,
        "share": 4,
        "order": "in",
        "late": 3
    },
    MIXED | {
        "factor": 1.2,
        "share": 10,
        "order": "out",
        "late": 3
    },
    MIXED | {
        "factor": 40,
        "share": 40,
        "order": "in",
        "late": 1
    },
], ids=lambda f: f"{f['units']}_units_1_in_{f['share']}_by_{f['factor']}_{f['order']}_order")
def test_late_answers_are_never_good_values_of_another_register(transport, field):
    verdict, _, late, _, summary = run_field(transport, seconds=4, **field)
    assert verdict.good > 0 and late > 0, f"{verdict}, {late} late: nothing was tried"
    assert verdict.wrong == 0, f"{verdict}\n" + "\n".join(verdict.examples)
    assert verdict.old == 0, f"{verdict}\n" + "\n".join(verdict.examples)
