"""docs/specification.md, sections 3 to 5, through `takt plan --json`: the requests of a project."""
import pytest

from program import takt
from projects import at, scenario_1, scenario_3, serial

FLOAT, INT16, INT32 = "type: float, read: 0x03", "type: int16, read: 0x03", "type: int32, read: 0x03"
WRITTEN_INT32 = "type: int32, write: 0x10, write_on_change: true"
WRITTEN_INT16 = "type: int16, write: 0x10, write_on_change: true"
BOTH = INT16 + ", write: 0x10"
GO = ["name: go, type: bool"]


def bits(places, read):
    return [f"type: bool, register: {register}, bit: {bit}, read: {read}" for register, bit in places]


def request(function, start, quantity, write_function=None):
    return function, write_function, start, quantity


# name: (project, requests as (read function, write function, start, quantity)). Section 5's rows, in its
# order.
ROWS = {
    "two-register values in any order": (serial(at([2, 8, 6, 4, 10], FLOAT)), [request(3, 2, 10)]),
    "a gap and a limit of 5": (serial(at([0, 2, 6, 8], FLOAT),
                                      registers_per_request=5), [request(3, 0, 4),
                                                                 request(3, 6, 4)]),
    "five one-register values, at most 3": (serial(at(range(5), INT16), registers_per_request=3),
                                            [request(3, 0, 3), request(3, 3, 2)]),
    "three two-register values, at most 4": (serial(at([0, 2, 4], INT32), registers_per_request=4),
                                             [request(3, 0, 4), request(3, 4, 2)]),
    "float and two-register int": (serial(at([0], FLOAT) + at([2], INT32)), [request(3, 0, 4)]),
    "bool, int and float, all 0x03": (serial(bits([(0, 0)], "0x03") + at([1], INT16) + at([2], FLOAT)),
                                      [request(3, 0, 1), request(3, 1, 1),
                                       request(3, 2, 2)]),
    "bits of one register": (serial(bits([(3, 4), (3, 5), (3, 6)], "0x01")), [request(1, 52, 3)]),
    "bits of one register, read as a register": (serial(bits([(3, 4), (3, 5), (3, 6)],
                                                             "0x03")), [request(3, 3, 1)]),
    "bits of two registers": (serial(bits([(3, 14), (3, 15), (4, 0), (4, 1)],
                                          "0x01")), [request(1, 62, 2), request(1, 64, 2)]),
    "ASCII, 31 two-register ints": (serial(at(range(0, 62, 2), INT32), framing="ascii",
                                           registers_per_request=61), [request(3, 0, 60),
                                                                       request(3, 60, 2)]),
    "ASCII, 62 one-register ints, 0x04": (serial(at(range(62), "type: int16, read: 0x04"), framing="ascii",
                                                 registers_per_request=61),
                                          [request(4, 0, 61), request(4, 61, 1)]),
    "ASCII, 30 two-register ints written": (serial(at(range(0, 60, 2), WRITTEN_INT32), framing="ascii",
                                                   registers_per_request=61, profile="owen-kc1"),
                                            [request(None, 0, 58, 16),
                                             request(None, 58, 2, 16)]),
    "RTU, 62 two-register ints written": (serial(at(range(0, 124, 2), WRITTEN_INT32),
                                                 registers_per_request=125),
                                          [request(None, 0, 122, 16),
                                           request(None, 122, 2, 16)]),
    "same register, 0x03 and 0x04": (serial(at([7], INT16) + at([7], "type: int16, read: 0x04")),
                                     [request(3, 7, 1), request(4, 7, 1)]),
    "read and written on change": (serial(at(range(4),
                                             BOTH + ", write_on_change: true")), [request(3, 0, 4, 16)]),
    "write on change yes, yes, no, no": (serial([
        f"register: {i}, {BOTH}, write_on_change: {on}"
        for i, on in enumerate(["true", "true", "false", "false"])
    ]), [request(3, 0, 4), request(None, 0, 2, 16)]),
    "write on change yes, yes, no, no with one trigger": (serial([
        f"register: {i}, {BOTH}, write_on_change: {on}, write_trigger: go"
        for i, on in enumerate(["true", "true", "false", "false"])
    ], local=GO), [request(3, 0, 4), request(None, 0, 2, 16),
                   request(None, 2, 2, 16)]),
    # Section 3: the limit is cut to the contents of a frame.
    "ASCII, 125 ints written": (serial(at(range(125), WRITTEN_INT16), framing="ascii",
                                       registers_per_request=61, profile="owen-kc1"), [
                                           request(None, 0, 59, 16),
                                           request(None, 59, 59, 16),
                                           request(None, 118, 7, 16)
                                       ]),
    "RTU, 125 ints written": (serial(at(range(125), WRITTEN_INT16), registers_per_request=125),
                              [request(None, 0, 123, 16),
                               request(None, 123, 2, 16)]),
    "RTU, 126 ints read": (serial(at(range(126), INT16),
                                  registers_per_request=125), [request(3, 0, 125),
                                                               request(3, 125, 1)]),
    "ASCII without the small buffer, 125 ints written": (serial(
        at(range(125), WRITTEN_INT16), framing="ascii",
        registers_per_request=125), [request(None, 0, 123, 16),
                                     request(None, 123, 2, 16)]),
    # Section 4: 0x05 and 0x06 never group, unused variables make no traffic, a write by command only makes no
    # entry.
    "0x06 on change": (serial(at(range(3), "type: int16, write: 0x06, write_on_change: true")),
                       [request(None, i, 1, 6) for i in range(3)]),
    "an unused variable is a gap": (serial([
        f"register: {i}, {INT16}, used: {used}" for i, used in enumerate(["true", "false", "true"])
    ]), [request(3, 0, 1), request(3, 2, 1)]),
    "a write by command only": (serial(at([0], "type: int16, write: 0x06") + at([9], INT16)),
                                [request(3, 9, 1)]),
    "an order conflict": (  # rule 8: 0 and 2 are read and numbered before 1, which is only written
        serial([
            f"register: {i}, type: int16, write: 0x10, write_on_change: true, read: {read}"
            for i, read in enumerate(["0x03", "none", "0x03"])
        ]), [request(3, 0, 1, 16), request(3, 2, 1, 16),
             request(None, 1, 1, 16)]),
    "not grouped by default": (serial(at(range(3), INT16), group_requests="false",
                                      strategy="single"), [request(3, i, 1) for i in range(3)]),
    # Scenarios 1 and 2.
    "scenario 1": (scenario_1(), [request(3, 0, 20)]),
    "scenario 1, at most 20": (scenario_1(registers_per_request=20), [request(3, 0, 20)]),
    "scenario 2": (scenario_1(grouped=False), [request(3, i, 2) for i in range(0, 20, 2)]),
    "scenario 3": (scenario_3(), [request(3, 500, 2), request(4, 506, 1)]),
    "scenario 3, ungrouped": (scenario_3(grouped=False),
                              [request(3, 500, 1), request(3, 501, 1),
                               request(4, 506, 1)]),
}


