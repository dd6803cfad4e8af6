"""A project with an MQTT output, its broker and a subscriber, for tests with real processes."""
import json
import os
import pathlib
import signal
import socket
import subprocess
import time

TAKT = os.environ["TAKT"]
PLANT = """
takt: 1
lines:
  - name: sim
    transport: simulated
    framing: tcp
    devices:
      - name: Meter
        address: 1
        poll_period: 50ms
        variables:
          - {{name: Power, type: float, register: 0, read: 0x03, unit: kW}}
          - {{name: Energy, type: uint32, register: 2, read: 0x03}}
outputs:
  - name: cloud
    transport: mqtt
    brokers: [mqtt://127.0.0.1:{port}]
    topic: plant/{{device}}/{{variable}}
    retain: false
"""


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


class Broker:
    """mosquitto without persistence."""

    def __init__(self, folder):
        self.port = free_port()
        self.config = folder / "mosquitto.conf"
        self.config.write_text(f"listener {self.port} 127.0.0.1\nallow_anonymous true\npersistence false\n"
                               "max_queued_messages 0\nuser root\n")
        self.process = None

    def start(self):
        self.process = subprocess.Popen(["mosquitto", "-c", self.config], stderr=subprocess.DEVNULL,
                                        env=os.environ | {"PATH": os.environ["PATH"] + ":/usr/sbin"})
        wait_until(lambda: socket.socket().connect_ex(("127.0.0.1", self.port)) == 0)

    def kill(self):
        self.process.kill()
        self.process.wait()


class Subscriber:
    """Collects the messages of one broker's life; None: it does not run."""

    def __init__(self, broker, log):
        self.log = open(log, "ab")
        self.process = subprocess.Popen(
            ["mosquitto_sub", "-p",
             str(broker.port), "-t", "#", "-q", "1", "-F", "%t %p"], stdout=self.log)
        time.sleep(0.5)  # it does not report that it is subscribed

    def stop(self):
        self.process.terminate()
        try:
            self.process.wait(5)
        except subprocess.TimeoutExpired:  # a signal between its look at the flag and its wait is lost
            self.process.kill()
            self.process.wait()
        self.log.close()


def wait_until(condition, seconds=30):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "waited too long"
        time.sleep(0.05)


def messages(log):
    """(topic, payload) of each message, in the order of their arrival."""
    parts = (line.split(" ", 1) for line in pathlib.Path(log).read_text().splitlines())
    return [(topic, json.loads(payload)) for topic, payload in parts]


def samples(log):
    return [payload for topic, payload in messages(log) if topic.startswith("plant/")]


def gaps(log):
    return [payload["gap"] for topic, payload in messages(log) if topic.endswith("/gap")]


def run(project, *options):
    return subprocess.Popen([TAKT, "run", project, "--json", *options], stdout=subprocess.PIPE, text=True)


def end(program):
    program.send_signal(signal.SIGINT)
    out, _ = program.communicate(timeout=20)
    return json.loads(out.splitlines()[-1])["outputs"][0]
