"""Guarantees on the command line: verdict, measures, --prove, --fix (docs/guarantees.md)."""
import pytest

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
    for options, severity, code in ((), "warning", 0), (("--prove",), "error", 1):
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
    assert "error" in {f["severity"] for f in takt("check", path, "--json", "--prove", code=1).json["findings"]}
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
    demanding = BLOCKED.replace("poll_period: 100ms, turnaround", "poll_period: 100ms, deadline: 100ms, turnaround")
    assert takt("plan", project(demanding), "--json", code=1).json["lines"][0]["verdict"] == "cannot_hold"
    result = takt("run", project(demanding), "--for", "200ms", code=3)  # there is no such port
    assert "takt check" in result.err


def test_polling_without_a_period_has_no_bound(project):
    line = takt("plan", project(serial(at([0], "type: int16, read: 0x03, period: 0"), turnaround="5ms")),
                "--json").json["lines"][0]
    assert line["requests"][0]["response_us"] is None and line["requests"][0]["age_us"] is None
    assert line["feasible"] is True