def planned(project, text):
    plan = takt("plan", project(text), "--json").json
    errors = [f for f in plan["findings"] if f["severity"] == "error"]
    assert errors == []
    assert len(plan["lines"]) == 1
    return plan["lines"][0]


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row.replace(" ", "-"))
def test_requests(project, row):
    text, expected = ROWS[row]
    got = [
        request(r["function"], r["start"], r["quantity"], r["write_function"])
        for r in planned(project, text)["requests"]
    ]
    key = lambda r: [-1 if x is None else x for x in r]  # noqa: E731
    assert sorted(got, key=key) == sorted(expected, key=key)


# (project, requests, requests without grouping): an entry with a period and a start-reading trigger counts
# twice.
@pytest.mark.parametrize("text, grouped, ungrouped", [
    (scenario_1(), 1, 10),
    (scenario_1(grouped=False), 10, 10),
    (scenario_3(), 4, 6),
    (scenario_3(grouped=False), 6, 6),
    (ROWS["write on change yes, yes, no, no"][0], 2, None),
    (ROWS["write on change yes, yes, no, no with one trigger"][0], 3, None),
], ids=["scenario-1", "scenario-2", "scenario-3", "scenario-3-ungrouped", "writes", "writes-with-trigger"])
def test_counted_requests(project, text, grouped, ungrouped):
    line = planned(project, text)
    assert line["request_count"] == grouped
    if ungrouped is not None:
        assert line["ungrouped_requests"] == ungrouped


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row.replace(" ", "-"))
def test_every_variable_is_read_once(project, row):
    requests = planned(project, ROWS[row][0])["requests"]
    read = [name for r in requests if r["function"] is not None for name in r["variables"]]
    written = [name for r in requests if r["write_function"] is not None for name in r["variables"]]
    assert len(read) == len(set(read)) and len(written) == len(set(written))
    assert all(r["why"] for r in requests), "each request has the reason of its end"
    assert all(r["device"] == "Node1" and r["unit"] == 16 and r["bus_time_us"] > 0 for r in requests)


def test_scenario_3_has_its_periods_and_triggers(project):
    pair, third = sorted(planned(project, scenario_3())["requests"], key=lambda r: r["start"])
    assert (pair["period_ms"], pair["read_trigger"], pair["variables"]) == (100, "T512", ["First", "Second"])
    assert (third["period_ms"], third["read_trigger"], third["variables"]) == (50, "T600", ["Third"])


