"""The memory of `takt run` whatever a broker sends, with a broker that ignores Maximum Packet Size."""
import json
import pathlib
import subprocess
import time

import pytest

from hostile_broker import HostileBroker, publish_header
from mqtt_plant import PLANT, TAKT, Broker, wait_until

COMMANDS = PLANT.replace("\noutputs:", """
          - {{name: Setpoint, type: int16, register: 10, read: 0x03, write: 0x10}}
outputs:""") + "    commands: [Setpoint]\n"
TOPIC = "takt/cloud/command"
MEBIBYTE = 1 << 20


def has_sanitizer():
    return b"__asan_init" in pathlib.Path(TAKT).read_bytes()


# The memory of a program with AddressSanitizer also holds what was freed.
ALLOWED = (6 if has_sanitizer() else 1) * MEBIBYTE


def memory(program, key):
    status = pathlib.Path(f"/proc/{program.pid}/status").read_text()
    return int(next(line.split()[1] for line in status.splitlines() if line.startswith(key))) * 1024


def forget_peak(program):
    pathlib.Path(f"/proc/{program.pid}/clear_refs").write_text("5")


class Plant:

    def __init__(self, folder, port, keys=""):
        project = folder / "plant.yaml"
        project.write_text(COMMANDS.format(port=port) + keys)
        self.program = subprocess.Popen([TAKT, "run", project, "--json", "--log", folder / "log"],
                                        stdout=open(folder / "out", "wb"))
        self.log, self.out = folder / "log", folder / "out"

    def grown(self, action):
        """How much the memory has grown at most during `action`."""
        forget_peak(self.program)
        before = memory(self.program, "VmRSS")
        action()
        return memory(self.program, "VmHWM") - before

    def end(self):
        self.program.terminate()
        assert self.program.wait(30) == 0
        return json.loads(self.out.read_text().splitlines()[-1])["outputs"][0]


@pytest.fixture(params=[4, 5], ids=["3.1.1", "5"])
def hostile(request, tmp_path):
    broker = HostileBroker(only_version=request.param)
    plant = Plant(tmp_path, broker.port)
    wait_until(lambda: broker.connections == 1 and broker.published > 10)
    time.sleep(0.3)
    yield broker, plant
    plant.program.kill()
    plant.program.wait()
    broker.close()


def test_the_memory_does_not_follow_the_size_of_messages(hostile):
    broker, plant = hostile
    version = broker.version
    chunk = bytes(MEBIBYTE)

    def large():
        broker.send(publish_header(TOPIC, 24 * MEBIBYTE, identifier=1, version=version), *[chunk] * 24)
        broker.send(publish_header(TOPIC, 2 * MEBIBYTE, qos=2, identifier=2, version=version), chunk, chunk)
        for _ in range(8):
            broker.send(publish_header(TOPIC, MEBIBYTE, qos=0, version=version), chunk)
        for identifier in range(100, 600):
            broker.send(publish_header(TOPIC, 12000, identifier=identifier, version=version), chunk[:12000])
        broker.send(b"\x62\x02\x00\x02")  # PUBREL
        wait_until(lambda: {(4, 1), (5, 2), (7, 2), (4, 599)} <= broker.acknowledged)
        published = broker.published
        wait_until(lambda: broker.published > published + 5)

    def trickle():
        broker.send(publish_header(TOPIC, 256 * MEBIBYTE - 100, version=version))
        for _ in range(16):
            broker.send(bytes(256 << 10))
            time.sleep(0.02)

    assert plant.grown(large) <= ALLOWED
    assert plant.grown(trickle) <= ALLOWED
    output = plant.end()
    assert broker.connections == 1 and output["mqtt"]["lost_connections"] == 0
    assert output["mqtt"]["oversized"] == 11
    assert output["mqtt"]["last_oversized"]["topic"] == TOPIC
    assert output["mqtt"]["last_oversized"]["bytes"] > 200 * MEBIBYTE
    assert output["commands"] == output["commands_refused"] == 500
    assert output["delivered"] > 10 and output["dropped"] == 0
    assert f"on topic {TOPIC}" in plant.log.read_text()
    if version == 5:
        assert b"\x27\x00\x00\x30\x00" in broker.connects[-1]  # Maximum Packet Size


def test_a_message_of_another_client_is_dropped(tmp_path):
    broker = Broker(tmp_path)
    broker.start()
    plant = Plant(tmp_path, broker.port, "    version: 3.1.1\n")
    (tmp_path / "large").write_bytes(bytes(20 * MEBIBYTE))
    wait_until(lambda: "delivering" in plant.log.read_text())
    time.sleep(0.3)

    def publish(*words):
        subprocess.run(["mosquitto_pub", "-p", str(broker.port), "-q", "1", "-t", TOPIC, *words], check=True)

    def large():
        publish("-f", tmp_path / "large")
        wait_until(lambda: f"on topic {TOPIC}" in plant.log.read_text())
        publish("-m", '{"id":"a","command":"write","variable":"Setpoint","value":5}')
        time.sleep(0.3)

    try:
        assert plant.grown(large) <= ALLOWED
        output = plant.end()
    finally:
        plant.program.kill()
        broker.kill()
    assert (output["commands"], output["commands_refused"], output["mqtt"]["oversized"]) == (1, 0, 1)
    assert output["mqtt"]["lost_connections"] == 0
