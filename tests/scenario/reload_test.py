"""SIGHUP: a running project is replaced by its changed file (docs/commands/run.md, "SIGHUP")."""
import os
import signal
import subprocess
import time

import pytest

import endpoints
from fake_slave import TcpSlave, tcp_answer
from program import DEADLINE, TAKT, environment, start, takt, until
from projects import tcp

A = "name: A, register: 0, type: int16, read: 0x03, period: 50ms"
B = "name: B, register: 0, type: int16, read: 0x04, period: 50ms"


class Counting(TcpSlave):
    """Answers each read of one register with 7 and counts its connections."""

    def __init__(self):
        self.connections = 0
        super().__init__(lambda adu: tcp_answer(adu, f"{adu[7]:02x} 02 00 07"))

    def _connected(self, peer):
        self.connections += 1
        super()._connected(peer)


def good(name):
    return lambda e: e["event"] == "value" and e["name"] == name and e["quality"] == "good"


def reload(run, said):
    before = len(run.err)
    run.process.send_signal(signal.SIGHUP)
    until(lambda: any(said in line for line in run.err[before:]), f"{said}\n{run!r}")


def test_a_changed_project_keeps_its_connection(project, tmp_path):
    log = tmp_path / "takt.log"
    with Counting() as slave:
        path = project(tcp([A], slave.port))
        with start("run", path, "--json", "--stdin", "--log", log) as run:
            run.wait_event(good("A"), "the value of the first project")
            path.write_text(tcp([A, B + ", write_on_change: true"], slave.port))
            reload(run, "in force")
            until(lambda: "`write_on_change` has no effect" in log.read_text(), "its warning in the log")
            run.wait_event(good("B"), "the value of the second project")
            assert slave.connections == 1
            run.send("get A")
            assert run.wait_event(lambda e: e["event"] == "answer", "A is still there")["value"] == "7"
            run.interrupt()


def test_a_broken_file_changes_nothing(project):
    with Counting() as slave:
        path = project(tcp([A], slave.port))
        with start("run", path, "--json", "--stdin") as run:
            run.wait_event(good("A"), "a value")
            path.write_text(tcp([A, "name: C, registr: 1"], slave.port))
            reload(run, "runs on as it was")
            assert any("registr" in line for line in run.err), "the mistake is reported"
            path.unlink()
            reload(run, "runs on as it was")
            run.send("get A")
            assert run.wait_event(lambda e: e["event"] == "answer", "it runs on")["value"] == "7"
            assert slave.connections == 1
            run.interrupt()


def hold_a_signal():
    """The signal waits from before the start until the program accepts it."""
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGHUP})
    os.kill(os.getpid(), signal.SIGHUP)


def test_a_signal_before_the_run_has_begun_is_a_reload_too(project):
    with Counting() as slave:
        path = project(tcp([A], slave.port))
        with start("run", path, "--json", preexec_fn=hold_a_signal) as run:
            until(lambda: any("in force" in line for line in run.err), "the project is read again")
            run.wait_event(good("A"), "a value")
            run.interrupt()


def test_signals_while_the_program_starts(project):
    """Each comes a little later after the start of the program. The first moments, before the program's own
    code runs, are left out."""
    path = project(tcp([A], endpoints.free_port()))
    for delay in range(30):
        with start("run", path, "--json", "--quiet") as run:
            until(lambda r=run: r.holds(signal.SIGHUP) or r.catches(signal.SIGHUP), "the program has begun")
            time.sleep(delay / 1000)
            run.process.send_signal(signal.SIGHUP)
            until(lambda r=run: any("in force" in line for line in r.err), "the project is read again")
            run.interrupt()


def test_a_closed_terminal_ends_the_program(project):
    """The kernel sends SIGHUP to the programs of a terminal that is closed."""
    controller, terminal = os.openpty()
    with Counting() as slave:
        path = project(tcp([A], slave.port))
        run = subprocess.Popen([TAKT, "run", str(path)], stdin=terminal, stdout=terminal, stderr=terminal,
                               env=environment(), start_new_session=True)
        os.close(terminal)
        until(lambda: slave.connections, "it runs")
        os.close(controller)
        run.send_signal(signal.SIGHUP)  # it has no controlling terminal
        run.wait(DEADLINE)


def test_serving_without_rules_goes_on():
    port = endpoints.free_port()
    with start("serve", "--listen", f"127.0.0.1:{port}") as device:
        endpoints.wait_listening(port, device)
        reload(device, "serving goes on")
        takt("read", f"tcp://127.0.0.1:{port}", "holding", 0, 1)
        device.interrupt()


@pytest.mark.parametrize("options,said", [(["--no-web"], "it goes on"), ([], "in force")],
                         ids=["without_file", "with_copy"])
def test_a_demonstration_goes_on(options, said):
    with start("demo", "--json", *options) as run:
        run.wait_event(lambda e: e["event"] == "value", "a value")
        reload(run, said)
        seen = len(run.out)
        run.wait_event(lambda e: e["event"] == "value", "a later value", after=seen)
        run.interrupt()
