"""`takt ctl`: the state of a running project, its names and values, and the exit codes of `get`."""
import contextlib
import json
import re
import signal
import socket

import pytest

import endpoints
from fake_slave import TcpSlave, tcp_answer
from program import start, takt, until
from projects import serial, tcp

VARIABLES = [
    "name: Level, register: 0, type: int16, read: 0x03, unit: mm",
    "name: Ratio, register: 2, type: float, read: 0x03", "name: Order, register: 9, type: int16, write: 0x06"
]
ISO = re.compile(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{3}[+-]\d\d:\d\d$")


@contextlib.contextmanager
def running(project, tmp_path, port, variables=("name: Level, register: 0, type: int16, read: 0x03", ),
            **device):
    control = tmp_path / "control"
    path = project(tcp(list(variables), port, local=["name: go, type: bool"], **device))
    with start("run", path, "--control", control) as run:
        wait_control(control)
        yield control
        run.interrupt()


def wait_control(path):
    """Returns when the control socket accepts connections."""

    def connects():
        with socket.socket(socket.AF_UNIX) as client:
            return client.connect_ex(str(path)) == 0

    until(connects, "the control socket")


@pytest.fixture(scope="module")
def plant(shared_device, tmp_path_factory):
    """The same run for all tests; none of them changes more than the local `go`."""
    folder = tmp_path_factory.mktemp("plant")

    def project(text):
        (folder / "project.yaml").write_text(text)
        return folder / "project.yaml"

    with running(project, folder, shared_device("ramp"), VARIABLES, poll_period="1s") as control:
        until(lambda: takt("ctl", control, "get", "Ratio", code=None).code == 0, "the first values")
        yield control


def ctl_json(control, *words, code=0):
    return takt("ctl", control, *words, "--json", code=code).json


def test_status(plant):
    # A busy machine has overruns, which are over when a period was kept.
    status = until(lambda: (s := ctl_json(plant, "status"))["health"] == "ok" and s, "a line in good health")
    assert (status["event"], status["command"]) == ("answer", "status")
    assert ISO.match(status["time"]) and status["uptime_ms"] > 0
    assert status["values"] == {"good": 3, "uncertain": 0, "bad": 0, "never_read": 1}
    line = status["lines"][0]
    assert (line["name"],
            line["state"]) == ("net", "connected") and 0 <= line["load"] <= 1 and line["planned_cycle_ms"] > 0
    device = line["devices"][0]
    assert (device["name"], device["address"], device["state"], device["failed"]) == ("Node1", 1, "answering",
                                                                                      0)
    text = until(lambda: "health: ok" in (out := takt("ctl", plant, "status").out) and out, "it as text")
    assert "net: connected, load" in text and "Node1" in text


def test_list(plant):
    names = {entry["name"]: entry for entry in ctl_json(plant, "list")["names"]}
    assert list(names) == ["go", "Level", "Ratio", "Order"]
    assert names["Level"] == {
        "name": "Level",
        "line": "net",
        "device": "Node1",
        "type": "int16",
        "unit": "mm",
        "readable": True,
        "writable": False
    }
    assert all(name in takt("ctl", plant, "list").out for name in names)


def test_values(plant):
    values = ctl_json(plant, "values")
    assert ISO.match(values["time"]) and len(values["values"]) == 4
    level = next(v for v in values["values"] if v["name"] == "Level")
    assert (level["value"], level["text"], level["unit"], level["quality"], level["reason"]) == (0, "0", "mm",
                                                                                                 "good", "")
    assert level["age_ms"] >= 0
    text = takt("ctl", plant, "values", "*v*l").out
    assert re.search(r"(?m)^Node1 +Level +0 mm +[\d.]+ m?s +good$", text), text
    assert "Ratio" not in text
    assert ctl_json(plant, "values", "At", code=1)["values"] == [], "case counts"
    assert "`At`" in takt("ctl", plant, "values", "At", code=1).err
    assert [v["name"] for v in ctl_json(plant, "values", "ati")["values"]] == ["Ratio"], "a part of a name"


def test_get(plant):
    got = ctl_json(plant, "get", "Level")
    assert (got["command"], got["name"], got["value"], got["unit"], got["quality"]) == ("get", "Level", 0,
                                                                                        "mm", "good")
    assert takt("ctl", plant, "get", "Level").out == "ok Level 0\n"
    assert ctl_json(plant, "get", "Nobody", code=1)["code"] == "not_found"
    assert takt("ctl", plant, "get", "Nobody", code=1).out.startswith("error not_found ")
    assert ctl_json(plant, "set", "go", "1")["value"] == "true"


def test_the_state_on_the_standard_input(project, blank_device):
    path = project(tcp(VARIABLES, blank_device(), local=["name: go, type: bool"]))
    with start("run", path, "--stdin") as run:
        run.send("status")
        line = run.wait_line(lambda x: x.startswith("{"), "the answer")
        assert json.loads(line)["command"] == "status"
        run.send("status now")
        run.wait_line(lambda x: x.startswith("error syntax "), "the refusal")
        run.interrupt()


def test_numbers_are_as_short_as_their_type_allows(project, blank_device, tmp_path):
    """A float has at most nine significant digits, a double the digits that Python writes."""
    device = blank_device()
    takt("write", f"tcp://127.0.0.1:{device}", "holding", 2, "--type", "float", "11.661829")
    with running(project, tmp_path, device, VARIABLES) as control:
        until(lambda: takt("ctl", control, "get", "Ratio", code=None).out == "ok Ratio 11.661829\n",
              "the value")
        answers = takt("ctl", control, "get", "Ratio", "--json").out, takt("ctl", control, "status",
                                                                           "--json").out
        answers += takt("ctl", control, "values", "--json").out,
    assert '"value":11.661829,' in answers[0]
    for number in re.findall(r"(?<=[:,\[])-?\d+\.\d+(?:e[-+]?\d+)?(?=[,}\]])", "".join(answers)):
        assert repr(float(number)) == number or float(repr(
            float(number))) == float(number) and len(number) <= len(repr(float(number))), number


def test_the_socket_follows_a_reload(project, tmp_path):
    port, control = endpoints.free_port(), tmp_path / "control"
    path = project(
        tcp(["name: Before, register: 0, type: int16, read: 0x03"], port, local=["name: go, type: bool"]))
    with start("run", path, "--control", control) as run:
        wait_control(control)
        project(
            tcp(["name: After, register: 0, type: int16, read: 0x03"], port, local=["name: go, type: bool"]))
        run.process.send_signal(signal.SIGHUP)
        until(lambda: takt("ctl", control, "get", "After", code=None).code == 3, "the new project")
        assert takt("ctl", control, "set", "go", "1").out == "ok go true\n"
        assert takt("ctl", control, "get", "Before", code=1).out.startswith("error not_found Before")
        run.interrupt()


# --- exit codes of get


def until_code(control, name, code, words):
    """Waits until `get NAME` ends with that code, and checks what it prints."""
    result = until(lambda: (r := takt("ctl", control, "get", name, code=None)).code == code and r,
                   f"exit code {code}")
    assert result.out.startswith(f"ok {name}") and words in result.err, result
    assert ctl_json(control, "get", name, code=code)["quality"] != "good"
    return result


def test_never_connected(project, tmp_path):
    with running(project, tmp_path, endpoints.free_port()) as control:
        result = until_code(control, "Level", 3, "never connected")
        assert result.out == "ok Level bad never_connected\n"
        status = ctl_json(control, "status")
        assert (status["health"], status["lines"][0]["state"]) == ("failed", "never_connected")
        text = takt("ctl", control, "status").out + takt("ctl", control, "values").out
        assert "never connected" in text and "lost" not in text and "refused" in text


def test_a_lost_connection(project, tmp_path):
    with TcpSlave(lambda adu: tcp_answer(adu, "03 02 00 05")) as slave:
        with running(project, tmp_path, slave.port) as control:
            until(lambda: takt("ctl", control, "get", "Level", code=None).out == "ok Level 5\n", "a value")
            slave.__exit__()
            until_code(control, "Level", 3, "connection lost")
            assert ctl_json(control, "status")["lines"][0]["state"] == "lost"


@pytest.mark.parametrize("answer, code, words", [
    (lambda adu: None, 4, "time-out"),
    (lambda adu: tcp_answer(adu, "83 02"), 5, "exception 2"),
    (lambda adu: tcp_answer(adu, "03 04 00 07 00 08"), 6, "does not fit"),
], ids=["time-out", "exception", "bad frame"])
def test_a_bad_value(project, tmp_path, answer, code, words):
    """Also when the device counts as not answering: the cause decides."""
    with TcpSlave(answer) as slave, running(project, tmp_path, slave.port, attempts=2,
                                            response_timeout="500ms") as control:
        until_code(control, "Level", code, words)
        if code != 5:
            until(lambda: ctl_json(control, "status")["lines"][0]["devices"][0]["state"] == "not_answering",
                  "the end of the attempts")
            until_code(control, "Level", code, "not answering (")


def test_a_response_of_another_unit_on_a_serial_line(project, pair, tmp_path):
    """It is no silence: state and finding name both units and the remedy, as over TCP."""
    control = tmp_path / "control"
    path = project(serial(["register: 0, type: int16, read: 0x03"], port=pair.a, address=9, attempts=2,
                          response_timeout="500ms"))
    with start("serve", "--port", pair.b, "--unit", 9, "--fault", "wrong_unit") as slave, \
            start("run", path, "--control", control) as run:
        wait_control(control)
        until(lambda: ctl_json(control, "status")["lines"][0]["devices"][0]["state"] == "not_answering",
              "the end of the attempts")
        text = takt("ctl", control, "status").out
        assert "answers do not fit" in text
        assert "a response of unit 10 came, unit 9 was asked" in text and "Set `address: 10`" in text
        run.interrupt()
        slave.interrupt()


def test_not_read_yet(plant):
    result = takt("ctl", plant, "get", "Order", code=1)
    assert result.out == "ok Order never_read\n" and "no value yet" in result.err


@pytest.mark.parametrize("words, code, error", [
    ("fnord", 2, "syntax"),
    ("get", 2, "syntax"),
    ("set Ratio", 2, "syntax"),
    ("write Order 1,5", 2, "syntax"),
    ("write Order 99999", 1, "overflow"),
    ("get Nobody", 1, "not_found"),
    ("set Ratio 3", 1, "not_writable"),
])
def test_a_command_that_cannot_be_parsed_is_bad_usage(plant, words, code, error):
    words = words.split()
    assert takt("ctl", plant, *words, code=code).out.startswith(f"error {error} ")
    assert ctl_json(plant, *words, code=code)["code"] == error


def test_many_values(project, blank_device, tmp_path):
    """The answer is longer than a socket's buffer."""
    names = [f"name: Value_of_a_long_name_{i}, register: {i}, type: int16, read: 0x03" for i in range(5000)]
    with running(project, tmp_path, blank_device(), names) as control:
        assert len(ctl_json(control, "values")["values"]) == 5001
        assert len(takt("ctl", control, "values").lines) == 5002


@pytest.mark.parametrize("language, words", [("ru", "соединения ещё не было"),
                                             ("uk", "з'єднання ще не було")])
def test_it_speaks_its_own_language(project, tmp_path, language, words):
    with running(project, tmp_path, endpoints.free_port()) as control:
        until_code(control, "Level", 3, "never connected")
        assert words in takt("ctl", control, "status", "--lang", language).out
        assert words in takt("ctl", control, "get", "Level", "--lang", language, code=3).err
