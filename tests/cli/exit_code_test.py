"""Exit codes (docs/commands/README.md): one for each kind of end. stdout has data, stderr has messages."""
import contextlib
import socket
import subprocess

import pytest

import endpoints
from fake_slave import SerialSlave, TcpSlave, tcp_answer
from frames import request
from program import DEADLINE, TAKT, environment, start, takt
from projects import at, serial, tcp

BROKEN = serial(at([70000], "type: int16, read: 0x03"))


def refused(result):
    """A refusal gives the reason on stderr and leaves stdout to data."""
    assert result.out == "", repr(result)
    assert result.err.strip(), repr(result)
    return result


# --- 0


@pytest.mark.parametrize(
    "command", [[], ["check"], ["plan"], ["run"], ["serve"], ["read"], ["write"], ["raw"], ["demo"]],
    ids=lambda c: c[0] if c else "takt")
def test_help(command):
    assert takt(*command, "--help").out


def test_a_good_project(project):
    path = project(serial(at(range(0, 20, 2), "type: float, read: 0x03"), turnaround="5ms"))
    takt("check", path)
    assert takt("check", path, "--json").json["findings"] == []
    takt("plan", path)


def test_a_project_with_warnings(project):
    path = project(serial(at([0], "type: int16, read: 0x03"), address=250, turnaround="5ms"))
    findings = takt("check", path, "--json").json["findings"]
    assert [f["severity"] for f in findings] == ["warning"]


# --- 1


def test_a_project_with_errors(project):
    assert "70000" in takt("check", project(BROKEN), code=1).out


# --- 2


@pytest.mark.parametrize("language, words", [("en", "a running takt"), ("ru", "работающему takt"),
                                             ("uk", "takt, що працює")])
def test_a_command_of_ctl_is_named_as_such(language, words):
    result = refused(takt("values", "plant.yaml", "--lang", language, code=2))
    assert words in result.err and "takt ctl PATH values" in result.err
    assert "demo, run" in refused(takt("fnord", code=2)).err


def test_what_was_meant_is_named():
    assert "the nearest known one is `check`" in refused(takt("ckeck", code=2)).err
    for options in ["--lang", "en"], ["--log=x", "--lang=en"]:
        assert "the nearest known one is `read`" in refused(takt(*options, "raed", code=2)).err
        assert takt(*options, "help", "check").out == takt("check", "--help").out
    assert "the nearest known one is `build`" in refused(takt("table", "biuld", "p.yaml", code=2)).err
    assert "takt run --new FILE" in refused(takt("new", code=2)).err
    assert takt("help", "check").out == takt("check", "--help").out
    assert takt("help").out == takt("--help").out
    assert "`--type int16`" in takt("write", "tcp://127.0.0.1:1", "holding", 3, -5, code=2).err


def test_a_new_project_is_created_once(tmp_path):
    path = tmp_path / "plant.yaml"
    assert f"takt run --new {path}" in takt("run", path, code=2).err
    takt("run", "--new", path, "--for", "100ms")
    empty = takt("check", path, "--json").json["findings"][0]
    assert empty["code"] == "lines.none"
    assert f"`takt run {path} --web 127.0.0.1:8080 --allow-write`" in empty["advice"]
    # The page of the run, not another one.
    note = takt("run", path, "--web", "127.0.0.1:0", "--allow-write", "--for", "100ms").err
    assert f"`takt run {path} --web 127.0.0.1:0 --allow-write`" in note
    before = path.read_bytes()
    assert "exists already" in takt("run", "--new", path, code=2).err
    assert path.read_bytes() == before


def test_a_new_project_whose_start_fails_leaves_no_file(tmp_path):
    path = tmp_path / "plant.yaml"
    with socket.create_server(("127.0.0.1", 0)) as taken:
        address = f"127.0.0.1:{taken.getsockname()[1]}"
        assert takt("run", "--new", path, "--web", address, code=None).code != 0
    assert not path.exists()


def test_an_unknown_option_is_named_with_the_nearest_one():
    assert "`--forr`" in (err := refused(takt("run", "plant.yaml", "--forr", "3s",
                                              code=2)).err) and "`--for`" in err
    for place in ["--lagn", "ru", "check", "plant.yaml"], ["check", "plant.yaml", "--lagn"], ["--lagn"]:
        assert "`--lang`" in refused(takt(*place, code=2)).err


@pytest.mark.parametrize("command", [["run", "--for", "1s"], ["serve", "--for", "1s"]], ids=lambda c: c[0])
def test_a_project_with_errors_is_not_run(project, command):
    result = refused(takt(command[0], project(BROKEN), *command[1:], code=2))
    assert "70000" in result.err


