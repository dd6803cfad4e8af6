"""Errors are reported on the right stream, with the right exit code: interrupted clients, full disks,
time-outs, invalid options."""
import contextlib
import json
import pathlib
import re
import signal
import socket
import subprocess

import pytest

import endpoints
import program
from fake_slave import TcpSlave, tcp_answer
from peer_base import TcpPeer
from program import DEADLINE, TAKT, environment, start, takt, until
from projects import at, tcp

INT = "type: int16, read: 0x03"
FULL = pathlib.Path("/dev/full")

# --- output that cannot be written


@pytest.mark.parametrize("arguments", [
    ["check", "PROJECT"],
    ["plan", "PROJECT"],
    ["plan", "PROJECT", "--json"],
    ["convert", "PROJECT", "--to", "csv"],
    ["run", "PROJECT", "--for", "1s"],
    ["run", "PROJECT", "--for", "1s", "--json"],
    ["demo", "--for", "1s"],
    ["read", "TARGET", "holding", 0],
    ["raw", "TARGET", "03 00 00 00 01"],
    ["scan", "TARGET", "--units", "1", "--json"],
    ["probe", "TARGET", "--to", 3, "--json"],
    ["read", "TARGET", "holding", 0, "--watch", "10ms", "--for", "10s"],
    ["--help"],
    ["run", "--help"],
    ["--version"],
], ids=lambda a: "-".join(map(str, a)))
def test_a_full_disk(project, blank_device, arguments):
    port = blank_device()
    names = {"PROJECT": project(tcp(at([0], INT), port)), "TARGET": f"tcp://127.0.0.1:{port}"}
    with FULL.open("wb") as full:
        done = subprocess.run([TAKT, *(str(names.get(a, a)) for a in arguments)], stdout=full,
                              stderr=subprocess.PIPE, env=environment(), timeout=DEADLINE, check=False)
    assert done.returncode == 3, done.stderr.decode()
    assert "stdout: " in done.stderr.decode() and "no space left" in done.stderr.decode()


def test_a_full_disk_for_frames(blank_device):
    result = takt("read", f"tcp://127.0.0.1:{blank_device()}", "holding", 0, "--traffic", FULL, code=3)
    assert "/dev/full: " in result.err and result.out == "0 0\n"


def test_a_reader_that_has_enough_is_no_failure(project, blank_device):
    path = project(tcp(at([0], INT), blank_device()))
    with subprocess.Popen([TAKT, "run", str(path), "--json"], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                          env=environment()) as run:
        while b'"good"' not in run.stdout.readline(
        ):  # the value never changes: this is all there is to print
            pass
        run.stdout.close()
        assert run.wait(DEADLINE) == 0
        assert run.stderr.read() == b""


# --- ctl


@contextlib.contextmanager
def silent_socket(path):
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(str(path))
        listener.listen()
        yield listener


@pytest.mark.parametrize("with_signal", [signal.SIGINT, signal.SIGTERM], ids=["ctrl-c", "terminate"])
def test_ctl_is_interrupted_while_it_waits(tmp_path, with_signal):
    with silent_socket(tmp_path / "s") as listener, start("ctl", tmp_path / "s", "set", "A", "5") as ctl:
        peer, _ = listener.accept()
        assert peer.recv(100) == b"--lang en set A 5\n"
        result = ctl.interrupt(with_signal, code=4)
        assert "set A 5" in result.err and result.out == ""
        peer.close()


@pytest.mark.parametrize("command", [[""], ["  "]])
def test_ctl_without_a_command_waits_for_nothing(tmp_path, command):
    with silent_socket(tmp_path / "s"):
        assert "no command given" in takt("ctl", tmp_path / "s", *command, code=2).err


def test_ctl_of_something_else(tmp_path):
    (tmp_path / "file").write_text("")
    for path in (tmp_path, tmp_path / "file"):
        result = takt("ctl", path, "get", "A", code=3)
        assert "not a socket" in result.err and "--control" in result.err
    with silent_socket(tmp_path / "left"):
        pass
    assert "takt run" in takt("ctl", tmp_path / "left", "get", "A", code=3).err


@pytest.fixture
def run(project, blank_device, tmp_path):
    path = project(
        tcp(["name: Late, register: 0, type: int16, write: 0x06", "name: V, register: 1, " + INT],
            blank_device(), local=["name: count, type: int"]))
    with start("run", path, "--control", tmp_path / "control", "--json") as running:
        running.control = tmp_path / "control"
        until(running.control.exists, "the socket")
        yield running


def connected(path):
    client = socket.socket(socket.AF_UNIX)
    client.settimeout(30)
    until(lambda: client.connect_ex(str(path)) == 0, "the control socket")
    return client


