"""`takt demo`: what a newcomer sees first."""
import json

import pytest

from program import takt


@pytest.fixture(scope="module")
def events():
    return [json.loads(line) for line in takt("demo", "--for", "3s", "--json").lines]


def test_values_of_three_devices(events):
    values = [e for e in events if e["event"] == "value"]
    assert len({e["device"] for e in values}) == 3
    assert all(set(e) >= {"time_ms", "line", "device", "name", "value", "quality", "reason", "age_ms"} for e in values)


def test_values_move(events):
    seen = {}
    for event in (e for e in events if e["event"] == "value" and e["quality"] == "good"):
        seen.setdefault(event["name"], set()).add(event["value"])
    assert any(len(values) > 2 for values in seen.values())


def test_the_refusing_device_is_seen_to_refuse(events):
    assert any(e["event"] == "value" and e["quality"] != "good" and e["reason"] for e in events)


def test_times_do_not_run_backwards(events):
    times = [e["time_ms"] for e in events if e["event"] == "value"]
    assert times == sorted(times)


def test_the_text_compares_and_sums_up():
    result = takt("demo", "--for", "2s")
    assert "cycle" in result.out.lower()


@pytest.mark.parametrize("language", ["ru", "uk"])
def test_other_languages(language):
    result = takt("demo", "--for", "500ms", "--lang", language)
    assert not (result.out + result.err).isascii()
