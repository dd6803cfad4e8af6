"""Guarantees on the command line: verdict, measures, --prove, --fix (docs/guarantees.md)."""
import re

import pytest
import yaml

from program import takt
from projects import at, scenario_1, serial

BLOCKED = """\
takt: 1
lines:
  - name: rs485-1
    port: /dev/takt-test-no-such-port
    baud: 19200
    parity: even
    devices:
      - {name: Fast, address: 2, poll_period: 100ms, turnaround: 5ms, variables: [
          {name: Speed, type: float, register: 0, read: 0x03}]}
      - name: Bulk
        address: 5
        poll_period: 2s
        turnaround: 5ms
        group_requests: true
        strategy: classic
        registers_per_request: 125
        variables:
""" + "".join(f"          - {{name: L{n}, type: int16, register: {n}, read: 0x03}}\n" for n in range(100))

FIGURES = {"c_us", "f_us", "response_us", "response_fault_us", "response_dead_us", "deadline_us", "age_us"}


def test_an_infeasible_project_is_reported_and_its_plan_is_printed(project):
    path = project(BLOCKED)
    for options, severity, code in ((), "warning", 0), (("--prove", ), "error", 1):
        findings = takt("check", path, "--json", *options, code=code).json["findings"]
        late = [f for f in findings if f["code"] == "guarantee.late"]
        assert [f["path"] for f in late] == ["lines[0].devices[0].variables[0]"]
        assert late[0]["severity"] == severity and late[0]["allowed"] == "100 ms" and late[0]["line"] == 9
    plan = takt("plan", path, "--json", "--prove", code=1).json
    line = plan["lines"][0]
    assert line["feasible"] is False and line["verdict"] == "not_proved"
    fast = next(r for r in line["requests"] if r["device"] == "Fast")
    assert FIGURES <= fast.keys()
    assert fast["response_us"] > fast["deadline_us"] == 100_000
    assert fast["age_us"] == fast["response_us"] + 100_000
    assert fast["ages_us"] == [fast["age_us"]]
    text = takt("plan", path)
    assert "registers_per_request: 50" in text.out and "Speed" in text.err


def test_a_measure_makes_it_feasible(project):
    measures = takt("plan", project(BLOCKED), "--json").json["lines"][0]["measures"]
    assert [m["kinds"] for m in measures] == [["splitting"], ["bit_rate"], ["periods"]]
    change = measures[0]["changes"][0]
    assert (change["key"], change["from"], change["to"]) == ("registers_per_request", "125", "50")
    changed = BLOCKED.replace("registers_per_request: 125", "registers_per_request: 50")
    line = takt("plan", project(changed), "--json").json["lines"][0]
    assert line["feasible"] is True and line["measures"] == []
    speed = next(r for r in line["requests"] if r["device"] == "Fast")
    assert speed["response_us"] == measures[0]["response_after_us"]
    faster = BLOCKED.replace("baud: 19200", f"baud: {measures[1]['changes'][0]['to']}")
    assert takt("plan", project(faster), "--json").json["lines"][0]["feasible"] is True


def test_fix_changes_the_plan_and_not_the_file(project):
    path = project(BLOCKED)
    text = path.read_text()
    result = takt("plan", path, "--fix")
    assert "registers_per_request: 50" in result.out
    assert path.read_text() == text
    fixed = takt("plan", path, "--fix", "--json").json["fixed"]
    assert fixed["lines"][0]["feasible"] is True
    assert [c["key"] for c in fixed["changes"]] == ["registers_per_request"]


def test_an_unknown_turnaround_is_a_note_unless_prove(project):
    path = project(scenario_1())
    findings = takt("check", path, "--json").json["findings"]
    assert [(f["severity"], f["code"]) for f in findings] == [("note", "guarantee.response_unknown")]
    assert "Node1" in findings[0]["message"] and "11.4 %" in findings[0]["message"]
    assert takt("plan", path, "--json").json["lines"][0]["verdict"] == "response_unknown"
    assert "error" in {
        f["severity"]
        for f in takt("check", path, "--json", "--prove", code=1).json["findings"]
    }
    takt("plan", path)
    assert takt("plan", path, "--prove", code=1).out
    for command, hidden in ("check", "--no-notes"), ("plan", "--no-notes"):
        shown, short = takt(command, path), takt(command, path, hidden)
        assert "note:" in shown.out + shown.err and "note:" not in short.out + short.err


def test_check_ends_with_what_the_project_will_do(project):
    path = project(scenario_1().replace("poll_period: 100ms", "poll_period: 1s\n        turnaround: 5ms"))
    result = takt("check", path)
    assert result.out == "" and result.err.splitlines()[-1].startswith("requests: 1, cycle ")
    outlook = takt("check", path, "--json").json["outlook"]
    ages = takt("plan", path, "--json").json["lines"][0]["requests"][0]["ages_us"]
    assert outlook["requests"] == 1 and outlook["oldest_us"] == max(ages) and outlook["oldest"]


@pytest.mark.parametrize("language", ["en", "ru", "uk"])
def test_in_three_languages(project, language):
    result = takt("--lang", language, "plan", project(BLOCKED))
    assert "{" not in result.out + result.err and "app." not in result.out + result.err


def test_run_says_so_and_runs(project):
    demanding = BLOCKED.replace("poll_period: 100ms, turnaround",
                                "poll_period: 100ms, deadline: 100ms, turnaround")
    assert takt("plan", project(demanding), "--json", code=1).json["lines"][0]["verdict"] == "cannot_hold"
    result = takt("run", project(demanding), "--for", "200ms", code=3)  # there is no such port
    assert "takt check" in result.err


