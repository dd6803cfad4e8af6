"""takt latency TARGET: figures, checks of the responses, exit codes and the end by a signal."""
import csv
import io
import itertools
import signal
import time
import xml.etree.ElementTree as xml

import pytest

import endpoints
from fake_slave import SerialSlave, TcpSlave, rtu_answers, tcp_answer
from program import start, takt, until

# Only what the server holds back is late, also on a busy machine.
TIMEOUT, LATE = "1500ms", 2.0


def target(port):
    return f"tcp://127.0.0.1:{port}"


def measured(port, *options, code=0):
    return takt("latency", target(port), *options, "--json", code=code).json


def test_a_rate_is_kept_and_both_times_are_stated(blank_device):
    report = measured(blank_device("ramp"), "holding", 10, 20, "--rate", "500/s", "--requests", 500,
                      "--same-content", "--timeout", "1min", "--limit", "1min")
    total, load = report["total"], report["load"]
    assert (total["requests"], total["answered"], load["sent"], load["different"]) == (500, 500, 500, 0)
    assert (load["rate_per_s"], load["coordinated_omission"]) == (500, "avoided")
    assert (load["function"], load["start"], load["quantity"]) == (3, 10, 20)
    assert load["elapsed_ms"] >= 998, "the last request is due then"
    for percentile in ("min_ms", "p50_ms", "p99_ms", "max_ms"):
        assert load["from_sending"][percentile] <= total[percentile]
    assert abs(total["period_ms"] - 2) < 0.1
    assert report["verdict"]["kept"] and report["verdict"]["exchanges"] == 500
    assert [s["time_ms"] for s in report["slowest"]] == sorted((s["time_ms"] for s in report["slowest"]),
                                                               reverse=True)
    assert sum(b["count"] for b in report["histogram"]) == 500


def test_as_fast_as_possible_on_connections_with_requests_in_flight(blank_device):
    report = measured(blank_device(), "--connections", 3, "--in-flight", 4, "--requests", 3000)
    assert report["total"]["answered"] == report["load"]["sent"] == 3000
    assert (report["load"]["rate_per_s"], report["load"]["coordinated_omission"]) == (None, "possible")


def test_a_stalled_server_delays_every_request_that_was_due():

    def stall(adu, numbers=itertools.count()):
        if next(numbers) == 50:
            time.sleep(0.3)  # the server's own pause, not a wait of the test
        return tcp_answer(adu, "03 02 0001")

    with TcpSlave(stall) as slave:
        report = measured(slave.port, "--rate", "200/s", "--requests", 200, "--timeout", "1min", "--limit",
                          "100ms", code=1)
    assert report["total"]["answered"] == 200
    assert report["verdict"]["exceeded"] >= 35, "the requests due in the first 200 ms of the pause"
    assert report["load"]["from_sending"]["p90_ms"] < report["total"]["p90_ms"]


def test_responses_are_checked():
    answers = itertools.cycle(["03 02 0001", "03 02 0002", "83 02", "03 04 0001 0001"])
    with TcpSlave(lambda adu: tcp_answer(adu, next(answers))) as slave:
        report = measured(slave.port, "--requests", 8, "--same-content", code=1)
    assert report["total"]["exceptions"] == {"2": 2}
    assert (report["load"]["wrong"], report["load"]["different"], report["total"]["unanswered"]) == (2, 2, 2)


def test_late_exceptions_and_answers_to_nothing():

    def answer(adu, numbers=itertools.count()):
        number = next(numbers)
        if number == 3:
            time.sleep(LATE)
            return tcp_answer(adu, "83 06")
        return tcp_answer(adu, "03 02 0001", transaction=0xFFFF if number == 6 else None)

    with TcpSlave(answer) as slave:
        report = measured(slave.port, "--timeout", TIMEOUT, "--requests", 20, code=1)
    total, load = report["total"], report["load"]
    assert (total["exceptions"], total["late"]) == ({"6": 1}, 1)
    assert (load["unexpected"], total["unanswered"]) == (1, 1)


def test_late_and_unanswered_requests_and_lost_connections():

    def answer(adu, numbers=itertools.count()):
        number = next(numbers)
        if number == 3:
            time.sleep(LATE)
        if number == 6:
            return "close"
        return tcp_answer(adu, "03 02 0001")

    with TcpSlave(answer) as slave:
        report = measured(slave.port, "--timeout", TIMEOUT, "--requests", 20, "--for", "5min")
    total, load = report["total"], report["load"]
    assert (total["requests"], load["timed_out"], total["late"]) == (20, 1, 1)
    assert load["lost"] == total["unanswered"] and load["lost"] >= 1 and load["disconnections"] >= 1


