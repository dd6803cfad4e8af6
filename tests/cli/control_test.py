"""The commands of a running project: `run --stdin`, `run --control PATH` and `takt ctl`."""
import contextlib
import json
import socket
import stat

import pytest

import endpoints
from program import DEADLINE, start, takt, until
from projects import tcp

READ, WRITTEN = "type: int16, read: 0x03", "type: int16, read: 0x03, write: 0x10, write_on_change: true"
VARIABLES = [
    "name: Level, register: 0, " + READ,
    "name: Wanted, register: 1, " + WRITTEN,
    "name: Ordered, register: 2, " + READ + ", write: 0x06",
    "name: Scaled, register: 20, scale: 0.1, " + READ + ", write: 0x06",
    "name: Ratio, register: 4, type: float, read: 0x03, write: 0x10",
    "name: Lamp, type: bool, register: 0, bit: 5, read: 0x01, write: 0x05",
    "name: Beyond, register: 9, type: int16, read: 0x03, read_trigger: go, period: 1h",
]
LOCALS = ["name: go, type: bool", "name: count, type: int"]


@contextlib.contextmanager
def running_in(folder, port):
    """A project that runs against a blank device, with every way in open; `target` is the device."""
    path = folder / "project.yaml"
    path.write_text(tcp(VARIABLES, port, local=LOCALS))
    with start("run", path, "--stdin", "--control", folder / "control") as running:
        running.target, running.control = f"tcp://127.0.0.1:{port}", folder / "control"
        yield running


@pytest.fixture
def run(blank_device, tmp_path):
    with running_in(tmp_path, blank_device()) as running:
        yield running


@pytest.fixture(scope="module")
def lasting(shared_device, tmp_path_factory):
    """The same run for all tests that leave it as it was, but for the value of `count` and of registers."""
    with running_in(tmp_path_factory.mktemp("lasting"), shared_device()) as running:
        yield running
        running.interrupt()


ANSWERS = ("ok", "error", "done", "refused", "unknown", "expired")


def answer(run, command):
    """The answer to a command on the standard input; changes of values are lines of another kind."""
    before = len(run.out)
    run.send(command)
    return run.wait_line(lambda line: line.split(" ")[0] in ANSWERS, f"an answer to {command!r}",
                         after=before)


def held(run, area, address, *more):
    return takt("read", run.target, area, address, *more, "--json").json["values"][0]


def test_get(lasting):
    run = lasting
    until(lambda: answer(run, "get Level") == "ok Level 0", "the value of the device")


def test_set_a_local(lasting):
    run = lasting
    assert answer(run, "set count 42") == "ok count 42"
    assert answer(run, "get count") == "ok count 42"
    assert answer(run, "set go true").startswith("ok go ")


def test_set_of_a_variable_written_on_change(lasting):
    run = lasting
    assert answer(run, "set Wanted -7").startswith("ok Wanted -7")
    until(lambda: held(run, "holding", 1, "--type", "int16") == -7, "the value in the device")
    until(lambda: answer(run, "get Wanted") == "ok Wanted -7", "the value read back")


@pytest.mark.parametrize("name, value, area, address, kind, expected", [
    ("Ordered", "1234", "holding", 2, "int16", 1234),
    ("Ordered", "-1", "holding", 2, "int16", -1),
    ("Ratio", "2.5", "holding", 4, "float", 2.5),
])
def test_write(lasting, name, value, area, address, kind, expected):
    assert "done" in answer(lasting, f"write {name} {value}")
    assert held(lasting, area, address, "--type", kind) == expected


def test_rounding_is_said(lasting):
    run = lasting
    assert answer(run, "write Scaled 1.26") == "done Scaled rounded"
    assert held(run, "holding", 20, "--type", "int16") == 13
    assert answer(run, "write Scaled 1.2") == "done Scaled"
    assert held(run, "holding", 20, "--type", "int16") == 12
    assert answer(run, "write Scaled 4000").startswith("error overflow ")


def test_write_a_coil(lasting):
    run = lasting
    assert "done" in answer(run, "write Lamp 1")
    assert held(run, "coils", 5) in (1, True)
    assert "done" in answer(run, "write Lamp false")
    assert held(run, "coils", 5) in (0, False)


@pytest.mark.parametrize("command", [
    "frobnicate",
    "get",
    "get Nobody",
    "set",
    "set Level",
    "set Nobody 1",
    "set count many",
    "set count 70000",
    "set count 1.5",
    "set go 2",
    "set count 1 2",
    "write Nobody 1",
    "write Ordered",
    "write Ordered 99999",
    "write Level 1",
    "write Ratio warm",
    "GET count",
    "get count\x00",
    "set count \u00df",
    "quit now please",
    "set count -32769",
], ids=lambda c: c.replace(" ", "-").replace("\x00", "NUL"))
def test_bad_commands(lasting, command):
    said = answer(lasting, command).split(" ", 2)
    assert said[0] == "error" and len(said) == 3, "a code and a text"
    assert answer(lasting, "set count 3") == "ok count 3", "and it goes on"


def test_an_empty_line_is_no_command(lasting):
    lasting.send("")
    lasting.send("   ")
    assert answer(lasting, "set count 1") == "ok count 1"


def test_a_megabyte_without_a_line_end(run):
    run.process.stdin.write(b"x" * 1_000_000)
    run.process.stdin.flush()
    run.wait_line(lambda line: line.startswith("error "), "the refusal")
    run.send("")
    assert answer(run, "get count") == "ok count 0"


def test_many_commands_at_once(run):
    run.process.stdin.write(b"".join(b"set count %d\n" % i for i in range(1000)))
    run.process.stdin.flush()
    run.wait_line(lambda line: line == "ok count 999", "the last answer")
    said = [line for line in run.out if line.startswith("ok count")]
    assert said == [f"ok count {i}" for i in range(1000)]


