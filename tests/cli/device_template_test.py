"""Device templates, words for numbers, and mirrors: as a user meets them."""
import json

import pytest
from pymodbus.client import ModbusTcpClient

from endpoints import free_port, wait_listening
from program import ROOT, start, takt, until

EXAMPLE = ROOT / "examples" / "pump-drives.yaml"
TEMPLATE = """\
takt: 1
parameters: {base: 0}
variables:
  - {name: State, type: uint16, register: $(base), read: 0x03, enumeration: {0: stopped, 1: running}}
  - {name: Faults, type: uint16, register: $(base + 1), read: 0x03, bits: {0: overload, 1: dry run}}
"""
PROJECT = """\
takt: 1
lines:
  - name: L
    transport: tcp
    host: h
    devices:
      - {name: North, address: 1, device_template: drive.yaml}
      - {name: South, address: 2, device_template: drive.yaml, parameters: {base: 100}}
"""


@pytest.fixture
def project(tmp_path):
    (tmp_path / "drive.yaml").write_text(TEMPLATE)
    path = tmp_path / "p.yaml"
    path.write_text(PROJECT)
    return path


def test_a_template_describes_a_type_once(project):
    line, = json.loads(takt("plan", project, "--json").out)["lines"]
    assert [(r["device"], r["start"], r["variables"])
            for r in line["requests"]] == [("North", 0, ["North.State", "North.Faults"]),
                                           ("South", 100, ["South.State", "South.Faults"])]


def test_a_finding_names_file_and_line_of_the_template(project):
    template = project.parent / "drive.yaml"
    template.write_text(TEMPLATE.replace("$(base + 1)", "$(bse + 1)"))
    result = takt("check", project, code=1)
    assert f"{template}:5:" in result.out and result.out.count("error:") == 1
    template.write_text(TEMPLATE.replace("uint16, register: $(base),", "unit16, register: $(base),"))
    result = takt("check", project, code=1)
    assert f"{template}:4:" in result.out and result.out.count("error:") == 1, "once, not for each device"


def test_a_template_is_no_project(project):
    assert "a device template" in takt("check", project.parent / "drive.yaml", code=2).out


def test_a_template_is_converted_with_the_project(project, tmp_path):
    table = tmp_path / "t.csv"
    takt("convert", project, "-o", table)
    assert "South.State,uint16" in table.read_text() and '"0=stopped, 1=running"' in table.read_text()
    back = takt("convert", table, "--device", "South").out
    assert "enumeration: \"0=stopped, 1=running\"" in back


def test_the_example_runs():
    with start("run", EXAMPLE, "--json") as run:
        for name in ("North.State", "South.Speed", "Reserve.Hours"):
            run.wait_event(lambda e, n=name: e["event"] == "value" and e["name"] == n, name)
        run.interrupt()
    with start("run", EXAMPLE) as run:
        run.wait_line(lambda line: " North.State = " in line, "a value")
        assert "North North" not in run.interrupt().out


MIRROR = PROJECT + """\
servers:
  - name: scada
    listen: 127.0.0.1
    tcp_port: 1510
    units:
      - {address: 1, mirror: {area: input_register, first: 10}}
"""


def test_a_register_map_of_mirrored_values(project, tmp_path):
    project.write_text(MIRROR)
    takt("check", project)
    out = tmp_path / "map.csv"
    takt("convert", project, "--map", "-o", out)
    rows = [row.split(",") for row in out.read_text().splitlines()]
    assert rows[0][:8] == ["server", "unit_address", "area", "first", "reference", "registers", "bit", "name"]
    assert [(row[3], row[4], row[7]) for row in rows[1:]] == [("10", "30011", "North.State"),
                                                              ("11", "30012", "North.Faults"),
                                                              ("12", "30013", "South.State"),
                                                              ("13", "30014", "South.Faults")]
    text = tmp_path / "map.md"
    takt("convert", project, "--map", "-o", text)
    assert "| input\\_register | 12 | 30013 | 1 | South.State | uint16 |" in text.read_text()
    texts = {
        takt("convert", project, "--map", "--to", "md", "--lang", lang).out
        for lang in ("en", "ru", "uk")
    }
    assert len(texts) == 3


@pytest.mark.parametrize("options", [["-o", "x.md"], ["--map", "-o", "x.yaml"], ["--to", "md"]])
def test_a_map_needs_a_project_and_a_table(project, tmp_path, options):
    options = [tmp_path / o if o.startswith("x.") else o for o in options]
    assert "--map" in takt("convert", project, *options, code=2).err


def test_own_registers_in_the_mirror_are_a_finding(project):
    own = "banks: [{area: input_register, items: [13..20]}], mirror"
    project.write_text(MIRROR.replace("mirror", own))
    result = takt("check", project, code=1)
    assert "10..13 of input_register" in result.out and "13..20" in result.out
    project.write_text(MIRROR.replace("mirror", own).replace("first: 10", "first: 9"))
    takt("check", project)


SLAVE = """
takt: 1
servers:
  - name: drives
    listen: 127.0.0.1
    tcp_port: {line}
    units:
      - address: 1
        banks: [{{area: holding_register, items: [0..9]}}]
        variables:
          - {{name: s, type: uint16, area: holding_register, register: 0, default: 1}}
          - {{name: f, type: uint16, area: holding_register, register: 1, default: 3}}
"""


def test_words_and_mirrored_registers_of_a_device(tmp_path):
    line, server = free_port(), free_port()
    (tmp_path / "drive.yaml").write_text(TEMPLATE.replace("read: 0x03, enum",
                                                          "read: 0x03, write: 0x06, enum"))
    (tmp_path / "slave.yaml").write_text(SLAVE.format(line=line))
    project = tmp_path / "p.yaml"
    project.write_text(f"""\
takt: 1
lines: [{{name: L, transport: tcp, host: 127.0.0.1, tcp_port: {line}, devices: [
  {{name: North, address: 1, poll_period: 100ms, device_template: drive.yaml}}]}}]
servers: [{{name: scada, listen: 127.0.0.1, tcp_port: {server}, units: [
  {{address: 1, mirror: {{first: 40, writable: true}}}}]}}]
""")
    with start("serve", tmp_path / "slave.yaml") as slave:
        wait_listening(line, slave)
        with start("run", project, "--json", "--stdin") as run:
            wait_listening(server, run)
            value = lambda name, number: run.wait_event(
                lambda e: e["event"] == "value" and e["name"] == name and e["value"] == number,
                f"{name} = {number}")
            assert value("North.State", 1)["words"] == "running"
            assert value("North.Faults", 3)["words"] == "overload, dry run"
            run.send("get North.State")
            assert run.wait_event(lambda e: e["event"] == "answer", "get")["words"] == "running"
            client = ModbusTcpClient("127.0.0.1", port=server)
            assert client.connect()
            read = lambda: getattr(client.read_holding_registers(40, 2, slave=1), "registers", None)
            until(lambda: read() == [1, 3], "the mirrored values")
            assert client.read_holding_registers(42, 1, slave=1).exception_code == 2
            assert not client.write_register(40, 0, slave=1).isError(), "State may be written"
            assert client.write_register(41, 0, slave=1).exception_code == 2, "Faults may not"
            assert value("North.State", 0)["words"] == "stopped"
            client.close()