@pytest.mark.parametrize("arguments", [
    [],
    ["frobnicate"],
    ["check"],
    ["plan"],
    ["run"],
    ["read"],
    ["read", "tcp://127.0.0.1:1"],
    ["check", "--frobnicate", "x.yaml"],
    ["demo", "--for", "soon"],
    ["demo", "--for", "-1s"],
    ["demo", "--lang", "tlh"],
    ["read", "tcp://127.0.0.1:1", "shoes", "0"],
    ["read", "127.0.0.1:1", "holding", "0"],
    ["read", "gopher://127.0.0.1", "holding", "0"],
    ["read", "tcp://127.0.0.1:99999", "holding", "0"],
    ["read", "tcp://", "holding", "0"],
    ["read", "tcp://[::1:502", "holding", "0"],
    ["read", "rtu:///dev/ttyS0?baud=fast", "holding", "0"],
    ["read", "rtu:///dev/ttyS0?parity=maybe", "holding", "0"],
    ["read", "rtu:///dev/ttyS0?color=red", "holding", "0"],
    ["read", "tcp://127.0.0.1:1", "holding", "65536"],
    ["read", "tcp://127.0.0.1:1", "holding", "-1"],
    ["read", "tcp://127.0.0.1:1", "holding", "zero"],
    ["read", "tcp://127.0.0.1:1", "holding", "65535", "2"],
    ["read", "tcp://127.0.0.1:1", "holding", "0", "0"],
    ["read", "tcp://127.0.0.1:1", "--unit", "256", "holding", "0"],
    ["read", "tcp://127.0.0.1:1", "holding", "0", "--type", "colour"],
    ["read", "tcp://127.0.0.1:1", "holding", "0", "--order", "1111"],
    ["read", "tcp://127.0.0.1:1", "holding", "0", "--timeout", "never"],
    ["demo", "--for", "01s"],
    ["demo", "--for", "1.5.5s"],
    ["write", "tcp://127.0.0.1:1", "holding", "0"],
    ["write", "tcp://127.0.0.1:1", "input", "0", "1"],
    ["write", "tcp://127.0.0.1:1", "holding", "0", "65536"],
    ["write", "tcp://127.0.0.1:1", "holding", "0", "1.5"],
    ["write", "tcp://127.0.0.1:1", "coils", "0", "2"],
    ["write", "tcp://127.0.0.1:1", "discrete", "0", "1"],
    ["raw", "tcp://127.0.0.1:1"],
    ["raw", "tcp://127.0.0.1:1", "0"],
    ["raw", "tcp://127.0.0.1:1", "xy"],
    ["raw", "tcp://127.0.0.1:1", "03 " * 254],
    ["serve"],
    ["serve", "--listen", "nowhere"],
    ["serve", "--listen", "127.0.0.1:1502", "--fill", "sand"],
], ids=lambda a: " ".join(a)[:60].replace("/", "|") or "nothing")
def test_bad_usage(arguments):
    refused(takt(*arguments, code=2))


def test_a_broadcast_cannot_be_read(pair):
    refused(takt("read", f"rtu://{pair.a}", "--unit", 0, "holding", 0, code=2))
    assert pair.sent() == b""


# --- 3


def test_connection_refused():
    refused(takt("read", f"tcp://127.0.0.1:{endpoints.free_port()}", "holding", 0, code=3))


def test_unknown_host():
    refused(takt("read", "tcp://no-such-host.invalid", "holding", 0, code=3))


@pytest.mark.parametrize("endpoint", ["/dev/takt-test-no-such-port", "/dev/null", "/etc"])
def test_no_such_serial_port(endpoint):
    for framing in ("rtu", "ascii"):
        result = refused(takt("read", f"{framing}://{endpoint}", "holding", 0, code=3))
        assert endpoint in result.err


def test_a_serial_port_in_use(pair):
    with start("serve", "--port", f"rtu://{pair.b}", "--unit", 1) as device:
        endpoints.wait_slave(pair.a, 1, process=device)
        refused(takt("read", f"rtu://{pair.b}", "holding", 0, code=3))
        device.interrupt()


def test_a_tcp_port_in_use(blank_device):
    port = blank_device()
    refused(takt("serve", "--listen", f"127.0.0.1:{port}", "--unit", 1, code=3))


def test_serving_an_address_that_is_not_ours():
    refused(takt("serve", "--listen", "192.0.2.1:1502", "--unit", 1, code=3))


