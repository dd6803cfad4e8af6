"""The live displays of `run` and `read --watch` on a terminal: layout, keys, resizing, and the end."""
import re
import time

import pytest

import endpoints
from fake_slave import TcpSlave, tcp_answer
from program import start, takt, until
from projects import tcp
from terminal import Terminal

MANY = [f"name: Value_{i:02}, register: {i}, type: int16, read: 0x03" for i in range(60)]


@pytest.fixture
def plant(project, blank_device):
    return project(tcp(MANY, blank_device("ramp"), local=["name: go, type: bool"]))


def some(text):
    return lambda lines: any(text in line for line in lines)


def printed(*arguments):
    """The lines that a command prints on a terminal of 80 columns."""
    with Terminal(*arguments) as terminal:
        terminal.ends()
        until(lambda: terminal.raw.endswith("\n"), "the last line")
        return re.sub(r"\x1b\[[0-9;]*[A-Za-z]|\r", "", terminal.raw).splitlines()


def test_the_display_fits_80_by_24(plant):
    with Terminal("run", plant) as terminal:
        lines = terminal.shows(some("Value_16"), "a full page")
        terminal.shows(lambda seen: "connected, load" in seen[0] and "answering: Node1" in seen[1],
                       "line and device at the top")
        assert not terminal.screen.scrolled or all("Value" not in line for line in terminal.screen.scrolled)
        assert len(lines) <= 24 and max(map(len, lines)) < 80
        terminal.shows(some("of 61"), "which rows are shown")
        terminal.interrupt()
        assert "Node1" in terminal.raw.split("cycle planned")[-1], "the summary"


def test_keys(plant):
    with Terminal("run", plant) as terminal:
        terminal.shows(some("1–"), "the first page")
        terminal.press("\x1b[6~")
        terminal.shows(some("Value_20"), "the next page")
        terminal.press("G")
        terminal.shows(some("Value_59"), "the last page")
        terminal.press("g")
        terminal.shows(some("Value_00"), "the first page")
        terminal.press("/e_4")
        terminal.shows(some("names with: e_4"), "the filter while it is typed")
        terminal.press("\n")
        lines = terminal.shows(lambda seen: some("1–10 of 10")(seen), "ten values")
        assert sum("Value_4" in line for line in lines) == 10
        terminal.press("\x1b")
        terminal.shows(some("of 61"), "all values")
        terminal.press("q")
        terminal.ends()


def test_a_value_that_is_not_good_is_at_the_top(project, tmp_path):
    answer = lambda adu: tcp_answer(adu, "83 02") if adu[8:10] == b"\0\x64" else tcp_answer(
        adu, "03 02 00 05")
    with TcpSlave(answer) as slave:
        path = project(
            tcp([
                "name: Good, register: 0, type: int16, read: 0x03",
                "name: Bad, register: 100, type: int16, read: 0x03"
            ], slave.port))
        with Terminal("run", path) as terminal:
            lines = terminal.shows(lambda seen: some("exception 2")(seen) and some(" 5 ")(seen),
                                   "both values")
            rows = [line for line in lines if line.startswith("Node1")]
            assert rows[0].split()[1] == "Bad" and rows[0].endswith(
                "exception 2") and rows[1].split()[1] == "Good"
            terminal.press("!")
            terminal.shows(lambda seen: not some("Good")(seen) and some("1–1 of 1, not good only")(seen),
                           "the bad value alone")
            terminal.interrupt()


def test_resizing(plant):
    with Terminal("run", plant) as terminal:
        terminal.shows(some("1–"), "the first page")
        terminal.resize(12, 60)
        lines = terminal.shows(lambda seen: some("1–")(seen) and not some("Value_10")(seen), "a smaller page")
        assert max(map(len, lines)) < 60
        terminal.resize(50, 120)
        terminal.shows(some("Value_40"), "a larger page")
        terminal.signal()


def test_the_project_is_never_connected(project):
    with Terminal("run", project(tcp(MANY[:2], endpoints.free_port()))) as terminal:
        lines = terminal.shows(lambda seen: some("bad, never connected")(seen), "the reason")
        assert any("net: never connected" in line for line in lines)
        assert "lost" not in "".join(lines)
        terminal.interrupt()


@pytest.mark.parametrize("language", ["en", "ru", "uk"])
@pytest.mark.parametrize("command", ["check", "plan", "run --for 300ms", "run --for 300ms --quiet"],
                         ids=lambda c: c.replace(" ", "_"))
def test_no_line_is_wrapped_by_the_terminal(project, blank_device, command, language):
    """Tables fit 80 columns; sentences are broken at blanks."""
    names = [
        "name: Supply_temperature, register: 0, type: float, read: 0x03",
        "name: Level, register: 300, type: float, read: 0x03"
    ]
    path = project(tcp(names, blank_device("ramp")))
    verb, *options = command.split()
    lines = [line for line in printed(verb, path, *options, "--lang", language) if str(path) not in line]
    assert lines and max(map(len, lines)) <= 80, "\n".join(line for line in lines if len(line) > 80)