# Section 4, the table of conditions: two or three neighbours, and whether they share one request.
CONDITIONS = {
    "same type": (at([0, 2, 4], FLOAT), 1),
    "another type": (at([0], FLOAT) + at([2], INT16), 2),
    "signed beside unsigned": (at([0], INT16) + at([1], "type: uint16, read: 0x03"), 1),
    "no gaps": (at([0, 2, 4], FLOAT), 1),
    "a gap": (at([0, 3], FLOAT), 2),
    "an overlap": (at([0, 1], FLOAT), 2),
    "same function": (at([0, 1], "type: int16, read: 0x04"), 1),
    "another function": (at([0], INT16) + at([1], "type: int16, read: 0x04"), 2),
    "same period": (at([0, 1], INT16 + ", period: 200ms"), 1),
    "another period": (at([0], INT16 + ", period: 100ms") + at([1], INT16 + ", period: 200ms"), 2),
    "the device's period, stated and by default": (at([0], INT16) + at([1], INT16 + ", period: 100ms"), 1),
    "one start-reading trigger": (at([0, 1], INT16 + ", read_trigger: t1"), 1),
    "two start-reading triggers": (at([0], INT16 + ", read_trigger: t1") +
                                   at([1], INT16 + ", read_trigger: t2"), 2),
    "a start-reading trigger and none": (at([0], INT16 + ", read_trigger: t1") + at([1], INT16), 2),
    "one start-writing trigger": (at([0, 1], BOTH + ", write_trigger: t1"), 1),
    "two start-writing triggers": (at([0], "type: int16, write: 0x10, write_trigger: t1") +
                                   at([1], "type: int16, write: 0x10, write_trigger: t2"), 2),
    "one status": (at([0, 1], INT16 + ", status: s1"), 1),
    "two statuses": (at([0], INT16 + ", status: s1") + at([1], INT16 + ", status: s2"), 2),
    "a status and none": (at([0], INT16 + ", status: s1") + at([1], INT16), 2),
    "no status": (at([0, 1], INT16), 1),
}
LOCALS = ["name: t1, type: bool", "name: t2, type: bool", "name: s1, type: int", "name: s2, type: int"]


@pytest.mark.parametrize("condition", CONDITIONS, ids=lambda c: c.replace(" ", "-"))
def test_condition(project, condition):
    variables, expected = CONDITIONS[condition]
    assert len(planned(project, serial(variables, local=LOCALS))["requests"]) == expected


def test_two_devices_never_share_a_request(project):
    text = serial(at([0], INT16)) + """\
      - name: Node2
        address: 17
        group_requests: true
        strategy: classic
        variables:
          - {name: W1, type: int16, register: 1, read: 0x03}
"""
    assert [(r["device"], r["unit"]) for r in planned(project, text)["requests"]] == [("Node1", 16),
                                                                                      ("Node2", 17)]


def test_compare_shows_the_saving_of_grouping(project):
    """Scenario 1: ten requests of 8 + 9 bytes against one of 8 + 45: 90 % of the requests saved."""
    path = project(scenario_1())
    compare = takt("plan", path, "--json", "--compare").json["lines"][0]["compare"]
    assert (compare["ungrouped"]["requests"], compare["ungrouped"]["bytes"]) == (10, 10 * (8 + 9))
    assert (compare["grouped"]["requests"], compare["grouped"]["bytes"]) == (1, 8 + 45)
    assert compare["saved_percent"]["requests"] == pytest.approx(90)
    assert "-90 %" in takt("plan", path, "--compare").out


def test_compare_sets_the_strategies_beside_each_other(project):
    path = project(scenario_1())
    compare = takt("plan", path, "--json", "--compare").json["lines"][0]["compare"]
    strategies = compare["strategies"]
    assert list(strategies) == ["single", "classic", "optimal"]
    assert (strategies["single"]["requests"], strategies["single"]["requests_per_second"]) == (10, 100)
    assert (strategies["classic"]["requests"], strategies["classic"]["bytes"]) == (1, 8 + 45)
    assert strategies["classic"]["saved_percent"]["requests_per_second"] == pytest.approx(90)
    assert strategies["optimal"]["utilization"] <= strategies["classic"]["utilization"]
    out = takt("plan", path, "--compare").lines
    assert [line.split()[0] for line in out if line and line[0] != " "] == ["rs485-1", *strategies]
    assert "as configured" in out[3], "the strategy of the project is marked"
    bars = [line.count("█") for line in out if "█" in line]
    assert len(bars) == 3 and bars[0] > bars[1] >= bars[2], "single keeps the line busiest"


def test_compare_shows_a_plan_of_mixed_strategies(project):
    text = serial(at([0, 1], INT16)) + """\
      - {name: Alone, address: 17, group_requests: false, variables: [
          {name: W1, type: int16, register: 1, read: 0x03},
          {name: W2, type: int16, register: 2, read: 0x03}]}
"""
    out = takt("plan", project(text), "--compare").out
    assert "mixed" in out
    assert "mixed" not in takt("plan", project(serial(at([0, 1], INT16))), "--compare").out


def test_plan_as_text_names_its_variables(project):
    out = takt("plan", project(scenario_3())).out
    for word in ("Node1", "500", "506", "First", "Third"):
        assert word in out