def test_polling_without_a_period_has_no_bound(project):
    line = takt("plan", project(serial(at([0], "type: int16, read: 0x03, period: 0"), turnaround="5ms")),
                "--json").json["lines"][0]
    assert line["requests"][0]["response_us"] is None and line["requests"][0]["age_us"] is None
    assert line["feasible"] is True


# --- each measure, written into the file

SLOW = """\
takt: 1
lines:
  - name: rs485-1
    port: /dev/takt-test-no-such-port
    baud: 9600
    devices:
"""
GATEWAY = """
servers:
  - name: Gateway
    listen: 127.0.0.1
    tcp_port: 15020
    relay: [{line: rs485-1}]
"""


def slow(*devices, line="", after=""):
    """A project with devices given as (settings, (register, settings of the variable)…)."""
    text = SLOW.replace("    devices:\n", line + "    devices:\n")
    for number, (settings, *variables) in enumerate(devices, 1):
        text += f"      - {{name: D{number}, address: {number}, {settings}, variables: [\n"
        text += ",\n".join(
            f"          {{name: V{number}_{register}, type: int16, read: 0x03, register: {register}, {more}}}"
            for register, more in variables)
        text += "]}\n"
    return text + after


LATE = {
    "a long read blocks": (BLOCKED, ()),
    "one request overloads": (slow(
        ("turnaround: 5ms", (0, "period: 20ms"), (500, "period: 1s"), (900, "period: 1s"))), ()),
    "all overload": (slow(*[("turnaround: 20ms, poll_period: 100ms", *[(100 * n, "")
                                                                       for n in range(8)])] * 3), ()),
    "eight alarm bits": (slow(("turnaround: 20ms", (9, "period: 500ms"))).replace(
        "variables: [", "variables: [" +
        "".join(f"{{name: A{bit}, type: bool, register: 5, bit: {bit}, read: 0x03, period: 60ms}}, "
                for bit in range(8))), ()),
    "not grouped": (slow(
        ("turnaround: 5ms, group_requests: false, poll_period: 200ms", *[(n, "") for n in range(12)])), ()),
    "turnaround not known": (slow(("poll_period: 400ms", (0, ""), (500, ""))), ("--prove", )),
    "relayed requests": (slow(("turnaround: 20ms", (0, "period: 2s, deadline: 1900ms")),
                              line="    relay_interval: 10ms\n",
                              after=GATEWAY).replace("baud: 9600", "baud: 115200"), ()),
    "faults": (slow(("turnaround: 5ms, response_timeout: 1200ms", (0, "period: 1s"), (500, "period: 1s")),
                    after="faults: {burst: 1, every: 10s}\n"), ()),
}


def written(text, changes):
    """The project with each change written where its path says."""
    document = yaml.safe_load(text)
    for change in changes:
        place = document
        for name, index in re.findall(r"(\w+)\[(\d+)\]", change["path"]):
            place = place[name][int(index)]
        assert change["path"] == "" or place["name"] == change["name"]
        place[change["key"]] = yaml.safe_load(change["to"])
    return yaml.safe_dump(document, sort_keys=False)


# A line that holds can be late with a dead device. That is the next finding, not the one that a measure
# removes.
WITHOUT_FAILURES = {
    "guarantee.late", "guarantee.unbounded", "guarantee.overload", "guarantee.overload_grouped",
    "guarantee.response_unknown"
}


def late(findings):
    return {f["code"] for f in findings} & (WITHOUT_FAILURES | {"guarantee.late_with_fault"})


@pytest.mark.parametrize("case", LATE)
def test_each_measure_written_into_the_file_removes_its_finding(project, case):
    text, options = LATE[case]
    plan = takt("plan", project(text), "--json", *options, code=None).json
    before = late(plan["findings"])
    measures = plan["lines"][0]["measures"]
    assert before and measures
    for measure in measures:
        again = takt("check", project(written(text, measure["changes"])), "--json", *options, code=None).json
        assert not late(again["findings"]) & (before | WITHOUT_FAILURES), measure["text"]


def test_measures_name_what_helps_most_first(project):
    kinds = {
        case:
        [m["kinds"] for m in takt("plan", project(text), "--json", code=None).json["lines"][0]["measures"]]
        for case, (text, _) in LATE.items()
    }
    assert kinds["not grouped"][0] == ["grouping"]
    assert kinds["one request overloads"][0] == ["periods"]
    assert kinds["relayed requests"][0] == ["relay_interval"]
    text = takt("plan", project(LATE["one request overloads"][0]), code=None).out
    assert "V1_0" in text and re.search(r"largest share of the line, \d+\.\d %", text)


def test_the_advice_for_a_controller_is_none_that_was_followed(project):
    """All requests are grouped, and `turnaround: learn` has no effect in that profile."""
    text = serial(at([0, 10, 20], "type: float, read: 0x03"), profile="owen-kc1")
    busy = takt("check", project(text.replace("115200", "1200"))).out
    assert "Lengthen the period" in busy and "Group the requests" not in busy
    ungrouped = serial(at([0, 10, 20], "type: float, read: 0x03"), profile="owen-kc1",
                       group_requests="false", strategy="single").replace("115200", "1200")
    alone = takt("check", project(ungrouped)).out
    assert "Group the requests" in alone
    unknown = takt("check", project(text)).out
    assert "Write it as `turnaround:`" in unknown and "learn" not in unknown
    assert "learn" in takt("check", project(text.replace("owen-kc1", "generic"))).out
