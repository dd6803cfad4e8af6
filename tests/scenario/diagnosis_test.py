"""docs/commands/run.md, "Late answers" and "Summary": devices slower than the project says, damaged answers,
lost links."""
import contextlib
import random
import re
import time

import pytest

import endpoints
from fake_slave import SerialSlave, TcpSlave, rtu_answers, tcp_answer
from program import start, takt, until
from projects import at, serial, tcp

INT = "type: int16, read: 0x03"
ANSWER = "03 02 0007"


def value(name, wanted=None, quality="good"):
    return lambda e: e["event"] == "value" and e["name"] == name and e["quality"] == quality and wanted in (
        None, e["value"])


def is_late(e):
    return e["event"] == "delays"


class Late:
    """Answers that come `seconds` after their request."""

    def __init__(self, seconds, answer):
        self.seconds, self._answer = seconds, answer

    def __call__(self, request):
        time.sleep(self.seconds)
        return self._answer(request)


def summary(run):
    run.interrupt()
    line = run.events()[-1]["lines"][0]
    return line, line["devices"][0]


def follow_advice(text, event):
    """The project text with the advised value written as the message says."""
    advice = re.search(r"set (\d+ms)", event["text"])[1]
    assert advice == f"{event['advised_ms']:g}ms"
    written, count = re.subn(rf"{event['setting']}: \w+", f"{event['setting']}: {advice}", text)
    assert count == 1
    return written


def expect_late(project, text, answers_here, late, tmp_path):
    """The late answers are named live, in the log, in the summary and in JSON. The advised value ends them:
    afterwards they are still later than the written time-out, and a busy machine delays them by less than
    what is left."""
    log, delay = tmp_path / "takt.log", late.seconds * 1000
    with answers_here(), start("run", project(text), "--json", "--log", log) as run:
        first = run.wait_event(is_late, "the late answer is named")
        event = run.wait_event(lambda e: is_late(e) and e["advised_ms"], "three late answers give advice")
        line, device = summary(run)
    assert first["advised_ms"] is None and first["text"].endswith("response_timeout is 2000 ms"), first
    assert event["device"] == "Node1" and event["delay_ms"] >= delay - 10
    assert re.fullmatch(
        r"Device Node1 answered \d+ ms after its request; response_timeout is 2000 ms: set \d+ms"
        r"( \([12] of \d+ such responses took longer\))?", event["text"])
    assert event["advised_ms"] >= 1.2 * delay and event["limit_ms"] == 2000 and event["count"] >= 3
    assert "device Node1" in log.read_text() and "response_timeout is 2000 ms: set" in log.read_text()
    assert device["late_answers"] >= 1 and device["delays"]["setting"] == "response_timeout"
    assert line["counters"]["late_answers"] >= 1 and line["counters"]["foreign_frames"] == 0
    late.seconds = 2.4
    with answers_here(), start("run", project(follow_advice(text, event), "advised.yaml"), "--json") as run:
        run.wait_event(value("V1", 7), "a good value with the advised time-out")
        line, device = summary(run)
    assert device["counters"]["answered"] >= 1 and device["delays"] is None, device


def test_a_late_answer_over_tcp_is_named_and_the_advice_works(project, tmp_path):
    late = Late(3.2, lambda adu: tcp_answer(adu, ANSWER))
    with TcpSlave(late) as slave:
        text = tcp([f"register: 0, {INT}, period: 1s"], slave.port, response_timeout="2s")
        expect_late(project, text, contextlib.nullcontext, late, tmp_path)


def test_a_late_answer_on_a_serial_line_is_named_and_the_advice_works(project, pair, tmp_path):
    text = serial([f"register: 0, {INT}, period: 1s"], port=pair.a, response_timeout="2s")
    late = Late(3.2, rtu_answers({"03 0000 0001": ANSWER}))
    expect_late(project, text, lambda: SerialSlave(pair.b, late), late, tmp_path)


@pytest.mark.parametrize("command", [
    ("read", "holding", 0),
    ("write", "holding", 0, 5),
    ("raw", "03 0000 0001"),
    ("probe", "--area", "holding", "--to", 3),
], ids=lambda its: its[0])
def test_a_response_of_another_unit_is_named(command):
    """As in `ctl status`; it is no silence."""
    with TcpSlave(lambda adu: tcp_answer(adu[:6] + b"\x01" + adu[7:], ANSWER)) as slave:
        result = takt(command[0], f"tcp://127.0.0.1:{slave.port}", "--unit", 5, *command[1:], "--timeout",
                      "200ms", "--attempts", 1, code=6)
    assert "a response of unit 1 came, unit 5 was asked" in result.err, result.err
    assert "--unit 1" in result.err


