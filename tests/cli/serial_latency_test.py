"""run and serve report whether a serial port hands on bytes at once."""
import json
import os
import pathlib
import pty
import subprocess
import termios
import tty

import pytest

from program import start, until

SOURCE = pathlib.Path(__file__).parent.parent / "support" / "uart_driver.cpp"
DONE = "{port}: low latency: done"
FAILED = "{port}: low latency: not done ({why})"
DRIVERS = [("accepts", DONE, ""), ("ignores", FAILED, "Operation not supported"),
           ("refuses", FAILED, "Operation not permitted"),
           ("lacks", FAILED, "Inappropriate ioctl for device")]
PROJECT = """takt: 1
lines:
  - name: field
    transport: serial
    port: {port}
    baud: 19200
    devices: [{{name: Pump, address: 1, poll_period: 50ms, variables: [
      {{name: level, type: int, register: 0, read: 0x03}}]}}]
"""


@pytest.fixture(scope="module")
def driver(tmp_path_factory):
    library = tmp_path_factory.mktemp("uart") / "uart_driver.so"
    subprocess.run(["clang++-19", "-std=c++20", "-O1", "-shared", "-fPIC", "-o", library, SOURCE], check=True)
    return lambda kind: {
        "LD_PRELOAD": str(library),
        "TAKT_UART": kind,
        "ASAN_OPTIONS": "verify_asan_link_order=0"
    }


@pytest.fixture
def port():
    master, slave = pty.openpty()
    tty.setraw(slave)
    yield os.ttyname(slave)
    os.close(master)
    os.close(slave)


@pytest.fixture
def plant(tmp_path, port):
    path = tmp_path / "plant.yaml"
    path.write_text(PROJECT.format(port=port))
    return path


@pytest.mark.parametrize("kind, text, why", DRIVERS)
def test_the_result_is_reported(driver, plant, port, kind, text, why):
    expected = text.format(port=port, why=why)
    with start("run", plant, "--quiet", env=driver(kind)) as run:
        until(lambda: any(expected in line for line in run.err), "the report")
        assert run.interrupt().err.count(expected) == 1
    with start("run", plant, "--json", env=driver(kind)) as run:
        event = run.wait_event(lambda e: "low_latency" in json.dumps(e), "the notice")
        run.interrupt()
    assert event["event"] == "notice" and event["severity"] == "status" and event["text"].startswith(expected)
    with start("serve", "--port", port, env=driver(kind)) as serve:
        until(lambda: any(expected in line for line in serve.err), "the report")
        assert serve.interrupt().err.count("low latency") == 1


def echo_of(port):
    fd = os.open(port, os.O_RDWR | os.O_NOCTTY)
    try:
        return bool(termios.tcgetattr(fd)[3] & termios.ECHO)
    finally:
        os.close(fd)


def test_the_echo_of_a_real_port_stays_off(driver, plant, port):
    """The kernel would send what it receives between this program and the next one."""
    fd = os.open(port, os.O_RDWR | os.O_NOCTTY)
    settings = termios.tcgetattr(fd)
    settings[3] |= termios.ECHO
    termios.tcsetattr(fd, termios.TCSANOW, settings)
    os.close(fd)
    for more, stays in (({}, True), (driver("accepts"), False)):
        with start("run", plant, "--json", env=more) as run:
            run.wait_event(lambda e: e["event"] == "link" and e["up"], "the open port")
            run.interrupt()
        assert echo_of(port) == stays


def test_serve_reports_a_lost_port_and_its_return(tmp_path):
    port = tmp_path / "port"
    master, slave = pty.openpty()
    port.symlink_to(os.ttyname(slave))
    with start("serve", "--port", port) as serve:
        until(lambda: any("serving rtu" in line for line in serve.err), "the begin")
        os.close(slave)
        os.close(master)
        until(lambda: any("opened again" in line for line in serve.err), "the loss")
        port.unlink()
        master, slave = pty.openpty()
        port.symlink_to(os.ttyname(slave))
        until(lambda: f"serving {port} again" in serve.err, "the return")
        result = serve.interrupt()
    assert result.err.count("opened again") == 1 and result.err.count(str(port)) <= 4, result
    os.close(master)
    os.close(slave)


def test_a_pseudo_terminal_has_no_such_step(plant):
    with start("run", plant, "--json") as run:
        run.wait_event(lambda e: e["event"] == "link" and e["up"], "the open port")
        result = run.interrupt()
    assert "low_latency" not in result.out and "low latency" not in result.err
