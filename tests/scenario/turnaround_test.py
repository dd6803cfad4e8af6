"""docs/planning.md, "Measured response times": the turnaround measured, learnt and kept; late responses
kept."""
import json
import re
import time

import pytest

from fake_slave import SerialSlave, TcpSlave, rtu_answers, tcp_answer
from program import start, takt, until
from projects import serial, tcp

INT = "type: int16, read: 0x03"
ANSWER = "03 02 0007"
ENOUGH = 100


def learning(text, lines="turnaround: learn"):
    """The text with `lines` instead of its response_timeout."""
    text, count = re.subn(r"(?m)^( +)response_timeout: \S+$",
                          lambda found: found[1] + lines.replace("\n", "\n" + found[1]), text)
    assert count == 1
    return text


def device_of(control):
    return takt("ctl", control, "status", "--json").json["lines"][0]["devices"][0]


def exchanges(control):
    return (device_of(control)["turnaround"] or {}).get("exchanges", 0)


def measure(path, control, count):
    """Runs until so many exchanges were measured. Returns the summary of the device and the text of the
    run."""
    with start("run", path, "--json", "--control", control) as run:
        run.wait_event(lambda e: e["event"] == "value" and e["quality"] == "good", "the first value")
        # The summary tells how many there were. To ask more often would slow what is measured.
        while exchanges(control) < count:
            time.sleep(0.3)
        run.interrupt()
    return run.events()[-1]["lines"][0]["devices"][0]


def late_after(seconds, count, answer):
    """The first `count` answers come late."""
    left = [count]

    def answers(request):
        if left[0] > 0:
            left[0] -= 1
            time.sleep(seconds)
        return answer(request)

    return answers


def test_a_turnaround_is_measured_and_offered_and_leaves_no_file(project, pair, tmp_path):
    path = project(serial([f"register: 0, {INT}, period: 10ms"], port=pair.a))
    with SerialSlave(pair.b, rtu_answers({"03 0000 0001": ANSWER})):
        device = measure(path, tmp_path / "control", ENOUGH)
        with start("run", path) as run:
            until(lambda: run.out, "something is printed")
            result = run.interrupt()
    measured = device["turnaround"]
    assert measured["exchanges"] >= ENOUGH and not measured["learnt"], measured
    assert measured["longest_ms"] >= 0 and measured["p999_ms"] is None, "99.9 % need 1,000 exchanges"
    assert measured["advised"].endswith("ms") and device["late_responses"] is None
    assert "turnaround at most" in result.out or "0x03" in result.out
    assert not path.with_suffix(".learnt.json").exists(), "nobody asked to learn"


def test_a_learnt_turnaround_is_kept_and_used(project, pair, tmp_path):
    text = serial([f"register: 0, {INT}, period: 10ms"], port=pair.a)
    path = project(learning(text))
    first = takt("plan", path, "--json").json["lines"][0]
    assert "response_times" not in first and first["verdict"] == "response_unknown"
    with SerialSlave(pair.b, rtu_answers({"03 0000 0001": ANSWER})):
        device = measure(path, tmp_path / "control", ENOUGH)
        assert device["turnaround"]["learnt"] and device["turnaround"]["advised"] is None
        kept = json.loads(path.with_suffix(".learnt.json").read_text())
        assert kept["takt_learnt"] == 2
        times = kept["lines"][0]["devices"][0]["times"]
        assert times["exchanges"] == device["turnaround"]["exchanges"] == sum(count
                                                                              for _, count in times["counts"])

        plan = takt("plan", path, "--json", code=None).json
        note = next(f for f in plan["findings"] if f["code"] == "guarantee.response_measured")
        assert note["severity"] == "note" and f"over {times['exchanges']} exchanges, not known" in note[
            "message"]
        assert note["advice"].startswith(
            f"{note['value']} is the longest response time measured, late responses included")
        line = plan["lines"][0]
        assert line["response_times"][0]["turnaround"]["exchanges"] == times["exchanges"]
        # The same as with the longest time written into the file, and twice that as the time-out.
        longest = times["longest_us"]
        time_out = max(20_000, 2 * longest)
        control = learning(text, f"turnaround: {longest:.0f}us\nresponse_timeout: {time_out:.0f}us")
        written = takt("plan", project(control, "written.yaml"), "--json", code=None).json["lines"][0]
        for figure in ("c_us", "f_us"):
            assert line["requests"][0][figure] == pytest.approx(written["requests"][0][figure], abs=5), figure
            assert line["requests"][0][figure] != first["requests"][0][figure], "not the whole time-out"
        known = takt("check", path, "--json", code=None).json["response_times"]
        assert [(d["line"], d["device"], d["turnaround"]["exchanges"])
                for d in known] == [("rs485-1", "Node1", times["exchanges"])]
        assert f"learnt over {times['exchanges']} exchanges" in takt("plan", path, code=None).out

        again = measure(path, tmp_path / "again", times["exchanges"] + 10)
    assert again["turnaround"]["exchanges"] >= times["exchanges"] + 10, "both runs count"


