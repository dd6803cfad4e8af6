"""A run from a table sends the same frames as a run from its project."""
import pytest

import endpoints
from frames import traffic, without_checks
from program import start, takt, until
from projects import at, scenario_1, scenario_3, serial, tcp


def requests_of(log):
    return [f.hex for f in traffic(log.read_text()) if f.way == "Tx"] if log.exists() else []


def frames_of(command, tmp_path, name, least=1, script=()):
    """Runs a project or a table; gives what was sent: at least `least` frames, then after each command one
    more, or as many as stand beside it."""
    log = tmp_path / f"{name}.log"
    with start(*command, "--stdin", "--json", "--traffic", log) as run:
        until(lambda: len(requests_of(log)) >= least, "the first round")
        for said, more in [its if isinstance(its, tuple) else (its, 1) for its in script]:
            enough = len(requests_of(log)) + more
            run.send(said)
            until(lambda n=enough: len(requests_of(log)) >= n, f"a request for '{said}'")
        run.send("quit")
        run.finish()
    return requests_of(log)


@pytest.fixture
def both(project, tmp_path, pair):
    """Runs a project and its table, one after the other, each against a new blank device; gives the frames of
    each."""

    def served(command, name, least, script):
        with start("serve", "--port", f"rtu://{pair.b}?baud=115200&parity=none", "--unit", 16, "--fill",
                   "ramp") as device:
            endpoints.wait_slave(pair.a, 16, "rtu", device)
            frames = frames_of(command, tmp_path, name, least, script)
            device.interrupt()
        return frames

    def run(text, least=1, script=()):
        path = project(text)
        table = tmp_path / "table.bin"
        takt("table", "build", path, "-o", table)
        first = served(["run", path], "project", least, script)
        path.rename(tmp_path / "gone.yaml")  # nothing of the file is needed any more
        return first, served(["run", "--table", table], "table", least, script)

    return run


def test_scenario_1(both, pair):
    first, second = both(scenario_1(port=pair.a), 3)
    assert set(first) == set(second) == {"10 03 00 00 00 14 46 84"}


def test_scenario_2_in_its_order(both, pair):
    # Where the machine stops for a period, the first ones are due again before the last were sent.
    first, second = both(scenario_1(grouped=False, port=pair.a), 100)
    first, second = (list(dict.fromkeys(without_checks(frames))) for frames in (first, second))
    assert first == second
    assert len(first) == 10


def test_triggers_and_writes(both, pair):
    text = serial([
        "name: A, type: int, register: 1, read: 0x03, period: 1h, write: 0x10, write_on_change: true",
        "name: B, type: int, register: 2, read: 0x03, period: 1h, write: 0x10, write_on_change: true",
        "name: T, type: float, register: 10, read: 0x04, period: 1h, read_trigger: go",
        "name: P, type: bool, register: 0, bit: 2, read: 0x01, period: 1h, write: 0x05, write_trigger: out",
        "name: S, type: string, length: 3, register: 20, read: none, write: 0x10"
    ], port=pair.a, local=["name: go, type: bool", "name: out, type: bool"])
    script = ["set A -2", "set go true", "set out true", "write S abc", "write B 7"]
    first, second = both(text, 3, script)
    assert first == second
    assert [f[3:5] for f in first[3:]] == ["10", "04", "05", "10", "10"]
    assert first[3][:26] == "10 10 00 01 00 02 04 FF FE"


def test_json_names_and_values(project, tmp_path, pair):
    path = project(scenario_3(port=pair.a))
    table = tmp_path / "table.bin"
    takt("table", "build", path, "-o", table)
    with start("serve", path, "--port", pair.b) as device, start("run", "--table", table, "--json") as run:
        for name in ("First", "Second", "Third"):
            run.wait_event(
                lambda e, n=name: e["event"] == "value" and e["name"] == n and e["quality"] == "good", name)
        run.interrupt()
        device.interrupt()
    summary = run.events()[-1]
    assert summary["event"] == "summary" and summary["lines"][0]["devices"][0]["name"] == "Node1"


