"""Service variables: registers that mirror the health of a line, triggers by time, `get`, and the findings of
mistakes."""
import datetime
import struct
import time

import pytest
from pymodbus.client import ModbusTcpClient

from endpoints import free_port, wait_listening
from program import DEADLINE, ROOT, start, takt, until

SLAVE = """
takt: 1
servers:
  - name: boiler
    listen: 127.0.0.1
    tcp_port: {port}
    units:
      - address: 16
        banks: [{{area: holding_register, items: [0..9]}}, {{area: coil, items: [0..9]}}]
"""

MASTER = """
takt: 1
lines:
  - name: bus
    transport: tcp
    host: 127.0.0.1
    tcp_port: {line}
    devices:
      - name: Boiler
        address: 16
        poll_period: 50ms
        response_timeout: 10s
        backoff: 100ms
        variables:
          - {{name: T, type: float, register: 0, read: 0x03}}
          - {{name: Count, type: uint16, register: 5, read: 0x03, period: 24h, read_trigger: system.pulse_1s}}
          - {{name: Setting, type: uint16, register: 6, write: 0x06, default: 77,
              write_trigger: system.device.Boiler.answering}}
servers:
  - name: health
    listen: 127.0.0.1
    tcp_port: {server}
    units:
      - address: 1
        banks: [{{area: input_register, items: [0..19]}}, {{area: holding_register, items: [0..9]}}]
        variables:
          - {{name: state, type: uint16, area: input_register, register: 0,
             source: {{variable: system.device.Boiler.state}}}}
          - {{name: errors, type: uint32, area: input_register, register: 1,
             source: {{variable: system.device.Boiler.errors}}}}
          - {{name: response time, type: float, area: input_register, register: 3,
             source: {{variable: system.device.Boiler.response_time}}}}
          - {{name: load, type: float, area: input_register, register: 5,
             source: {{variable: system.line.bus.load}}}}
          - {{name: up, type: uint16, area: input_register, register: 7,
             source: {{variable: system.line.bus.up}}}}
          - {{name: outages, type: uint32, area: input_register, register: 8,
             source: {{variable: system.device.Boiler.outages}}}}
          - {{name: time, type: uint32, area: input_register, register: 10,
             source: {{variable: system.time}}}}
          - {{name: uptime, type: uint32, area: input_register, register: 12,
             source: {{variable: system.uptime}}, max_age: 5s}}
          - {{name: requests, type: uint32, area: holding_register, register: 0,
             source: {{variable: system.device.Boiler.requests}}}}
"""


class Plant:
    """A master with a server of its health, and a slave that can be stopped."""

    def __init__(self, folder):
        self.line, self.server = free_port(), free_port()
        self.slave_file, self.file = folder / "slave.yaml", folder / "plant.yaml"
        self.slave_file.write_text(SLAVE.format(port=self.line))
        self.file.write_text(MASTER.format(line=self.line, server=self.server))

    def slave(self):
        return start("serve", self.slave_file)

    def master(self, *more):
        return start("run", self.file, "--json", "--stdin", *more)

    def health(self, client):
        """The input registers by name. The register with the low word of a value goes first."""
        words = client.read_input_registers(0, 14, slave=1).registers
        pair = lambda at, form: struct.unpack(form, struct.pack(">HH", words[at + 1], words[at]))[0]
        return {
            "state": words[0],
            "errors": pair(1, ">I"),
            "response_time": pair(3, ">f"),
            "load": pair(5, ">f"),
            "up": words[7],
            "outages": pair(8, ">I"),
            "time": pair(10, ">I"),
            "uptime": pair(12, ">I")
        }


@pytest.fixture
def plant(tmp_path):
    return Plant(tmp_path)


def answer(run, command):
    seen = len(run.out)
    run.send(command)
    return run.wait_event(lambda e: e["event"] in ("answer", "error"), command, after=seen)


def test_a_client_reads_the_health_of_a_line_while_its_device_stops_and_starts(plant):
    begun = time.monotonic()
    with plant.master() as run:
        wait_listening(plant.server, run)
        client = ModbusTcpClient("127.0.0.1", port=plant.server)
        assert client.connect()
        until(lambda: plant.health(client)["state"] == 4, "no connection yet")
        assert plant.health(client)["up"] == 0
        with plant.slave():
            until(lambda: plant.health(client)["state"] == 1, "the device answers")
            health = until(lambda: (h := plant.health(client))["load"] > 0 and h["response_time"] > 0 and h,
                           "a load")
            assert health["up"] == 1
            assert 0 < health["response_time"] < 10_000, "in ms, and at most the time-out"
            assert health["load"] <= 100
            outages = health["outages"]  # a starting server may accept the connection before it can answer
            assert outages <= 1
            written = until(
                lambda: takt("read", f"tcp://127.0.0.1:{plant.line}", "--unit", "16", "holding", "6").out ==
                "6 77\n", "the setting that is sent when the device answers")
            assert written
        until(lambda: plant.health(client)["state"] in (2, 4), "the device is gone")
        with plant.slave():
            until(lambda: plant.health(client)["state"] == 1, "the device is back")
            # The state is computed each 100 ms, the count of outages each second.
            until(lambda: plant.health(client)["outages"] > outages, "one more outage")
            until(
                lambda: takt("read", f"tcp://127.0.0.1:{plant.line}", "--unit", "16", "holding", "6").out ==
                "6 77\n", "the setting again")
        before, health, after = time.time(), plant.health(client), time.time()
        assert before - DEADLINE < health["time"] <= after, "of the last update"
        assert health["uptime"] <= time.monotonic() - begun
        assert client.write_register(0, 1, slave=1).exception_code == 2, "a service variable is read-only"
        client.close()