@pytest.mark.parametrize("language", ["en", "ru", "uk"])
def test_the_tables_of_ctl_fit_the_terminal(project, tmp_path, language):
    names = [
        "name: Supply_temperature_of_the_second_boiler, register: 0, type: float, read: 0x03, unit: °C",
        "name: Serial, register: 300, type: string, length: 60, read: 0x03"
    ]
    with TcpSlave(lambda adu: tcp_answer(adu, "03 78" + " 41" * 120 if adu[11] == 60 else "83 02")) as slave:
        path, control = project(tcp(names, slave.port)), tmp_path / "control"
        with start("run", path, "--control", control) as run:
            until(lambda: takt("ctl", control, "get", "Serial", code=None).code == 0, "the first values")
            for command in ("list", "values"):
                lines = printed("ctl", control, command, "--lang", language)
                assert max(map(len, lines)) <= 80, "\n".join(lines)
                assert names[0].split(",")[0][6:] in "".join(lines), "a name is whole, ready for `get`"
            assert "A" * 120 in takt("ctl", control, "values").out, "no terminal"
            run.interrupt()


@pytest.mark.parametrize("language", ["en", "ru", "uk"])
def test_the_help_of_options_is_in_their_second_column(language):
    lines = printed("--help", "--lang", language)
    assert max(map(len, lines)) <= 80
    assert any(line.startswith(" " * 30) for line in lines), "a description in two lines"


def test_read_watch(blank_device):
    """An exception is readable at 80 columns, with its words below."""
    with Terminal("read", f"tcp://127.0.0.1:{blank_device('ramp')}", "holding", 65530, 4, "--watch", "100ms",
                  "--also", "holding:10:40") as terminal:
        terminal.shows(lambda seen: some("answering")(seen) and some("holding 65530")(seen), "values")
        terminal.press("G")
        terminal.shows(some("holding 49"), "the last page")
        terminal.press("q")
        terminal.ends()


def test_read_watch_of_what_is_refused():
    with TcpSlave(lambda adu: tcp_answer(adu, "83 02")) as slave:
        with Terminal("read", f"tcp://127.0.0.1:{slave.port}", "holding", 500, 3, "--watch",
                      "100ms") as terminal:
            lines = terminal.shows(some("illegal data address"), "the exception")
            assert sum(line.endswith("exception 2") for line in lines
                       if line.startswith("holding 50")) == 3, lines
            assert lines[0].endswith(": exception 2") and max(map(len, lines)) < 80
            terminal.press("\x03")
            terminal.ends(code=5)


# --- without a terminal


def test_quiet_prints_changes_of_state_only(project, blank_device):
    port = blank_device("ramp")
    with start("run", project(tcp(MANY, port)), "--quiet") as run:
        run.wait_line(lambda line: "Node1: answering" in line, "the state")
        result = run.interrupt()
    assert "Value_00 =" not in result.out and "cycle planned" in result.out
    assert all(
        re.match(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{3}[+-]\d\d:\d\d ", line) for line in result.lines[:2])


def test_a_missing_host_is_reported_once(project):
    """Further attempts are counted; --quiet leaves out the count, too."""

    def links(run):
        return [e for e in run.events() if e["event"] == "link"]

    with start("run", project(tcp(MANY, endpoints.free_port())), "--quiet", "--json") as run, \
            start("run", project(tcp(MANY, endpoints.free_port()), "other.yaml"), "--json") as loud:
        run.wait_event(lambda e: e["event"] == "link", "the missing host")
        loud.wait_event(lambda e: e["event"] == "link", "the missing host")
        time.sleep(2)  # pauses of 0.25, 0.5 and 1 s
        assert (len(links(run)), len(links(loud))) == (1, 1)
        assert not any(e["event"] == "value" for e in run.events())
        run.interrupt()
        loud.interrupt()
        assert len(links(run)) == 1
        assert ["repeated" in e for e in links(loud)] == [False, True]


def test_one_device(project, blank_device):
    text = tcp(MANY[:2], blank_device("ramp")) + """      - name: Other
        address: 2
        variables:
          - {name: Elsewhere, register: 3, type: int16, read: 0x03}
"""
    with start("run", project(text), "--device", "Node1", "--json") as run:
        run.wait_event(lambda e: e["event"] == "value" and e["name"] == "Value_01", "a value")
        result = run.interrupt()
    assert "Elsewhere" not in result.out
    refused = takt("run", project(text), "--device", "Node2", code=2)
    assert "Node1, Other" in refused.err
