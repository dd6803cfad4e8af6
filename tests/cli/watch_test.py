"""`takt read --watch`, writes in several requests, and messages about invalid options."""
import json

import pytest

import endpoints
from fake_slave import TcpSlave, tcp_answer
from program import start, takt, until


def samples(result):
    return [e for e in map(json.loads, result.lines) if e["event"] == "sample"]


def test_samples_as_json(blank_device):
    port = blank_device("ramp")
    with start("read", f"tcp://127.0.0.1:{port}", "holding", 10, 3, "--watch", "20ms", "--json") as running:
        until(lambda: sum(e["event"] == "sample" for e in running.events()) >= 2, "two samples")
        result = running.interrupt()
    taken = samples(result)
    for sample in taken:
        assert [(v["area"], v["address"], v["value"]) for v in sample["values"]] == \
            [("holding", 10, 10), ("holding", 11, 11), ("holding", 12, 12)]
    summary = json.loads(result.lines[-1])
    assert summary["event"] == "summary" and summary["errors"] == 0
    assert summary["samples"] == summary["answers"] == len(taken), "one request for the three"


def test_ranges_are_read_in_the_requests_of_the_planner(blank_device):
    port = blank_device("ramp")
    result = takt("read", f"tcp://127.0.0.1:{port}", "holding", 0, 5, "--also", "holding:5:5", "--also",
                  "coils:1:3", "--watch", "50ms", "--for", "20ms", "--json")
    sample = samples(result)[0]
    assert [v["value"] for v in sample["values"]] == [*range(10), True, False, True]
    assert json.loads(
        result.lines[-1])["answers"] == 2 * len(samples(result)), "one for the registers, one for the coils"


def test_changes_alone(blank_device):
    port = blank_device()
    target = f"tcp://127.0.0.1:{port}"
    with start("read", target, "holding", 0, 2, "--watch", "10ms", "--changes") as running:
        running.wait_line(lambda line: line.endswith("holding 1 = 0"), "the first values")
        takt("write", target, "holding", 1, 77)
        running.wait_line(lambda line: line.endswith("holding 1 = 77"), "the change")
        result = running.interrupt()
    assert len(result.lines) == 3


def test_without_an_interval_it_is_a_second(blank_device):
    with start("read", f"tcp://127.0.0.1:{blank_device()}", "--watch", "holding", 0) as running:
        running.wait_line(lambda line: line.endswith("holding 0 = 0"), "a value")
        running.interrupt()


def test_time_outs_and_lost_connections_are_survived():
    mute = [False]
    with TcpSlave(lambda adu: None if mute[0] else tcp_answer(adu, "03 02 00 05")) as slave:
        with start("read", f"tcp://127.0.0.1:{slave.port}", "holding", 0, "--watch", "20ms", "--timeout",
                   "100ms") as running:
            running.wait_line(lambda line: line.endswith("= 5"), "a value")
            mute[0] = True
            until(lambda: any("0x03 0..0: " in line for line in running.err), "the time-out")
            mute[0] = False
            seen = len(running.out)
            running.wait_line(lambda line: line.endswith("= 5"), "a value again", after=seen)
            running.interrupt()


def test_the_server_comes_back():
    port = endpoints.free_port()
    serve = ("serve", "--listen", f"127.0.0.1:{port}", "--unit", 1)
    with start(*serve) as device:
        endpoints.wait_listening(port, device)
        with start("read", f"tcp://127.0.0.1:{port}", "holding", 0, "--watch", "20ms") as running:
            running.wait_line(lambda line: line.endswith("= 0"), "a value")
            device.interrupt()
            until(lambda: any("0x03 0..0: " in line for line in running.err), "the loss")
            with start(*serve) as again:
                endpoints.wait_listening(port, again)
                seen = len(running.out)
                running.wait_line(lambda line: line.endswith("= 0"), "a value again", after=seen)
                again.interrupt()
            running.interrupt()


def test_nothing_ever_answered():
    with TcpSlave() as slave:
        takt("read", f"tcp://127.0.0.1:{slave.port}", "holding", 0, "--watch", "10ms", "--for", "1s",
             "--timeout", "50ms", code=4)


def test_a_long_write_goes_in_several_requests(blank_device):
    target = f"tcp://127.0.0.1:{blank_device()}"
    done = takt("write", target, "holding", 5, *range(300), "--json").json
    assert (done["outcome"], done["quantity"]) == ("done", 300)
    assert takt("read", target, "holding", 5, 300, "--json").json["values"] == list(range(300))
    takt("write", target, "holding", 0, "--type", "double", *[0.5] * 70)
    assert takt("read", target, "holding", 0, 70, "--type", "double", "--json").json["values"] == [0.5] * 70
    takt("write", target, "coils", 3, *[1] * 2100)
    assert takt("read", target, "coils", 3, 2100, "--json").json["values"] == [True] * 2100


def test_a_long_write_that_ends_half_way():

    def answer(adu):
        start = int.from_bytes(adu[8:10], "big")
        return tcp_answer(adu, "10 0000 007B" if start == 0 else "90 02")

    with TcpSlave(answer) as slave:
        target = f"tcp://127.0.0.1:{slave.port}"
        result = takt("write", target, "holding", 0, *range(200), code=7)
        assert "123" in result.err and "200" in result.err
        summary = takt("write", target, "holding", 0, *range(200), "--json", code=7).json
        assert (summary["outcome"], summary["quantity"], summary["wanted"]) == ("partly", 123, 200)


@pytest.mark.parametrize("arguments", [
    ["read", "tcp://127.0.0.1:1", "coils", "0", "--type", "int16"],
    ["write", "tcp://127.0.0.1:1", "coils", "0", "1", "--type", "int16"],
    ["read", "tcp://127.0.0.1:1", "holding", "0", "--watch", "0ms"],
    ["read", "tcp://127.0.0.1:1", "holding", "0", "--changes"],
    ["read", "tcp://127.0.0.1:1", "holding", "0", "--watch", "--also", "shoes:1"],
    ["read", "tcp://127.0.0.1:1", "holding", "0", "--watch", "--also", "holding"],
    ["read", "tcp://127.0.0.1:1", "holding", "0", "9999", "--watch"],
    ["write", "tcp://127.0.0.1:1", "holding", "65535", "1", "2"],
], ids=" ".join)
def test_bad_usage(arguments):
    result = takt(*arguments, code=2)
    assert result.out == "" and result.err.strip()


@pytest.mark.parametrize("language,words", [("en", "allowed"), ("ru", "допустимо"), ("uk", "допустимо")])
def test_invalid_options_are_reported_in_the_users_language(language, words):
    for wrong in (["--unit", "256"], ["--type", "colour"]):
        result = takt("--lang", language, "read", "tcp://127.0.0.1:1", "holding", "0", *wrong, code=2)
        assert words in result.err and wrong[0] in result.err and wrong[1] in result.err


def test_every_wrong_option_has_words():
    for arguments in (["read"], ["check", "--frobnicate",
                                 "x"], ["read", "tcp://127.0.0.1:1", "holding",
                                        "zero"], ["demo", "--for", "soon"], ["demo", "--lang", "tlh"], []):
        english = takt(*arguments, code=2).err
        other = takt(*arguments, code=2, LC_ALL="ru_RU.UTF-8").err
        assert english != other and any("а" <= c <= "я" for c in other), (arguments, english, other)
