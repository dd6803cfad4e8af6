"""Ctrl-C ends every command cleanly, from any state, with the summary it would have printed."""
import fcntl
import json
import os
import pty
import select
import signal
import socket
import struct
import subprocess
import termios

import pytest

import endpoints
from fake_slave import SerialSlave, TcpSlave
from program import DEADLINE, TAKT, WITHOUT_WAITING, Running, environment, start, takt, until
from projects import at, serial, tcp

INT = "type: int16, read: 0x03"


def end(running, with_signal=signal.SIGINT):
    return running.interrupt(with_signal, deadline=WITHOUT_WAITING)


@pytest.mark.parametrize("with_signal", [signal.SIGINT, signal.SIGTERM], ids=["ctrl-c", "terminate"])
def test_demo(with_signal):
    with start("demo", "--json") as demo:
        demo.wait_event(lambda e: e["event"] == "value", "a value")
        end(demo, with_signal)
        assert demo.events()[-1]["event"] == "summary"


def test_demo_at_its_very_start():
    """Before anything is printed: the signal may even come before the program can take it."""
    with start("demo") as demo:
        demo.process.send_signal(signal.SIGINT)
        demo.process.wait(WITHOUT_WAITING)
        assert demo.process.returncode in (0, -signal.SIGINT)


def ignore_ctrl_c():
    """As a shell without job control starts a background job."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_IGN)


def long_running(command, project, pair, folder):
    """Arguments of a command that runs until it is ended."""
    port = f"rtu://{pair.a}?baud=115200"
    return {
        # A reload waits for the request in flight, and a stop for the reload.
        "run": ["run", project(serial(at([0], INT), port=pair.a, response_timeout="1s")), "--json"],
        "demo": ["demo", "--json"],
        "serve": ["serve", "--port", port, "--unit", 1],
        "listen": ["listen", port],
        "capture": ["capture", port, "-o", folder / "line.pcapng"],
        "capture-interface": ["capture", "--interface", "lo", "-o", folder / "lo.pcapng"],
        "latency": ["latency", "-"],
        "latency-interface": ["latency", "--interface", "lo"],
        "latency-target": ["latency", port, "--timeout", "60s", "--for", "1h"],
        "read": ["read", port, "holding", 0, "--timeout", "60s"],
        "watch": ["read", port, "holding", 0, "--timeout", "60s", "--watch", "1s"],
        "scan": ["scan", port, "--timeout", "60s"],
        "probe": ["probe", port, "--unit", 1, "--timeout", "60s"],
    }[command]


@pytest.mark.parametrize("with_signal", [signal.SIGINT, signal.SIGTERM], ids=["ctrl-c", "terminate"])
@pytest.mark.parametrize("command", [
    "run", "demo", "serve", "listen", "capture", "capture-interface", "latency", "latency-interface",
    "latency-target", "read", "watch", "scan", "probe"
])
def test_signals_that_were_ignored_at_the_start(project, pair, tmp_path, command, with_signal):
    arguments = long_running(command, project, pair, tmp_path)
    with start(*arguments, preexec_fn=ignore_ctrl_c) as running:
        until(lambda: running.catches(with_signal) or running.process.poll() is not None,
              "its signal handler")
        if any("CAP_NET_RAW" in text for text in running.err):
            pytest.skip("needs CAP_NET_RAW")
        running.interrupt(with_signal, code=None)


def full_pipe():
    """Both ends; a write to it waits."""
    reading, writing = os.pipe()
    fcntl.fcntl(writing, 1031, 4096)  # F_SETPIPE_SZ
    os.set_blocking(writing, False)
    with pytest.raises(BlockingIOError):
        while True:
            os.write(writing, b"x" * 512)
    os.set_blocking(writing, True)
    return reading, writing


def has(pid, kind, number):
    """Whether the signal is in that set of the process: SigCgt (it has a handler) or SigIgn (ignored)."""
    with open(f"/proc/{pid}/status", encoding="ascii") as lines:
        mask = next(line for line in lines if line.startswith(kind)).split()[1]
    return int(mask, 16) >> (number - 1) & 1


def test_a_background_job_of_a_script():
    """`takt demo &` in a shell without job control, which ignores SIGINT in the job."""
    with Running(["sh", "-c", '"$0" demo --json & echo "$!"; wait "$!"', TAKT]) as shell:
        job = int(shell.wait_line(str.isdigit, "the number of the process"))
        shell.wait_line(lambda line: '"event":"value"' in line, "a value")
        os.kill(job, signal.SIGINT)
        assert '"event":"summary"' in shell.finish().lines[-1]


def test_a_command_without_a_handler_of_its_own():
    """It waits for the reader of its output, and the signal ends it."""
    reading, writing = full_pipe()
    schema = subprocess.Popen([TAKT, "schema"], stdout=writing, preexec_fn=ignore_ctrl_c, env=environment())
    try:
        until(lambda: not has(schema.pid, "SigIgn", signal.SIGINT), "the default action")
        assert schema.poll() is None
        schema.send_signal(signal.SIGINT)
        assert schema.wait(30) == -signal.SIGINT
    finally:
        schema.kill()
        schema.wait()
        os.close(reading)
        os.close(writing)


@pytest.mark.parametrize("command", ["run", "capture-interface", "latency"])
def test_a_hang_up_that_was_ignored_at_the_start(project, pair, tmp_path, command):
    """nohup: closing the terminal does not end the command, Ctrl-C does."""
    arguments = long_running(command, project, pair, tmp_path)
    with start(*arguments, preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_IGN)) as running:
        until(lambda: running.catches(signal.SIGINT) or running.process.poll() is not None,
              "its signal handler")
        if any("CAP_NET_RAW" in text for text in running.err):
            pytest.skip("needs CAP_NET_RAW")
        running.process.send_signal(signal.SIGHUP)
        with pytest.raises(subprocess.TimeoutExpired):
            running.process.wait(0.3)
        running.interrupt(code=None)


def test_demo_on_a_terminal():
    """In place while it runs; at a typed Ctrl-C the summary, and the terminal as it was."""
    terminal, inner = pty.openpty()
    fcntl.ioctl(inner, termios.TIOCSWINSZ, struct.pack("HHHH", 24, 80, 0, 0))
    before = termios.tcgetattr(inner)
    process = subprocess.Popen([TAKT, "demo"], stdin=inner, stdout=inner, stderr=inner,
                               env=environment(TERM="xterm"), start_new_session=True,
                               preexec_fn=lambda: fcntl.ioctl(0, termios.TIOCSCTTY, 0))
    shown = b""

    def show():
        nonlocal shown
        while select.select([terminal], [], [], 0)[0]:
            shown += os.read(terminal, 65536)

    def drawn():
        show()
        return shown.count(b"Supply temperature") > 5

    try:
        until(drawn, "values on the terminal")
        os.write(terminal, b"\x03")
        until(lambda: show() or process.poll() is not None, "the end", WITHOUT_WAITING)
        show()
        assert process.returncode == 0
        assert b"\x1b[" in shown and b"cycle planned" in shown
        assert shown.count(b"\x1b[?25l") == shown.count(b"\x1b[?25h"), "the cursor is there again"
        assert termios.tcgetattr(inner) == before
    finally:
        process.kill()
        process.wait()
        os.close(terminal)
        os.close(inner)


def test_run_connected(project, blank_device):
    path = project(tcp(at([0], INT), blank_device()))
    with start("run", path, "--json") as run:
        run.wait_event(lambda e: e["event"] == "value" and e["quality"] == "good", "a good value")
        end(run)
        assert run.events()[-1]["event"] == "summary"


def test_run_unconnected(project):
    path = project(tcp(at([0], INT), endpoints.free_port()))
    with start("run", path, "--json") as run:
        run.wait_line(bool, "any line")
        end(run)
        assert run.events()[-1]["event"] == "summary"


def test_run_while_a_host_swallows_the_connection(project):
    with endpoints.swallowing_host() as port:
        path = project(tcp(at([0], INT), port))
        with start("run", path, "--json", "--stdin") as run:
            run.send("get V1")  # answered: the signal is taken from here on
            run.wait_line(bool, "any line")
            end(run)


def test_run_with_a_dead_device(project, pair):
    path = project(serial(at([0], INT), port=pair.a, response_timeout="60s"))
    with start("run", path, "--json") as run:
        until(pair.sent, "the first request")
        end(run)
        assert run.events()[-1]["event"] == "summary"


@pytest.mark.parametrize("with_signal", [signal.SIGINT, signal.SIGTERM], ids=["ctrl-c", "terminate"])
def test_serve(with_signal):
    port = endpoints.free_port()
    with start("serve", "--listen", f"127.0.0.1:{port}", "--unit", 1) as device:
        endpoints.wait_listening(port, device)
        end(device, with_signal)


def test_serve_with_clients():
    port = endpoints.free_port()
    with start("serve", "--listen", f"127.0.0.1:{port}", "--unit", 1) as device:
        endpoints.wait_listening(port, device)
        with start("read", f"tcp://127.0.0.1:{port}", "holding", 0) as reader:
            reader.finish()
        idle = [socket.create_connection(("127.0.0.1", port)) for _ in range(5)]
        idle[0].sendall(b"\0\1\0\0\0")  # half a header
        end(device)
        for s in idle:
            s.close()


def test_serve_on_a_serial_line(pair):
    with start("serve", "--port", f"rtu://{pair.b}", "--unit", 1) as device:
        endpoints.wait_slave(pair.a, 1, process=device)
        end(device)


def test_read_from_a_silent_host():
    with TcpSlave() as slave, start("read", f"tcp://127.0.0.1:{slave.port}", "--timeout", "60s", "holding",
                                    0) as read:
        until(lambda: len(slave._threads) > 1, "the connection")
        read.process.send_signal(signal.SIGINT)
        read.finish(code=None, deadline=WITHOUT_WAITING)


def test_read_from_a_silent_line(pair):
    with start("read", f"rtu://{pair.a}", "--timeout", "60s", "holding", 0) as read:
        until(pair.sent, "the request")
        read.process.send_signal(signal.SIGINT)
        read.finish(code=None, deadline=WITHOUT_WAITING)


def settings(path):
    line = os.open(path, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
    try:
        return termios.tcgetattr(line)
    finally:
        os.close(line)


@pytest.mark.parametrize("command", ["run", "read", "serve"])
def test_the_port_s_settings_are_restored(project, pair, command):
    port = pair.b if command == "serve" else pair.a
    line = os.open(port, os.O_RDWR | os.O_NOCTTY)
    before = termios.tcgetattr(line)
    before[3] |= termios.ECHOK  # something a serial program would not leave
    before[4] = before[5] = termios.B4800
    termios.tcsetattr(line, termios.TCSANOW, before)
    before = termios.tcgetattr(line)
    commands = {
        # A reload waits for the request in flight, and a stop for the reload.
        "run": ["run", project(serial(at([0], INT), port=pair.a, response_timeout="1s")), "--json"],
        "read": ["read", f"rtu://{pair.a}", "--timeout", "60s", "holding", 0],
        "serve": ["serve", "--port", f"rtu://{pair.b}?baud=9600", "--unit", 1]
    }
    with start(*commands[command]) as running:
        if command == "serve":
            endpoints.wait_slave(pair.a, 1, process=running)
        else:
            until(pair.sent, "the first request")
        assert termios.tcgetattr(line) != before, "its own settings while it runs"
        running.process.send_signal(signal.SIGINT)
        running.finish(code=None, deadline=WITHOUT_WAITING)
    assert termios.tcgetattr(line) == before
    os.close(line)


def test_the_port_is_free_again(project, pair):
    path = project(serial(at([0], INT), port=pair.a))
    with start("run", path, "--json") as run:
        until(pair.sent, "the first request")
        end(run)
    with SerialSlave(pair.b, lambda frame: bytes.fromhex("01 03 02 00 07 F9 86")):
        takt("read", f"rtu://{pair.a}", "holding", 0)


def test_a_port_that_vanishes(project, tmp_path):
    """The adapter is pulled out: run reports it, keeps trying, and still ends at Ctrl-C."""
    with endpoints.serial_pair(tmp_path) as pair:
        path = project(serial(at([0], INT), port=pair.a, response_timeout="200ms"))
        run = start("run", path, "--json")
        run.__enter__()
        until(pair.sent, "the first request")
    try:
        run.wait_line(bool, "any line")
        end(run)
    finally:
        run.__exit__(None, None, None)


@pytest.mark.parametrize("arguments", [["demo", "--for", "2s"], ["demo", "--for", "2s", "--json"]],
                         ids=["demo", "demo-json"])
def test_a_reader_that_goes_away(arguments):
    """`takt demo | head -1`"""
    process = subprocess.Popen([TAKT, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                               env=environment())
    assert process.stdout.readline()
    process.stdout.close()
    err = process.stderr.read().decode()
    assert process.wait(DEADLINE) in (0, 1, -signal.SIGPIPE), err
    assert "Sanitizer" not in err and "terminate called" not in err


def test_a_reader_that_is_gone_from_the_start(project):
    path = project(serial(at(range(500), INT), registers_per_request=2))
    for arguments in (["plan", path], ["plan", path, "--json"], ["check", path], ["--help"]):
        reader, writer = os.pipe()
        os.close(reader)
        done = subprocess.run([TAKT, *map(str, arguments)], stdout=writer, stderr=subprocess.PIPE,
                              env=environment(), timeout=DEADLINE, check=False)
        os.close(writer)
        assert "Sanitizer" not in done.stderr.decode() and "terminate called" not in done.stderr.decode()
        assert done.returncode in (0, 1, -signal.SIGPIPE)


def test_a_full_disk(project):
    """stdout that takes nothing is an error, not silence."""
    path = project(serial(at([0], INT)))
    with open("/dev/full", "w") as full:
        done = subprocess.run([TAKT, "plan", str(path), "--json"], stdout=full, stderr=subprocess.PIPE,
                              timeout=DEADLINE, env=environment(), check=False)
    assert done.returncode > 0 and done.stderr


def test_the_summary_is_json_to_the_last_line(project, blank_device):
    path = project(tcp(at([0], INT), blank_device()))
    result = takt("run", path, "--for", "500ms", "--json")
    events = [json.loads(line) for line in result.lines]
    assert [e["event"] for e in events].count("summary") == 1 and events[-1]["event"] == "summary"


@pytest.mark.parametrize("arguments", [["run", "--json", "--for", "1s"], ["run", "--for", "1s"]],
                         ids=["json", "text"])
def test_a_reader_that_stalls_at_the_end(project, arguments):
    """The end of a run waits for its reader, but a signal ends that."""
    path = project(
        "takt: 1\nlines:\n  - name: l\n    transport: simulated\n    devices:\n      - {name: d, address: 1, "
        "poll_period: 10ms, variables: [{name: v, type: int, register: 0, read: 0x03}]}\n")
    reading, writing = full_pipe()
    process = subprocess.Popen([TAKT, arguments[0], path, *arguments[1:]], stdin=subprocess.DEVNULL,
                               stdout=writing, stderr=writing, env=environment())
    os.close(writing)
    try:
        with pytest.raises(subprocess.TimeoutExpired):
            process.wait(2.5)
        process.send_signal(signal.SIGTERM)
        process.wait(WITHOUT_WAITING)
        assert process.returncode in (0, -signal.SIGTERM)
    finally:
        process.kill()
        os.close(reading)