@pytest.mark.parametrize("language,word", [("en", "connections"), ("ru", "соединений"), ("uk", "з'єднань")])
def test_more_lines_than_descriptors(tmp_path, language, word):
    file = tmp_path / "many.yaml"
    file.write_text("takt: 1\nlines:\n" +
                    "".join(f"- {{name: L{n}, transport: tcp, framing: tcp, host: 127.0.0.1, tcp_port: 1, "
                            f"devices: [{{name: D{n}, address: 1}}]}}\n" for n in range(50)))
    run = subprocess.run(
        ["sh", "-c", 'ulimit -n 90 && exec "$0" run "$1" --for 1s --lang "$2"', TAKT, file, language],
        capture_output=True, env=environment(), timeout=DEADLINE, check=False)
    message = run.stderr.decode()
    assert run.returncode == 3, message
    assert "114" in message and "90" in message and word in message


# --- 4


def test_a_silent_host():
    with TcpSlave() as slave:
        refused(takt("read", f"tcp://127.0.0.1:{slave.port}", "--timeout", "100ms", "holding", 0, code=4))


@pytest.mark.parametrize("framing", ["rtu", "ascii"])
def test_a_silent_line(pair, framing):
    refused(takt("read", f"{framing}://{pair.a}", "--timeout", "100ms", "holding", 0, code=4))


def test_each_attempt_is_made(pair):
    takt("read", f"rtu://{pair.a}", "--timeout", "50ms", "--attempts", 3, "holding", 0, code=4)
    assert pair.sent() == request("rtu", 1, "03 00 00 00 01") * 3


# --- 5


@pytest.mark.parametrize("code", [1, 2, 3, 4, 5, 6, 8, 10, 11, 0x7F, 0xFF])
def test_an_exception(code):
    with TcpSlave(lambda adu: tcp_answer(adu, f"83 {code:02X}")) as slave:
        result = refused(takt("read", f"tcp://127.0.0.1:{slave.port}", "holding", 0, code=5))
    assert str(code) in result.err or f"{code:02X}" in result.err


def test_an_exception_of_a_blank_device(blank_device):
    result = takt("raw", f"tcp://127.0.0.1:{blank_device()}", "03 FF FF 00 02", code=5)
    assert result.out == "83 02\n", "the response is what was asked for"


# --- 6


@contextlib.contextmanager
def serial_slave(pair, answer):
    with SerialSlave(pair.b, answer):
        yield f"rtu://{pair.a}"


GOOD = request("rtu", 1, "03 02 00 07")


@pytest.mark.parametrize("answer", [
    GOOD[:-1] + bytes([GOOD[-1] ^ 1]),
    GOOD[:-1],
    b"\xA5" * 40,
    request("rtu", 1, "03 04 00 07 00 08"),
], ids=["checksum", "cut", "noise", "wrong-byte-count"])
def test_a_bad_frame_on_a_serial_line(pair, answer):
    with serial_slave(pair, lambda _: answer) as target:
        refused(takt("read", target, "--timeout", "3s", "holding", 0, code=6))


@pytest.mark.parametrize("answer", [
    lambda adu: tcp_answer(adu, "03 02 00 07", protocol=1),
    lambda adu: tcp_answer(adu, "03 04 00 07 00 08"),
    lambda adu: b"HTTP/1.1 400 Bad Request\r\n\r\n",
], ids=["protocol", "wrong-byte-count", "http"])
def test_a_bad_frame_over_tcp(answer):
    with TcpSlave(answer) as slave:
        refused(takt("read", f"tcp://127.0.0.1:{slave.port}", "--timeout", "3s", "holding", 0, code=6))


def test_an_answer_to_another_request_is_not_taken():
    """Another transaction is not ours: waiting goes on to the deadline."""
    with TcpSlave(lambda adu: tcp_answer(adu, "03 02 00 07", transaction=0xBEEF)) as slave:
        result = refused(
            takt("read", f"tcp://127.0.0.1:{slave.port}", "--timeout", "300ms", "holding", 0, code=None))
    assert result.code in (4, 6)


# --- 7


def test_partly_done():
    """200 registers need two requests; the device has only the first 125."""

    def answer(adu):
        first = adu[8:10] == b"\0\0"
        return tcp_answer(adu, "03 FA" + " 00 09" * 125 if first else "83 02")

    with TcpSlave(answer) as slave:
        result = takt("read", f"tcp://127.0.0.1:{slave.port}", "holding", 0, 200, code=7)
    assert len(result.lines) == 125, "what was read is printed"
    assert result.err.strip()


def test_run_lives_on_without_its_device(project):
    """A device that is not there is no failure of `run`: it reports that and continues."""
    path = project(tcp(at([0], "type: int16, read: 0x03"), endpoints.free_port()))
    result = takt("run", path, "--for", "500ms", "--json")
    assert result.lines
