"""docs/specification.md, section 2, retain: an acknowledged value survives every kind of end of the
program."""
import resource
import subprocess

import pytest

from fake_slave import Device, TcpSlave
from program import start, until
from projects import tcp

READ = "type: int16, read: 0x03"
LOCALS = [
    "name: limit, type: int32, retain: true, default: 5", "name: on, type: bool, retain: true, default: true",
    "name: note, type: string, retain: true", "name: lost, type: int"
]


def value_event(run, name, quality="good"):
    return lambda e: e.get("event") == "value" and e["name"] == name and e["quality"] == quality


def answer(run, command):
    before = len(run.out)
    run.send(command)
    return run.wait_event(lambda e: e["event"] in ("answer", "outcome", "error"), f"an answer to {command!r}",
                          after=before)


def get(run, name):
    return answer(run, f"get {name}").get("value")


@pytest.fixture
def slave():
    device = Device({0: 7, 1: 8})
    with TcpSlave(device.over_tcp) as server:
        server.device = device
        yield server


def test_a_set_local_survives_a_kill_right_after_its_answer(project, slave, tmp_path):
    path = project(tcp(["register: 0, " + READ], slave.port, local=LOCALS))
    last = "5"
    for number in (17, -70000, 3):
        with start("run", path, "--stdin", "--json") as run:
            assert get(run, "limit") == last
            reply = answer(run, f"set limit {number}")
            assert reply["event"] == "answer" and "retained" not in reply
            run.process.kill()
        last = str(number)
    with start("run", path, "--stdin", "--json") as run:
        for command in ("set note Füllstand, Tank 3", "set on false", "set lost 9", "quit"):
            run.send(command)
        run.finish()
        answered = [e["name"] for e in run.events() if e["event"] == "answer" and "name" in e]
        assert sorted(answered) == ["lost", "note", "on"], "who waited is answered also at the end"
    with start("run", path, "--stdin", "--json") as run:
        kept = [get(run, name) for name in ("limit", "note", "on", "lost")]
        assert kept == ["3", "Füllstand, Tank 3", "false", "0"]
        run.interrupt()
    assert (tmp_path / "project.state").exists()


def test_a_write_only_variable_starts_with_its_kept_value(project, slave):
    path = project(
        tcp(["name: SP, register: 5, type: uint16, write: 0x06, write_on_change: true, retain: true"],
            slave.port))
    last = None
    for number in (111, 222, 333):
        with start("run", path, "--stdin", "--json") as run:
            assert last is None or get(run, "SP") == last
            assert answer(run, f"set SP {number}")["event"] == "answer"
            run.process.kill()
        last = str(number)


def test_a_kept_variable_is_uncertain_until_it_is_read(project, slave):
    path = project(
        tcp(["name: V1, register: 0, retain: true, " + READ, "name: V2, register: 1, " + READ], slave.port,
            response_timeout="1s"))
    with start("run", path, "--json") as run:
        run.wait_event(value_event(run, "V1"), "a value")
        run.interrupt()
    slave.device.meddle = lambda pdu: "silence"
    with start("run", path, "--json") as run:
        first = run.wait_event(value_event(run, "V1", "uncertain"), "the kept value")
        assert first["value"] == 7 and first["age_ms"] is None
        seen = len(run.out)
        slave.device.registers[0] = 9
        slave.device.meddle = lambda pdu: None
        assert run.wait_event(value_event(run, "V1"), "the value of the device", after=seen)["value"] == 9
        run.interrupt()
        assert not any(
            value_event(run, "V2", "uncertain")(e) and e["value"] is not None and e["age_ms"] is None
            for e in run.events()), "what is not retained has no value before it was read"


def test_a_restart_is_no_change_and_the_last_value_set_still_counts(project, slave):
    variables = [
        "name: A, register: 0, type: int16, read: none, write: 0x10, write_on_change: true, retain: true",
        "name: B, register: 1, type: int16, read: none, write: 0x10, write_on_change: true, retain: true"
    ]
    path = project(tcp(variables, slave.port, local=["name: go, type: bool, retain: true"]))
    with start("run", path, "--stdin", "--json") as run:
        assert answer(run, "set A 41")["event"] == "answer"
        assert answer(run, "set B 42")["event"] == "answer"
        assert answer(run, "set go 1")["event"] == "answer"
        until(slave.device.writes, "the group is written")
        run.process.kill()
    before = len(slave.device.writes())
    with start("run", path, "--stdin", "--json") as run:
        assert get(run, "go") == "true"
        assert len(slave.device.writes()) == before
        run.send("set B 43")
        until(lambda: slave.device.writes()[before:] == ["10 00 00 00 02 04 00 29 00 2B"],
              "the group with the kept value")
        run.interrupt()


def test_a_device_that_was_switched_off_stays_so(project, slave):
    path = project(tcp(["register: 0, " + READ], slave.port, local=LOCALS, poll_enable="on"))
    with start("run", path, "--stdin", "--json") as run:
        answer(run, "set on 0")
        run.process.kill()
    asked = len(slave.device.done)
    with start("run", path, "--stdin", "--json") as run:
        run.wait_event(lambda e: e["event"] == "link" and e["up"], "the connection")
        assert get(run, "on") == "false"
        run.interrupt()
    assert len(slave.device.done) == asked