def test_the_client_that_was_idle_longest_makes_room(run):
    with contextlib.ExitStack() as stack:
        clients = [stack.enter_context(connected(run.control)) for _ in range(16)]
        for client in clients[1:]:
            client.sendall(b"set count 1\n")
            assert client.recv(100) == b"ok count 1\n"
        assert takt("ctl", run.control, "get", "count").out == "ok count 1\n"
        assert clients[0].recv(1000).startswith(b"error idle ") and clients[0].recv(1) == b""
        clients[15].sendall(b"get count\n")
        assert clients[15].recv(100) == b"ok count 1\n", "the others are still there"
        run.interrupt()


def test_a_connection_beyond_the_limit_gets_error_busy(project, tmp_path):
    with TcpSlave() as slave:
        path = project(
            tcp(["name: Late, register: 0, type: int16, write: 0x06"], slave.port, response_timeout="60s"))
        with start("run", path, "--control", tmp_path / "c",
                   "--json") as running, contextlib.ExitStack() as stack:
            clients = [stack.enter_context(connected(tmp_path / "c")) for _ in range(16)]
            for client in clients:
                client.sendall(b"write Late 1\n")
            until(
                lambda: takt("ctl", tmp_path / "c", "get", "Late", code=None).out.startswith("error busy 16 "
                                                                                             ), "the refusal")
            running.interrupt()


# --- read, write, raw


def test_a_time_out_is_json_too():
    with TcpSlave() as slave:
        target = f"tcp://127.0.0.1:{slave.port}"
        for arguments, key, value in ((("read", target, "holding", 5), "values",
                                       []), (("write", target, "holding", 5, 1), "outcome", "unknown"),
                                      (("raw", target, "03 00 00 00 01"), "request", "03 00 00 00 01")):
            result = takt(*arguments, "--timeout", "100ms", "--json", code=4)
            assert result.json["error"]["code"] == "timed_out" and result.json["error"]["text"] in result.err
            assert (result.json["target"], result.json["unit"], result.json[key]) == (target, 1, value)


def test_a_refusal_is_json_too():
    with TcpSlave(lambda adu: tcp_answer(adu, "83 02" if adu[7] == 3 else "86 03")) as slave:
        target = f"tcp://127.0.0.1:{slave.port}"
        assert takt("read", target, "holding", 5, "--json",
                    code=5).json["error"]["code"] == "modbus_exception"
        assert takt("write", target, "holding", 5, 1, "--json", code=5).json["outcome"] == "refused"


def test_no_connection_is_json_too():
    target = f"tcp://127.0.0.1:{endpoints.free_port()}"
    assert takt("read", target, "holding", 5, "--json", code=3).json["error"]["code"] == "cannot_open"
    assert takt("write", target, "holding", 5, 1, "--json", code=3).json["outcome"] == "refused"
    assert takt("read", target, "holding", 5, "--json", "--watch", code=3).json["event"] == "error"


def test_an_interrupted_write_says_that_it_may_be_done():
    asked = []
    with TcpSlave(asked.append) as slave, start("write", f"tcp://127.0.0.1:{slave.port}", "--timeout", "60s",
                                                "--json", "holding", 0, 1) as write:
        until(lambda: asked, "the request")
        result = write.interrupt(code=4)
        assert result.json["error"]["code"] == "interrupted" and "unknown whether" in result.err


def test_the_troubles_of_a_watch_are_no_data():
    with TcpSlave() as slave:
        target = f"tcp://127.0.0.1:{slave.port}"
        command = ["read", target, "holding", 0, "--watch", "10ms", "--timeout", "50ms"]
        with start(*command) as watch:
            until(lambda: any("0x03 0..0: " in line for line in watch.err), "a trouble")
            result = watch.interrupt(code=4)
        assert result.out == "" and "–" in result.err
        with start(*command, "--json") as watch:
            watch.wait_event(lambda e: e["event"] == "sample", "a sample")
            result = watch.interrupt(code=4)
        summary = json.loads(result.lines[-1])
        assert summary["answers"] == 0 and summary["min_ms"] is None and summary["errors"] == summary[
            "samples"]


# --- a host that swallows connections


@pytest.fixture
def swallower():
    with endpoints.swallowing_host() as port:
        yield f"tcp://127.0.0.1:{port}"


@pytest.mark.parametrize("command",
                         [["scan"], ["probe"], ["read", "holding", 0], ["read", "holding", 0, "--watch"]],
                         ids=lambda c: "-".join(map(str, c)))
def test_no_connection_is_no_silent_device(swallower, command):
    result = takt(command[0], swallower, "--timeout", "200ms", *command[1:], code=3)
    assert "cannot be opened: no answer in time" in result.err and "firewall" in result.err
    assert "wiring" not in result.err