def test_a_device_that_never_answers():
    with TcpSlave() as slave:
        result = takt("latency", target(slave.port), "--timeout", "50ms", "--rate", "100/s", "--for", "300ms",
                      code=4)
    assert "--unit" in result.err and "none of the connections had room" in result.out


def test_a_serial_line(pair):
    with SerialSlave(pair.b, rtu_answers({"04 0005 0002": "04 04 0001 0002"})):
        report = takt("latency", f"rtu://{pair.a}?baud=115200&parity=none", "input", 5, 2, "--requests", 10,
                      "--timeout", "20s", "--json").json
        assert report["total"]["answered"] == 10
        for option in ("--connections", "--in-flight"):
            refused = takt("latency", f"rtu://{pair.a}", option, 2, code=2)
            assert option in refused.err and "allows 1" in refused.err


def test_a_signal_ends_with_the_report(blank_device):
    port = blank_device()
    with start("latency", target(port), "--rate", "100/s", "--for", "1h", "--json") as running:
        until(lambda: any("last second" in line for line in running.err), "the progress of a second")
        result = running.interrupt(signal.SIGINT, code=7)
    total = result.json["total"]
    assert total["answered"] >= 1 and total["requests"] - total["answered"] <= 1, "what is in flight is open"


def test_forms_of_the_output(blank_device, tmp_path):
    port, svg = blank_device(), tmp_path / "a.svg"
    rows = list(
        csv.DictReader(io.StringIO(
            takt("latency", target(port), "--requests", 50, "--csv", "--svg", svg).out)))
    assert rows[-1]["answered"] == "50"
    bars = [
        int(r.get("data-count")) for r in xml.parse(svg).iter("{http://www.w3.org/2000/svg}rect")
        if r.get("data-count")
    ]
    assert sum(bars) == 50
    histogram = takt("latency", target(port), "--requests", 50, "--histogram", 5).out
    total, overflows = (int(next(x for x in histogram.splitlines() if name in x).split(":")[1])
                        for name in ("Total", "Overflows"))
    assert total + overflows == 50


@pytest.mark.parametrize("language, word", [("en", "as fast as possible"), ("ru", "с наибольшей скоростью"),
                                            ("uk", "якнайшвидше")])
def test_languages(blank_device, language, word):
    port = blank_device()
    out = takt("latency", target(port), "--requests", 5, "--limit", "1s", "--lang", language).out
    assert word in out and "app." not in out
    assert "app." not in takt("latency", target(port), "--rate", "100/s", "--requests", 5, "--lang",
                              language).out


def test_the_real_time_mode_is_reported(blank_device):
    result = takt("latency", target(blank_device()), "--requests", 5, "--realtime", "--cpu", 0, "--spin",
                  "50us")
    assert "processor 0" in result.err


@pytest.mark.parametrize("options, code, word", [(("tcp://127.0.0.1:1", ), 3, "127.0.0.1:1"),
                                                 (("udp://h", ), 2, "udp"),
                                                 (("/dev/ptmx", ), 2, "rtu:///dev/ptmx"),
                                                 (("tcp://h", "--rate", "fast"), 2, "1000/s"),
                                                 (("tcp://h", "--port", 502), 2, "--port"),
                                                 (("a.pcap", "--rate", "1/s"), 2, "--rate"),
                                                 (("tcp://h", "holding", 65530, 10), 2, "65535"),
                                                 (("tcp://h", "holding", 0, 126), 2, "125")])
def test_what_cannot_be_measured(options, code, word):
    assert word in takt("latency", *options, code=code).err


def test_the_round_trip_is_for_a_project(blank_device, project):
    text = takt("latency", target(blank_device()), "--requests", 300, "--in-flight", 4).out
    line = next(x for x in text.splitlines() if "round_trip: {" in x).split(": ", 1)[1]
    assert "exchanges: 300, in_flight: 4}" in line
    path = project(f"""takt: 1
lines: [{{name: L, transport: tcp, host: 127.0.0.1, devices: [{{name: D, address: 1, in_flight: 4,
  {line}, variables: [{{name: V, type: int, register: 0, read: 3}}]}}]}}]
""")
    planned = takt("plan", path, "--json").json
    assert (planned["lines"][0]["in_flight"], planned["lines"][0]["response_source"]) == (4, "measured")
    note = next(f for f in planned["findings"] if f["code"] == "guarantee.response_measured")
    assert "300 exchanges" in note["message"] and "1 in 100" in note["message"]
    assert "1 in 100" in takt("check", path).out + takt("check", path).err
