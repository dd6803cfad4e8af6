"""`takt demo`, the first command of a new user."""
import csv
import io
import json

import pytest

from program import ROOT, start, takt, until


@pytest.fixture(scope="module")
def events():
    """Of a demonstration that lasts until every device has answered, the values have moved, and one was
    refused."""
    with start("demo", "--json") as demo:

        def seen():
            found = demo.events()
            answering = {e["device"] for e in found if e["event"] == "device" and e["state"] == "answering"}
            values = [e for e in found if e["event"] == "value"]
            return len(answering) == 3 and any(refused(e) for e in values) and most_values(values) > 2

        until(seen, "values of three devices that move, and a refusal")
        demo.interrupt()
        return demo.events()


def refused(event):
    return event["quality"] != "good" and event["reason"].startswith("exception")


def most_values(events):
    """How many good values the variable with most of them had."""
    seen = {}
    for event in events:
        if event["quality"] == "good":
            seen.setdefault(event["name"], set()).add(event["value"])
    return max(map(len, seen.values()), default=0)


def test_values_of_three_devices(events):
    values = [e for e in events if e["event"] == "value"]
    assert len({e["device"] for e in values}) == 3
    assert all(
        set(e) >= {"time_ms", "line", "device", "name", "value", "quality", "reason", "age_ms"}
        for e in values)


def test_values_move(events):
    assert most_values(e for e in events if e["event"] == "value") > 2


def test_the_refusing_device_is_seen_to_refuse(events):
    assert any(e["event"] == "value" and e["quality"] != "good" and e["reason"] for e in events)


def test_times_do_not_run_backwards(events):
    times = [e["time_ms"] for e in events if e["event"] == "value"]
    assert times == sorted(times)


def test_the_summary_has_planned_and_measured_cycle(events):
    assert [e["event"] for e in events].index("summary") == len(events) - 1
    (line, ) = events[-1]["lines"]
    assert line["planned_cycle_ms"] > 0 and line["measured_cycle_ms"] > 0
    assert {d["name"]: d["state"]
            for d in line["devices"]} == dict.fromkeys(["Boiler", "Meter", "Pump"], "answering")
    counters = line["counters"]
    assert counters["answered"] + counters["exceptions"] <= counters["sent"]
    assert set(counters["exceptions_by_code"]) == {"2"}, "the pump refuses an address it does not have"
    assert counters["timeouts"] == counters["checksums"] == counters["unexpected"] == 0
    assert next(d for d in line["devices"]
                if d["name"] == "Pump")["counters"]["exceptions"] == counters["exceptions"] > 0


def test_its_plan_needs_fewer_requests_than_polling_one_by_one():
    (line, ) = takt("plan", ROOT / "examples/demo.yaml", "--json", "--compare").json["lines"]
    assert line["request_count"] < line["ungrouped_requests"]
    grouped, ungrouped = line["compare"]["grouped"], line["compare"]["ungrouped"]
    # The write of Setpoint is a request of its own, and is part of the one that reads it without grouping.
    assert grouped["requests"] == line["request_count"]
    assert ungrouped["requests"] == line["ungrouped_requests"] + 1
    assert all(grouped[what] < ungrouped[what] for what in ("requests", "bytes", "bus_time_us", "cycle_us"))


def test_the_plan_as_csv_has_all_that_its_json_has():
    example = ROOT / "examples/demo.yaml"
    rows = list(csv.DictReader(io.StringIO(takt("plan", example, "--csv").out)))
    requests = takt("plan", example, "--json").json["lines"][0]["requests"]
    assert [(row["line"], int(row["start"]), row["why"], row["variables"]) for row in rows] == [
        ("rs485-1", r["start"], r["why"], "; ".join(r["variables"])) for r in requests]
    assert set(rows[0]) == {"line"}.union(*requests)
    takt("plan", example, "--csv", "--json", code=2)


def test_the_text_compares_and_sums_up():
    with start("demo") as demo:
        demo.wait_line(lambda line: "Supply temperature = " in line, "a value")
        out = demo.interrupt().out
    for word in ("single", "classic", "optimal", "cycle planned", "measured", "Boiler", "Meter", "Pump",
                 "Supply temperature"):
        assert word in out, word


def test_the_plan_reads_over_gaps_where_that_is_cheaper():
    strategies = takt("plan", ROOT / "examples/demo.yaml", "--json",
                      "--compare").json["lines"][0]["compare"]["strategies"]
    counts = {name: its["requests"] for name, its in strategies.items()}
    assert counts["optimal"] < counts["classic"] < counts["single"], counts


def test_the_example_shows_the_same_plant(tmp_path):
    project = tmp_path / "demo.yaml"
    project.write_text((ROOT / "examples/demo.yaml").read_text(encoding="utf-8"), encoding="utf-8")
    with start("run", project, "--json") as run:
        value = run.wait_event(lambda e: e["event"] == "value" and e["name"] == "Voltage L1", "a value")
        assert 225 < value["value"] < 235
        run.interrupt()


def test_the_trends_begin_with_an_hour_of_the_plant(tmp_path):
    """In a folder that is gone afterwards."""
    with start("demo", "--json", env={"TMPDIR": str(tmp_path)}) as demo:
        value = demo.wait_event(lambda e: e["event"] == "value" and e["name"] == "Voltage L1", "a value")
        assert 225 < value["value"] < 235
        (project, ) = tmp_path.glob("takt-demo-*/demo.yaml")
        names = ("Voltage L1", "Supply temperature", "Power")
        past = takt("history", project, *names, "--from", "-59min", "--json")
        for its, (least, greatest) in zip(past.json["variables"], [(225, 235), (60, 70), (0.3, 3)]):
            assert its["samples"] > 20, its["name"]
            assert least < its["min"] < its["max"] < greatest, its["name"]
            assert its["good_share"] > 0.99
        demo.interrupt()
    assert list(tmp_path.iterdir()) == []


def test_a_demo_without_the_page_keeps_nothing(tmp_path):
    assert takt("demo", "--no-web", "--for", "200ms", TMPDIR=str(tmp_path)).code == 0
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("language", ["ru", "uk"])
def test_other_languages(language):
    result = takt("demo", "--for", "200ms", "--lang", language)
    assert not (result.out + result.err).isascii()