def test_interrupted_before_there_is_a_connection(swallower):
    with start("write", swallower, "--timeout", "60s", "holding", 0, 1) as write:
        until(lambda: write.catches(signal.SIGINT), "a handler")
        assert "interrupted before the connection was made" in write.interrupt(code=4).err


# --- words


class Greeter(TcpPeer):
    """A server that is not Modbus: it greets each connection."""

    def __init__(self, greeting):
        self._greeting, self._peers = greeting, []
        super().__init__()

    def _connected(self, peer):
        self._peers.append(peer)
        peer.sendall(self._greeting)


@pytest.mark.parametrize(
    "command", [["read", "holding", 0], ["read", "holding", 0, "--watch", "100ms", "--for", "1s"], ["probe"]],
    ids=lambda c: "-".join(map(str, c))[:24])
def test_a_peer_that_is_not_modbus(command):
    with Greeter(b"SSH-2.0-OpenSSH_9.2\r\n") as peer:
        result = takt(command[0], f"tcp://127.0.0.1:{peer.port}", *command[1:], "--timeout", "20s", code=6)
        message = " ".join(result.err.split())
        assert f"127.0.0.1:{peer.port}: the peer does not speak Modbus TCP: " \
            "received 53 53 48 2D 32 2E 30 2D (SSH-2.0-)" in message
        assert "Check the host and the port" in message


def test_a_project_with_a_peer_that_is_not_modbus(project):
    with Greeter(b"220 mail ready\r\n") as peer:
        with start("run", project(tcp(at([0], INT), peer.port)), "--json") as run:
            down = lambda: [e for e in run.events() if e["event"] == "link" and not e["up"]]
            until(lambda: len(down()) >= 4, "four attempts")
            run.interrupt()
        assert all("received 32 32 30 20 6D 61 69 6C (220 mail)" in link["text"] for link in down())
        times = [link["time_ms"] for link in down()]
        pauses = [b - a for a, b in zip(times, times[1:4])]
        assert all(pause >= 0.74 * wanted for pause, wanted in zip(pauses, (250, 500, 1000))), \
            "0.25 s, 0.5 s, 1 s, each up to a quarter less"


@pytest.mark.parametrize("arguments, words", [
    (["demo", "--for", "-1ms"], "--for: -1ms is out of range, allowed: 0s..8784h"),
    (["demo", "--for", "10"
      ], "--for: '10' is not a duration, allowed: a number with its unit, as in 500ms, 10s"),
    (["read", "tcp://host:99999", "holding", 0
      ], "TARGET tcp://host:99999: port: the value 99999 is out of range, allowed: 1..65535"),
    (["scan", "tcp://10.0.0.5-1"
      ], "TARGET tcp://10.0.0.5-1: '10.0.0.5-1' is not valid, correct form: 10.0.0.5-254"),
    (["scan", "tcp://10.0.0.0/99"], "correct form: 10.0.0.0/24"),
    (["scan", "tcp://127.0.0.1", "--bauds", "9600x"
      ], "'--bauds 9600x' is not valid, correct form: 9600,19200"),
    (["scan", "tcp://127.0.0.1", "--units", "a"], "correct form: 1-10,16"),
    (["read", "tcp://127.0.0.1:1", "holding", 0, "--watch", "abc"], "--watch: 'abc' is not a duration"),
    (["read", "tcp://127.0.0.1:1", "--watch", "abc", "holding", 0], "--watch: 'abc' is not a duration"),
    (["read", "tcp://127.0.0.1:1", "holding", 0, "many"
      ], "COUNT: 'many' is not a whole number, allowed: 1..65536"),
    (["read", "tcp://127.0.0.1:1", "holding", "abc"
      ], "START: 'abc' is not a whole number, allowed: 0..65535"),
    (["write", "tcp://127.0.0.1:1", "holding", "010", "1"
      ], "START: '010' has a leading zero; decimal numbers have none, and hexadecimal numbers begin with 0x"),
    (["read", "tcp://127.0.0.1:1", "holding", 65536], "START: 65536 is out of range, allowed: 0..65535"),
    (["raw", "tcp://127.0.0.1:1", "zz"], "Write pairs of hexadecimal digits, as in 03 00 00 00 02"),
    (["read", "10.0.0.5:502", "holding", 0], "correct form: tcp://10.0.0.5:502"),
    (["serve", "--listen", "127.0.0.1:80x"
      ], "--listen: '127.0.0.1:80x' is not valid, correct form: 127.0.0.1:1502"),
    (["serve", "--listen", "127.0.0.1:99999"], "--listen: '127.0.0.1:99999' is not valid"),
    (["serve", "--listen", "plc:502"], "ports: 0..65535"),
    (["serve", "--listen", "127.0.0.1:0", "--fault", "exception=300"], "exception=1..255"),
    (["serve", "--listen", "127.0.0.1:1", "--listen", "127.0.0.1:2"
      ], "--listen: given 2 times (127.0.0.1:1, 127.0.0.1:2), allowed: once"),
], ids=lambda a: "-".join(map(str, a)) if isinstance(a, list) else "")
def test_errors_suggest_the_right_word(arguments, words):
    assert words in takt(*arguments, code=2).err