def test_quit(run):
    run.send("quit")
    run.finish()


def test_the_end_of_the_input_does_not_crash(run):
    run.send("set count 1")
    run.process.stdin.close()
    run.wait_line(lambda line: line == "ok count 1", "the answer")
    if run.process.poll() is None:
        run.interrupt(code=None)


def test_json_answers(project, blank_device):
    path = project(tcp(VARIABLES, blank_device(), local=LOCALS))
    with start("run", path, "--stdin", "--json") as running:
        running.send("write Ordered 5")
        outcome = running.wait_event(lambda e: e["event"] == "outcome", "an outcome")
        assert (outcome["command"], outcome["name"], outcome["outcome"]) == ("write", "Ordered", "done")
        value = running.wait_event(
            lambda e: e["event"] == "value" and e["name"] == "Ordered" and e["value"] == 5,
            "the value as an event")
        assert set(value) >= {
            "event", "time_ms", "line", "device", "name", "value", "quality", "reason", "age_ms"
        }
        assert (value["line"], value["device"], value["quality"]) == ("net", "Node1", "good")
        running.send("frobnicate")
        running.wait_line(
            lambda line: "error" in json.loads(line) or json.loads(line).get("event") == "error",
            "the error as an object")
        running.send("quit")
        running.finish()


def test_a_write_that_cannot_be_done(project, blank_device):
    """Register 65535 and the one beyond it: the device answers exception 2."""
    path = project(
        tcp([
            "name: Edge, type: float, register: 65534, read: 0x03, write: 0x10",
            "name: Dead, type: int16, register: 0, read: 0x03, write: 0x06"
        ], blank_device(unit=1), address=2))
    with start("run", path, "--stdin", "--json") as running:
        running.send("write Dead 1")
        outcome = running.wait_event(lambda e: e["event"] == "outcome", "an outcome")
        assert outcome["outcome"] in ("refused", "unknown", "expired") and outcome["reason"]
        running.interrupt()


def test_a_write_to_a_host_that_is_not_there_expires(project):
    with start(
            "run",
            project(
                tcp(["name: Ordered, type: int16, register: 0, read: 0x03, write: 0x06"],
                    endpoints.free_port())), "--stdin", "--json") as running:
        running.send("write Ordered 1")
        outcome = running.wait_event(lambda e: e["event"] == "outcome", "an outcome")
        assert outcome["outcome"] == "expired"
        running.interrupt()


# --- the socket


def connection(path):
    """A connection to the control socket, once it is there and listens."""
    client = socket.socket(socket.AF_UNIX)
    client.settimeout(DEADLINE)
    until(lambda: client.connect_ex(str(path)) == 0, "the control socket")
    return client


def test_ctl(run):
    connection(run.control).close()
    assert takt("ctl", run.control, "set", "count", 9).out == "ok count 9\n"
    assert takt("ctl", run.control, "get", "count").out == "ok count 9\n"
    unsent = takt("ctl", run.control, "set", "Ordered", 5).out
    assert unsent.startswith("ok Ordered 5 not_written: nothing is sent") and "`write Ordered`" in unsent
    assert takt("ctl", run.control, "get", "Nobody", code=1).out.startswith("error")
    assert "done" in takt("ctl", run.control, "write", "Ordered", 77).out
    assert held(run, "holding", 2) == 77


def test_the_socket_is_the_owner_s(run):
    until(run.control.exists, "the socket")
    mode = run.control.stat().st_mode
    assert stat.S_ISSOCK(mode) and not mode & 0o077


def test_the_socket_goes_with_the_run(run):
    connection(run.control).close()
    assert takt("ctl", run.control, "quit").code == 0
    run.finish()
    assert not run.control.exists()
    takt("ctl", run.control, "get", "count", code=3)


def test_two_clients_and_a_rude_one(run):
    clients = [connection(run.control) for _ in range(3)]
    clients[0].sendall(b"set count 5\n")
    assert clients[0].recv(100) == b"ok count 5\n"
    clients[1].sendall(b"get cou")
    clients[2].sendall(b"y" * 100_000)
    clients[2].close()
    clients[0].sendall(b"get count\n")
    assert clients[0].recv(100) == b"ok count 5\n"
    clients[1].sendall(b"nt\n")
    assert clients[1].recv(100) == b"ok count 5\n"
    run.interrupt()


def test_a_path_that_is_taken(project, blank_device, tmp_path):
    path = project(tcp(VARIABLES, blank_device(), local=LOCALS))
    taken = tmp_path / "file"
    taken.write_text("precious")
    result = takt("run", path, "--control", taken, "--for", "1s", code=None)
    assert result.code in (2, 3) and taken.read_text() == "precious"


def test_a_path_that_is_too_long(project, blank_device, tmp_path):
    path = project(tcp(VARIABLES, blank_device(), local=LOCALS))
    long = tmp_path / ("x" * 120)
    for arguments in (["run", path, "--control", long, "--for", "1s"], ["ctl", long, "get", "count"]):
        assert "xxx" in takt(*arguments, code=3).err


def test_the_end_leaves_the_socket_of_another_run(project, tmp_path):
    path = project(tcp(VARIABLES, 1, local=LOCALS))
    control = tmp_path / "control"
    with start("run", path, "--control", control) as first:
        until(control.exists, "the first socket")
        control.unlink()
        with start("run", path, "--control", control) as second:
            until(control.exists, "the second socket")
            first.interrupt()
            assert takt("ctl", control, "get", "count").out.startswith("ok count")
            second.interrupt()
        assert not control.exists()