def test_a_device_that_refuses_often_has_one_steady_finding(project, tmp_path):
    """60 % of its answers, drawn at random, are exceptions."""
    drawn, log, control = random.Random(39), tmp_path / "takt.log", tmp_path / "control"
    with TcpSlave(lambda adu: tcp_answer(adu, "83 04" if drawn.random() < 0.6 else ANSWER)) as slave:
        variables = [f"register: {10 * i}, {INT}, period: 100ms" for i in range(3)]
        with start("run", project(tcp(variables, slave.port)), "--log", log, "--control", control) as run:
            status = lambda: takt("ctl", control, "status", "--json").json
            until(lambda: control.exists() and log.exists() and "requests were refused" in log.read_text(),
                  "the log has it")
            seen = []
            for _ in range(15):
                seen.append(status())
                time.sleep(0.1)
            run.interrupt()
    assert {s["health"] for s in seen} == {"degraded"}
    found = [p for s in seen for p in s["problems"] if p["kind"] != "late"]  # a busy machine
    assert len(found) == len(seen), found
    assert {(p["kind"], p["severity"], p["request"]) for p in found} == {
        ("refused", "warning", "0x03 0, 0x03 10, 0x03 20")
    }
    assert [p["since_ms"] for p in found] == sorted(p["since_ms"] for p in found), "one begin"
    assert 0.4 < found[-1]["count"] / found[-1]["of"] < 0.8 and "exception 4" in found[-1]["text"]
    text = log.read_text()
    assert text.count("requests were refused, most often with exception 4") == 1, text


def test_what_did_not_come_is_in_the_traffic_log(project, tmp_path):
    """Unit 1 answers late, and unit 2 with the address of another one: as on the page."""
    def answers(adu):
        if adu[6] == 1:
            time.sleep(0.4)
            return tcp_answer(adu, ANSWER)
        return tcp_answer(adu[:6] + b"\x09" + adu[7:], ANSWER)

    log = tmp_path / "traffic.log"
    wanted = [r"Node1:\(.*\) no response within 200 ms", r"Node1:\(.*\) late response: late by [\d.]+ ms",
              r"unit 9:\(.*\) surplus response: a response of unit 9 came, unit 2 was asked",
              r"::\(.*\) connected"]
    with TcpSlave(answers) as slave:
        text = tcp([f"register: 0, {INT}, period: 1s"], slave.port, response_timeout="200ms")
        second = tcp([f"name: V2, register: 1, {INT}, period: 1s"], slave.port, response_timeout="200ms")
        text += second[second.index("      - name: Node1"):].replace("Node1", "Node2").replace(
            "address: 1\n", "address: 2\n")
        with start("run", project(text), "--traffic", log) as run:
            until(lambda: log.exists() and all(re.search(w, log.read_text()) for w in wanted),
                  "the lines of what did not come")
            run.interrupt()


def test_a_late_answer_is_in_the_summary_as_text(project):
    with TcpSlave(Late(0.15, lambda adu: tcp_answer(adu, ANSWER))) as slave:
        path = project(tcp([f"register: 0, {INT}, period: 500ms"], slave.port, response_timeout="100ms"))
        with start("run", path) as run:
            named = run.wait_line(lambda x: "Node1 answered" in x and "set" in x, "advice")
            result = run.interrupt()
    said = re.search(r"Node1 answered .*", named)[0]
    assert "response_timeout is 100 ms: set" in said
    assert any(
        re.match(r"  Device Node1 answered \d+ ms after its request; response_timeout is 100 ms: set \d+ms",
                 x) for x in result.lines)
    request = next(x for x in result.lines if "0x03 0" in x)
    assert re.search(r" –  +–  500 ms → –$", request), "nothing was answered"
    assert "measured –" in result.out


def test_answers_later_than_the_turnaround_are_named(project, pair):
    text = serial([f"register: 0, {INT}, period: 500ms"], port=pair.a, response_timeout="20s",
                  turnaround="20ms")
    late = Late(2.0, rtu_answers({"03 0000 0001": ANSWER}))
    slave = lambda: SerialSlave(pair.b, late)
    with slave(), start("run", project(text), "--json") as run:
        event = run.wait_event(is_late, "the turnaround is named")
        line, device = summary(run)
    assert event["setting"] == "turnaround" and event["limit_ms"] == 20 and event["delay_ms"] > 22
    assert re.fullmatch(r"Device Node1 answered \d+ ms after its request; turnaround is 20 ms: set \d+ms",
                        event["text"])
    assert device["late_answers"] == 0 and device["delays"]["setting"] == "turnaround"
    assert line["counters"]["timeouts"] == 0
    late.seconds = 0.2
    with slave(), start("run", project(follow_advice(text, event), "advised.yaml"), "--json") as run:
        run.wait_event(value("V1", 7), "a good value")
        _, device = summary(run)
    assert device["delays"] is None