@pytest.mark.parametrize("language, words", [("ru", "недопустимая запись, правильно"),
                                             ("uk", "недопустимий запис, правильно")])
def test_in_other_languages(language, words):
    assert words in takt("--lang", language, "scan", "tcp://10.0.0.5-1", code=2).err


@pytest.mark.parametrize("arguments", [
    ["read", "tcp://127.0.0.1:1", "holding", 0, "--order", 9999],
    ["read", "tcp://127.0.0.1:1", "holding", "abc"],
    ["read", "tcp://127.0.0.1:1", "holding", 0, "--watch", "--also", "x"],
    ["read", "--unit"],
    ["run"],
    ["serve", "--fault", "unknown"],
    ["serve", "--listen", "127.0.0.1:99999"],
    ["serve", "--max-connections", 0],
    ["plan", "a.yaml", "b.yaml"],
    ["probe", "tcp://127.0.0.1:1", "--area", "x"],
    ["convert", "a.csv", "--encoding", "x"],
    ["table", "build", "a.yaml", "-o", "b", "--profile", "x"],
    [],
    ["table"],
    ["serve", "--listen", "127.0.0.1:1", "--listen", "127.0.0.1:2"],
], ids=lambda a: "-".join(map(str, a))[:40])
@pytest.mark.parametrize("language, letters", [("ru", "[а-яё]"), ("uk", "[а-яіїєґ]")])
def test_rejected_options_are_in_the_language(arguments, language, letters):
    error = takt("--lang", language, *arguments, code=2).err
    message = next(line for line in error.splitlines() if line.startswith("takt: "))
    assert re.search(letters, message), message
    assert not re.search(r"\b(is|not|allowed|each|longer|missing)\b", message), message


@pytest.mark.parametrize("arguments, command", [([], "demo"), (["table"], "build"),
                                                (["--lang", "en"], "probe")], ids=lambda a: "-".join(a)
                         if isinstance(a, list) else "")
def test_a_missing_command_shows_the_commands(arguments, command):
    result = takt(*arguments, code=2)
    assert re.search(rf"(?m)^  {command} +\S",
                     result.err) and result.err.endswith("takt: a command is missing\n")
    assert result.out == ""


def test_no_sentence_has_two_stops(project, blank_device):
    path = project(tcp(at([0], INT + ", retain: true"), blank_device()))
    result = takt("run", path, "--state", "/nowhere/plant.state", "--for", "100ms")
    assert "/nowhere" in result.err and ".." not in result.err


FIRST = program.ROOT / "examples/first.yaml"


@pytest.mark.parametrize("language, words", [("en", "is simulated"), ("ru", "имитируется"),
                                             ("uk", "імітується")])
def test_serve_names_the_way_to_reach_a_simulated_line(language, words):
    """The message contains the command that works."""
    result = takt("--lang", language, "serve", FIRST, code=2)
    assert f"{FIRST}:4:" in result.err and words in result.err and "rs485-1" in result.err, result
    assert "--port /dev/ttyUSB0" in result.err and result.out == ""
    command = re.search(r"`takt (serve [^`]+ --listen) 127\.0\.0\.1:1502`", result.err)[1]
    port = endpoints.free_port()
    with start(*command.split(), f"127.0.0.1:{port}") as served:
        endpoints.wait_listening(port, served)
        served.interrupt()


def test_serve_names_the_simulated_line_of_several(project):
    line = ("  - {{name: {name}, transport: simulated, devices: [{{name: D{name}, address: 1, variables: "
            "[{{name: V{name}, type: int, register: 0, read: 3}}]}}]}}\n")
    path = project("takt: 1\nlines:\n" + "".join(line.format(name=name) for name in ("a", "b")))
    assert f"`takt serve {path} --line a --listen 127.0.0.1:1502`" in takt("serve", path, code=2).err
    assert f"`takt serve {path} --line b --listen 127.0.0.1:1502`" in takt("serve", path, "--line", "b",
                                                                           code=2).err
    takt("serve", path, "--line", "b", "--listen", "127.0.0.1:0", "--for", "50ms")


@pytest.mark.parametrize("options", [[], [FIRST]], ids=["blank", "project"])
def test_serve_on_a_port_that_is_no_serial_port(options):
    result = takt("serve", *options, "--port", "tcp://127.0.0.1:1502", code=2)
    assert "--port tcp://127.0.0.1:1502: not a serial port" in result.err and "--listen" in result.err, result