def test_a_pulse_triggers_a_read_each_second(plant):
    with plant.slave() as slave:
        wait_listening(plant.line, slave)
        with plant.master("--traffic", "-") as run:
            pulses = lambda: [e for e in run.events() if e.get("name") == "system.pulse_1s" and e["value"]]
            times = lambda: [e["time_ms"] for e in pulses()]
            # A pulse may be late, and never early: the first part of a second has the punctual ones.
            until(lambda: len(pulses()) >= 4 and any(t % 1000 < 400 for t in times()), "pulses")
            seconds = [t // 1000 for t in times()]
            assert all(b - seconds[0] >= n - 1 for n, b in enumerate(seconds)), "at most one each second"
            reads = lambda: [x for x in run.err if "Tx" in x and "03 00 05 00 01" in x]
            until(lambda: len(reads()) >= 4, "a read for each pulse")
            seen = len(reads())
            until(lambda: len(pulses()) + 2 >= seen, "a pulse for each read")


def test_get_knows_every_one_and_writing_is_refused(plant):
    with plant.slave() as slave:
        wait_listening(plant.line, slave)
        with plant.master() as run:
            run.wait_event(lambda e: e["event"] == "device" and e["state"] == "answering", "the device")
            clock = answer(run, "get system.time")
            assert clock["utc"] == datetime.datetime.fromtimestamp(int(
                clock["value"]), datetime.timezone.utc).strftime("%Y-%m-%dT%H:%M:%SZ")
            assert answer(run, "get system.line.bus.cycle")["name"] == "system.line.bus.cycle"
            by_line, by_name = (answer(run, f"get system.device.{name}.timeouts")
                                for name in ("bus/Boiler", "Boiler"))
            at_any_time = {"time_ms": pytest.approx(0, abs=1e9), "time": by_line["time"]}
            assert by_line == by_name | at_any_time
            for command in ("set system.pulse_1s 1", "write system.uptime 5",
                            "set system.device.Boiler.state x"):
                refused = answer(run, command)
                assert refused["code"] == "read_only"
                assert command.split()[1] in refused["text"] and "read-only" in refused["text"]
            unknown = answer(run, "get system.device.Boler.state")
            assert "system.device.Boiler.state" in unknown["text"]
            assert "system.pulse_1min" in answer(run, "get system.puls")["text"]
            run.send("quit")
            run.finish()


@pytest.mark.parametrize("line, code, words", [
    ("{name: X, type: int, register: 1, read: 3, read_trigger: system.pulse}", "service.unknown",
     "system.pulse_1s"),
    ("{name: X, type: int, register: 1, read: 3, read_trigger: system.device.Boller.answering}",
     "service.unknown", "system.device.Boiler.answering"),
    ("{name: X, type: int, register: 1, read: 3, read_trigger: system.uptime}", "service.type", "uint32"),
    ("{name: X, type: int, register: 1, read: 3, status: system.uptime}", "service.read_only", "read-only"),
    ("{name: system.x, type: int, register: 1, read: 3}", "name.reserved", "system."),
])
def test_mistakes_are_findings(tmp_path, line, code, words):
    project = tmp_path / "wrong.yaml"
    project.write_text(
        "takt: 1\nlines:\n  - name: bus\n    port: /dev/ttyS0\n    devices:\n      - name: Boiler\n"
        f"        address: 16\n        variables:\n          - {line}\n")
    found = [f for f in takt("check", project, "--json", code=1).json["findings"] if f["severity"] == "error"]
    assert [f["code"] for f in found] == [code]
    assert words in found[0]["message"] + found[0]["advice"]
    assert found[0]["line"] == 9


def test_a_request_table_cannot_hold_a_service_trigger(tmp_path):
    project = tmp_path / "pulsed.yaml"
    project.write_text(
        "takt: 1\nlines:\n  - name: bus\n    port: /dev/ttyS0\n    devices:\n      - name: Boiler\n"
        "        address: 16\n        variables:\n"
        "          - {name: X, type: int, register: 1, read: 3, read_trigger: system.pulse_1s}\n")
    for options in ([], ["--profile", "owen-kc1"]):
        refused = takt("table", "build", project, "-o", tmp_path / "x.table", *options, code=None)
        assert refused.code != 0
        assert "system.pulse_1s" in refused.out + refused.err


def test_the_example_runs(tmp_path):
    with start("run", ROOT / "examples/line-health.yaml", "--stdin", "--json") as run:
        run.wait_event(lambda e: e["event"] == "device" and e["device"] == "Boiler", "the boiler")
        run.send("quit")
        run.finish()
