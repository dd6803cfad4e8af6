"""`servers:` of a project, served by `takt serve FILE`."""
import pytest

import endpoints
from program import start, takt
from projects import tcp

SERVERS = """
takt: 1
servers:
  - name: tanks
    listen: 127.0.0.1
    tcp_port: {port}
    units:
      - address: 1
        banks:
          - {{area: holding_register, items: [0..9, 1000..1009], read_only: [5]}}
          - {{area: input_register, items: [7]}}
          - {{area: coil, items: [0..31], overlay: holding_register, overlay_register: 2}}
          - {{area: discrete_input, items: [3..4]}}
        limits:
          - {{registers: [0..1], least: -5, greatest: 5}}
        identification:
          - {{id: 1, text: Product}}
          - {{id: 0, text: Vendor}}
        server_id: tanks
        files:
          - {{number: 4, records: 2}}
        fifos:
          - {{register: 1246, values: [440, 4740]}}
        variables:
          - {{name: Level, type: float, area: holding_register, register: 1000, default: 1.5}}
          - {{name: Alarm, type: bool, area: discrete_input, coil: 4, default: true}}
          - {{name: Spare, type: int, area: holding_register, register: 9, default: 7, used: false}}
      - address: 2
        banks:
          - {{area: holding_register, items: [0]}}
"""

# unit, request, answer
ANSWERS = [
    (1, "03 03E8 0002", "03 04 00 00 3F C0"),
    (1, "02 0003 0002", "02 01 02"),
    (1, "03 0009 0001", "03 02 00 00"),
    (1, "03 0009 0002", "83 02"),
    (1, "06 0005 0001", "86 02"),
    (1, "06 0000 FFFA", "86 03"),
    (1, "06 0000 FFFB", "06 00 00 FF FB"),
    (1, "05 0011 FF00", "05 00 11 FF 00"),
    (1, "03 0003 0001", "03 02 00 02"),
    (1, "04 0007 0001", "04 02 00 00"),
    (1, "2B 0E 04 00", "2B 0E 04 81 00 00 01 00 06 56 65 6E 64 6F 72"),
    (1, "11", "11 07 01 FF 74 61 6E 6B 73"),
    (1, "14 07 06 0004 0001 0002", "94 02"),
    (1, "18 04DE", "18 00 06 00 02 01 B8 12 84"),
    (1, "08 0004 0000", "88 01"),
    (2, "06 0000 1234", "06 00 00 12 34"),
    (2, "03 0000 0001", "03 02 12 34"),
    (2, "01 0000 0001", "81 02"),
    (2, "18 04DE", "98 01"),
    (2, "11", "91 01"),
    (3, "03 0000 0001", "83 0A"),
]


def test_units_banks_and_functions(project):
    port = endpoints.free_port()
    path = project(SERVERS.format(port=port))
    assert takt("check", path).code == 0
    with start("serve", path) as running:
        endpoints.wait_listening(port, running)
        for unit, request, answer in ANSWERS:
            refused = int(answer[:2], 16) & 0x80
            done = takt("raw", f"tcp://127.0.0.1:{port}", "--unit", unit, request, code=5 if refused else 0)
            assert done.out.strip() == answer, request
        running.interrupt()


def test_on_a_serial_line(project, pair):
    path = project(f"""
takt: 1
servers:
  - {{name: s, transport: serial, port: {pair.b}, units: [
      {{address: 9, banks: [{{area: coil, items: [5]}}]}}]}}
""")
    with start("serve", path) as running:
        endpoints.wait_slave(pair.a, 9, "rtu", running)
        target = f"rtu://{pair.a}?baud=19200&parity=even"
        assert takt("raw", target, "--unit", 9, "05 0005 FF00").out.strip() == "05 00 05 FF 00"
        assert takt("raw", target, "--unit", 9, "01 0005 0001").out.strip() == "01 01 01"
        assert takt("raw", target, "--unit", 9, "01 0004 0001", code=5).out.strip() == "81 02"
        running.interrupt()


@pytest.mark.parametrize("options", [["--unit", "2"], ["--listen", "127.0.0.1:1"], ["--port", "/dev/null"]],
                         ids=lambda options: options[0])
def test_options_that_would_do_nothing_beside_servers(project, options):
    result = takt("serve", project(SERVERS.format(port=endpoints.free_port())), *options, code=2)
    assert options[0] in result.err


def test_devices_of_a_line_are_not_filled(project):
    path = project(tcp(["type: int, register: 0, read: 0x03"], 1502))
    assert "--fill applies to" in takt("serve", path, "--fill", "ramp", code=2).err


def test_two_servers_on_one_port(project):
    path = project("""
takt: 1
servers:
  - {name: a, listen: "*", tcp_port: 1502, units: [{address: 1, banks: [{area: coil, items: [5]}]}]}
  - {name: b, listen: 127.0.0.1, tcp_port: 1502, units: [{address: 1, banks: [{area: coil, items: [5]}]}]}
""")
    result = takt("check", path, code=1)
    assert f"{path}:5:" in result.out and "1502" in result.out and ":4" in result.out
    assert "servers" in takt("check", project("takt: 1\nservers: []\n"), code=1).out