def test_a_learnt_time_out_grows_with_a_late_response(project, tmp_path):
    answers = late_after(0.7, 1, lambda adu: tcp_answer(adu, ANSWER))
    with TcpSlave(answers) as slave:
        path = project(learning(tcp([f"register: 0, {INT}, period: 200ms"], slave.port)))
        with start("run", path, "--json") as run:
            event = run.wait_event(lambda e: e["event"] == "delays", "the late response is named")
            run.wait_event(lambda e: e["event"] == "value" and e["quality"] == "good", "a good value")
            run.interrupt()
    assert event["setting"] == "learnt_timeout" and event["limit_ms"] == 500
    assert event["advised_ms"] >= 2 * event["delay_ms"] - 1


def test_lateness_is_kept_and_reported_until_the_time_out_is_long_enough(project, tmp_path):
    answers = late_after(2.5, 3, lambda adu: tcp_answer(adu, ANSWER))
    with TcpSlave(answers) as slave:
        text = tcp([f"register: 0, {INT}, period: 200ms"], slave.port, response_timeout="1500ms")
        path = project(text)
        with start("run", path, "--json") as run:
            run.wait_event(lambda e: e["event"] == "delays" and not e["advised_ms"], "the first is named")
            event = run.wait_event(lambda e: e["event"] == "delays" and e["advised_ms"], "three give advice")
            run.wait_event(lambda e: e["event"] == "value" and e["quality"] == "good", "a good value")
            run.interrupt()
            before = run.events()[-1]["lines"][0]["devices"][0]["late_responses"]
        sentence = f"Device Node1 answered {event['text'].split()[3]} ms after its request; " \
            "response_timeout is 1500 ms: set "
        assert event["text"].startswith(sentence), event
        with start("run", path, "--json") as run:  # it is not late any more
            run.wait_event(lambda e: e["event"] == "value" and e["quality"] == "good", "a good value")
            result = run.interrupt()
        device = run.events()[-1]["lines"][0]["devices"][0]
        assert device["late_answers"] == 0 and device["delays"]["setting"] == "response_timeout"
        assert device["late_responses"]["count"] == before["count"] >= 3
        assert device["late_responses"]["longest_ms"] >= 2490
        assert "response_timeout is 1500 ms" in result.err, "a warning from the start"
    warning = next(f for f in takt("check", path, "--json").json["findings"] if f["code"] == "learnt.late")
    assert warning["severity"] == "warning" and warning["value"].endswith(" ms")
    path.write_text(text.replace("response_timeout: 1500ms", "response_timeout: 30s"))
    assert "learnt.late" not in [f["code"] for f in takt("check", path, "--json").json["findings"]]


def test_a_damaged_file_is_reported_and_kept(project, pair, tmp_path):
    path = project(learning(serial([f"register: 0, {INT}, period: 10ms"], port=pair.a)))
    learnt = path.with_suffix(".learnt.json")
    learnt.write_text('{"takt_learnt": 2, "lines": [{"line": 3')
    with SerialSlave(pair.b, rtu_answers({"03 0000 0001": ANSWER})):
        device = measure(path, tmp_path / "control", ENOUGH)
    assert device["turnaround"]["exchanges"] >= ENOUGH
    assert learnt.read_text() == '{"takt_learnt": 2, "lines": [{"line": 3', "not overwritten"
    assert "learnt.damaged" in [f["code"] for f in takt("check", path, "--json").json["findings"]]


def test_a_wrong_word_names_the_allowed_one(project, pair):
    path = project(serial([f"register: 0, {INT}, period: 1s"], port=pair.a, turnaround="lern"))
    result = takt("check", path, code=1)
    assert "`learn`" in result.out and "0ms..65535ms, learn" in result.out