def test_another_place(project, tmp_path, pair, blank_device):
    table = tmp_path / "serial.bin"
    takt("table", "build", project(scenario_1()), "-o", table)
    log = tmp_path / "traffic.log"
    with start("run", "--table", table, "--port", pair.a, "--traffic", log) as run:
        until(lambda: requests_of(log), "a request")
        run.interrupt()
    assert requests_of(log)[0] == "10 03 00 00 00 14 46 84"
    port = blank_device()
    table = tmp_path / "tcp.bin"
    takt("table", "build", project(tcp(at([5], "type: int, read: 0x03"), 1)), "-o", table)
    with start("run", "--table", table, "--port", f"tcp://127.0.0.1:{port}", "--json") as run:
        run.wait_event(lambda e: e["event"] == "value" and e["quality"] == "good", "a good value")
        run.interrupt()
    assert "--port tcp://HOST:502" in takt("run", "--table", table, "--port", f"rtu://{pair.a}", code=2).err


def test_tables_that_cannot_run(project, tmp_path):
    path = project(scenario_1())
    takt("table", "build", path, "-o", tmp_path / "owen.bin", "--profile", "owen-kc1")
    assert "--port" in takt("run", "--table", tmp_path / "owen.bin", code=2).err
    moved = takt("run", "--table", tmp_path / "owen.bin", "--port", "tcp://127.0.0.1:1", code=2)
    assert "the table is for rtu" in moved.err and "--port rtu+tcp://127.0.0.1:1" in moved.err
    assert "not a request table" in takt("run", "--table", path, code=2).err
    takt("run", "--table", tmp_path / "none.bin", code=2)
    takt("run", path, "--table", tmp_path / "owen.bin", code=2)
    takt("run", code=2)


OWEN = serial([
    "name: F, type: float, register: 0, read: 0x03, write: 0x10, write_on_change: true, period: 1h",
    "name: G, type: float, register: 2, read: 0x03, write: 0x10, write_on_change: true, period: 1h",
    "name: B, type: bool, register: 5, bit: 3, read: 0x03, write: 0x06, write_on_change: true, period: 1h",
    "name: P, type: bool, register: 0, bit: 2, read: 0x01, write: 0x05, write_trigger: out, period: 1h",
    "name: T, type: int, register: 10, read: 0x04, period: 1h, read_trigger: go",
], port="{port}", local=["name: go, type: bool", "name: out, type: bool"], read_modify_write="true").replace(
    "1h", "60s")


def test_a_table_of_the_controller_sends_the_frames_of_its_project(project, tmp_path, pair):
    path = project(OWEN.replace("{port}", pair.a).replace("profile: generic", "profile: owen-kc1"))
    table = tmp_path / "owen.bin"
    takt("table", "build", path, "-o", table, "--profile", "owen-kc1")
    entries = takt("table", "show", table, "--json").json["lines"][0]["devices"][0]["entries"]
    bit = next(e for e in entries if e["write_function"] == 6)
    assert (bit["type"], bit["bit"], bit["function"], bit["start"], bit["quantity"]) == ("bit", 3, None, 5, 1)
    changes = {"project": ("F", "B", "go", "out"), "table": ("value4", "value6", "local1", "local2")}
    frames = {}
    for name, (number, bit, go, out) in changes.items():
        script = [f"set {number} 7", (f"set {bit} true", 2), f"set {go} true", f"set {out} true"]
        if name == "project":
            script[0] = "set F 9.8e-45"  # the bits of the integer 7
        command = ["run", path] if name == "project" else ["run", "--table", table, "--port", pair.a]
        with start("serve", "--port", f"rtu://{pair.b}?baud=115200&parity=none", "--unit", 16, "--fill",
                   "ramp") as device:
            endpoints.wait_slave(pair.a, 16, "rtu", device)
            frames[name] = frames_of(command, tmp_path, name, 4, script)
            device.interrupt()
    assert frames["project"] == frames["table"]
    assert any(f.startswith("10 10 00 00 00 04 08 00 07 00 00") for f in frames["table"])
    assert any(f.startswith("10 06 00 05 00") for f in frames["table"])
