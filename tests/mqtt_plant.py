"""A project with an MQTT output, its broker and a subscriber, for tests with real processes."""
import contextlib
import itertools
import json
import os
import pathlib
import signal
import socket
import subprocess

from endpoints import free_port
from program import DEADLINE, TAKT, until

MARK = "test/mark"
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
        wait_until(self._accepts)

    def _accepts(self):
        with socket.socket() as probe:
            return probe.connect_ex(("127.0.0.1", self.port)) == 0

    def kill(self):
        self.process.kill()
        self.process.wait()


class Subscriber:
    """Collects the messages of one broker's life; None: it does not run."""

    _marks = itertools.count()

    def __init__(self, broker, log):
        self._broker, self._path, self.log = broker, pathlib.Path(log), open(log, "ab")
        mark = self._publish("-r")  # the broker answers a subscription with what is retained
        self.process = subprocess.Popen(
            ["mosquitto_sub", "-p",
             str(broker.port), "-t", "#", "-q", "1", "-F", "%t %p"], stdout=self.log)
        until(lambda: mark in self._path.read_text(), "the subscription")

    def _publish(self, *options):
        """Publishes a message that messages() leaves out. Returns its line in the log."""
        number = next(self._marks)
        port, topic = str(self._broker.port), f"{MARK}/{number}"
        command = ["mosquitto_pub", "-p", port, "-q", "1", "-t", topic, "-m", "{}", *options]
        subprocess.run(command, check=True)
        return f"{MARK}/{number} {{}}\n"

    def catch_up(self):
        """Waits for all that the broker accepted before."""
        mark = self._publish()
        until(lambda: mark in self._path.read_text(), "the last message")

    def stop(self):
        self.process.kill()
        self.process.wait()
        self.log.close()


@contextlib.contextmanager
def stopped(program):
    """The program does nothing for a while, so that it does not connect to a broker before the subscriber
    does."""
    program.send_signal(signal.SIGSTOP)
    yield
    program.send_signal(signal.SIGCONT)


def wait_until(condition):
    until(condition, "what the test waits for")


def messages(log):
    """(topic, payload) of each message, in the order of their arrival."""
    written = pathlib.Path(log).read_text()
    parts = (line.split(" ", 1) for line in written[:written.rfind("\n") + 1].splitlines())
    return [(topic, json.loads(payload)) for topic, payload in parts if not topic.startswith(MARK)]


def samples(log):
    return [payload for topic, payload in messages(log) if topic.startswith("plant/")]


def gaps(log):
    return [payload["gap"] for topic, payload in messages(log) if topic.endswith("/gap")]


def run(project, *options):
    return subprocess.Popen([TAKT, "run", project, "--json", *options], stdout=subprocess.PIPE, text=True)


def end(program):
    program.send_signal(signal.SIGINT)
    out, _ = program.communicate(timeout=DEADLINE)
    return json.loads(out.splitlines()[-1])["outputs"][0]