def test_the_real_period_is_that_of_answered_reads(project, pair):
    """Two of five answers have a wrong checksum. The first one is good: a repetition follows a bad one at
    once."""
    count = [0]
    honest = rtu_answers({"03 0000 0001": ANSWER})

    def answers(frame):
        count[0] += 1
        good = honest(frame)
        return good if count[0] % 5 < 3 else good[:-1] + bytes([good[-1] ^ 1])

    path = project(serial([f"register: 0, {INT}, period: 100ms"], port=pair.a, attempts=10))
    with SerialSlave(pair.b, answers), start("run", path, "--json") as run:
        until(lambda: count[0] >= 50, "fifty requests")
        line, _ = summary(run)
    request, duration = line["requests"][0], run.events()[-1]["duration_ms"]
    counters = request["counters"]
    assert counters["checksums"] >= 10
    assert request["real_period_ms"] * (counters["answered"] - 1) <= duration
    assert request["real_period_ms"] >= 99


def test_a_bad_checksum_is_named_although_the_turnaround_is_short(project, pair):
    """The time-out that follows from the turnaround is over before the pause that ends a frame."""
    honest = rtu_answers({"03 0000 0001": ANSWER})

    def answers(frame):
        good = honest(frame)
        return good[:-1] + bytes([good[-1] ^ 1])

    path = project(
        serial([f"register: 0, {INT}, period: 100ms"], port=pair.a, turnaround="15ms",
               response_timeout="17ms", attempts=255))
    with SerialSlave(pair.b, answers), start("run", path, "--json") as run:
        run.wait_event(lambda e: e["event"] == "value" and "checksum" in e["reason"], "the reason")
        line, _ = summary(run)
    assert line["requests"][0]["counters"]["checksums"] > 0, line


def test_nothing_answered_is_null(project):
    with TcpSlave() as slave:
        path = project(tcp(at([0], INT), slave.port, response_timeout="50ms", attempts=2))
        with start("run", path, "--json") as run:
            run.wait_event(lambda e: e["event"] == "device" and e["state"] == "not_answering",
                           "it does not answer")
            line, device = summary(run)
    counters = line["requests"][0]["counters"]
    assert counters["sent"] >= 2 and counters["mean_ms"] is None and counters["longest_ms"] is None
    assert line["requests"][0]["real_period_ms"] is None and line["measured_cycle_ms"] is None
    assert device["availability_percent"] == 0 and device["downtime_ms"] > 0
    assert line["availability_percent"] == 0


def test_a_lost_connection_is_an_outage_of_its_devices(project):
    port = endpoints.free_port()
    answers = lambda adu: tcp_answer(adu, ANSWER)
    with start("run", project(tcp(at([0], INT), port)), "--json") as run:
        with TcpSlave(answers, port):
            run.wait_event(value("V1", 7), "a good value")
            seen = len(run.out)
        lost = run.wait_event(lambda e: e["event"] == "link" and not e["up"], "connecting fails", after=seen)
        with TcpSlave(answers, port):
            again = run.wait_event(lambda e: e["event"] == "device" and e["state"] == "answering",
                                   "it answers again", after=seen)
            line, device = summary(run)
    assert device["outages"] == 1
    assert 0 < device["availability_percent"] < 100
    outage = again["time_ms"] - lost["time_ms"]
    assert outage / 2 < device["downtime_ms"] < 2 * outage + 50, "by the program's own events"
    assert line["downtime_ms"] == pytest.approx(device["downtime_ms"], rel=0.5, abs=50)


def test_a_serial_port_that_is_gone_is_an_outage(project, pair):
    path = project(serial(at([0], INT), port=pair.a))
    with start("run", path, "--json") as run:
        with SerialSlave(pair.b, rtu_answers({"03 0000 0001": ANSWER})):
            run.wait_event(value("V1", 7), "a good value")
        seen = len(run.out)
        pair.break_off()
        run.wait_event(lambda e: e["event"] == "link" and not e["up"], "the port is gone", after=seen)
        line, device = summary(run)
    assert device["state"] == "link_down" and device["outages"] == 1 and device["downtime_ms"] > 0
    assert line["availability_percent"] < 100


def test_a_single_command_names_the_delay_of_a_late_answer(project):
    late = Late(1.5, lambda adu: tcp_answer(adu, ANSWER))
    with TcpSlave(late) as slave:
        read = ["read", f"tcp://127.0.0.1:{slave.port}", "holding", "0", "--timeout"]
        result = takt(*read, "1s", code=4)
        assert re.search(r"no answer within 1000 ms; it came after \d+ ms", result.err)
        advised = re.search(r"--timeout (\d+ms)", result.err)[1]
        late.seconds = 1.2
        assert takt(*read, advised).out == "0 7\n"