def test_other_types_and_names(project, slave):
    first = [
        "name: a, type: int32, retain: true", "name: b, type: int32, retain: true",
        "name: gone, type: int, retain: true"
    ]
    with start("run", project(tcp(["register: 0, " + READ], slave.port, local=first)), "--stdin",
               "--json") as run:
        for command in ("set a 77", "set b 77000", "set gone 1"):
            answer(run, command)
        run.interrupt()
    second = ["name: a, type: float, retain: true", "name: b, type: int, retain: true, default: 3"]
    with start("run", project(tcp(["register: 0, " + READ], slave.port, local=second)), "--stdin",
               "--json") as run:
        assert (get(run, "a"), get(run, "b")) == ("77", "3")
        result = run.interrupt()
    assert "b: the kept value 77000 does not fit its type int16" in result.err
    assert "the project has no retained value named gone" in result.err


def test_a_damaged_file_is_moved_aside_and_reported(project, slave, tmp_path):
    path = project(tcp(["register: 0, " + READ], slave.port, local=LOCALS))
    state = tmp_path / "elsewhere.state"
    state.write_bytes(b"SQLite format 3\0" + bytes(52) + b"Takt" + bytes(4928))
    with start("run", path, "--stdin", "--json", "--state", state) as run:
        assert get(run, "limit") == "5"
        assert "retained" not in answer(run, "set limit 6")
        result = run.interrupt()
    assert f"{state} is damaged and was moved to {state}.damaged-1" in result.err
    assert (tmp_path / "elsewhere.state.damaged-1").stat().st_size == 5000


@pytest.mark.parametrize("content", [b"{", b"my thesis\n" * 900])
def test_a_file_of_another_program_is_left_alone(project, slave, tmp_path, content):
    path = project(tcp(["register: 0, " + READ], slave.port, local=LOCALS))
    state = tmp_path / "thesis"
    state.write_bytes(content)
    with start("run", path, "--stdin", "--json", "--state", state) as run:
        assert get(run, "limit") == "5"
        result = run.interrupt()
    assert f"{state} is not a file of retained values" in result.err and "it was not changed" in result.err
    assert state.read_bytes() == content and not list(tmp_path.glob("thesis.*"))


def test_an_unwritable_folder_is_reported_and_the_run_continues(project, slave, tmp_path):
    path = project(tcp(["register: 0, " + READ], slave.port, local=LOCALS))
    with start("run", path, "--stdin", "--json", "--state", tmp_path / "none" / "x.state") as run:
        run.wait_event(value_event(run, "V1"), "a value")
        assert answer(run, "set limit 6")["retained"] is False
        assert answer(run, "set lost 6").get("retained") is None
        result = run.interrupt()
    assert "not kept in this run" in result.err and "none/x.state" in result.err


class LimitedFiles:
    """Files of the program may not grow."""

    def __init__(self, run, folder):
        self.process = run.process.pid

    def fill(self):
        self.before = resource.prlimit(self.process, resource.RLIMIT_FSIZE)
        resource.prlimit(self.process, resource.RLIMIT_FSIZE, (64, self.before[1]))

    def empty(self):
        resource.prlimit(self.process, resource.RLIMIT_FSIZE, self.before)


class FullDisk:
    """All of the disk is taken."""

    def __init__(self, run, folder):
        self.ballast = folder / "ballast"

    def fill(self):
        with open(self.ballast, "wb", buffering=0) as file:
            try:
                while file.write(b"x" * 512):
                    pass
            except OSError:
                pass

    def empty(self):
        self.ballast.unlink()


@pytest.fixture(params=[LimitedFiles, FullDisk])
def shortage(request, tmp_path):
    """The folder of the state, and a file that fills the disk."""
    folder = tmp_path / "disk"
    folder.mkdir()
    if request.param is LimitedFiles:
        yield folder, LimitedFiles
        return
    mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=128k", "none", folder], capture_output=True)
    if mounted.returncode:
        pytest.skip("no file system can be mounted here: the same with a limit of the file size")
    yield folder, FullDisk
    subprocess.run(["umount", folder], check=True)


def test_a_full_disk_acknowledges_nothing(project, slave, shortage):
    folder, Shortage = shortage
    state = folder / "x.state"
    path = project(tcp(["register: 0, " + READ], slave.port, local=LOCALS))
    with start("run", path, "--stdin", "--json", "--state", state) as run:
        assert "retained" not in answer(run, "set limit 6")
        disk = Shortage(run, folder)
        disk.fill()
        long = "x" * 4000  # it does not fit into the existing pages
        reply = answer(run, f"set note {long}")
        assert reply.get("retained") is False, reply
        assert answer(run, "set lost 9").get("retained") is None
        seen = len(run.out)
        slave.device.registers[0] += 1
        run.wait_event(value_event(run, "V1"), "a value: the polling goes on", after=seen)
        assert get(run, "note") == long, "it counts in this run"
        disk.empty()
        until(lambda: "retained" not in answer(run, "set limit 8"), "there is space again")
        run.process.kill()
    assert str(state) in "\n".join(run.err), "and it is reported"
    with start("run", path, "--stdin", "--json", "--state", state) as run:
        assert get(run, "limit") == "8" and get(run, "note") == long
        run.interrupt()


def test_one_run_at_a_time_keeps(project, slave):
    path = project(tcp(["register: 0, " + READ], slave.port, local=LOCALS))
    with start("run", path, "--stdin", "--json") as run, start("run", path, "--stdin", "--json") as other:
        assert sorted([answer(r, "set limit 8").get("retained", True) for r in (run, other)]) == [False, True]
        run.interrupt()
        assert "used by another program" in other.interrupt().err + run.finish().err
