"""The project of a plant, and its broker."""
import os
import subprocess

from endpoints import free_port
from ledger import float32

QUOTA_MB = 32
# A value as `takt history --csv` prints it.
VALUES = {
    "Power": lambda text: float32(float(text)),
    "Energy": int,
    "Count": int,
    "Running": "true".__eq__,
    "Label": str
}
SMALL = """
          - {name: Power, type: float, register: 0, read: 0x03, unit: kW}
          - {name: Energy, type: uint32, register: 2, read: 0x03}
          - {name: Count, type: int16, register: 4, read: 0x03}
          - {name: Running, type: bool, register: 5, bit: 0, read: 0x03}
          - {name: Label, type: string, register: 10, length: 8, read: 0x03}"""
# The value of a simulated string is the name of its variable.
LARGE = "".join(
    f"\n          - {{name: {f'T{i:02}':x<128}, type: string, register: {100 * i}, length: 64, read: 0x03}}"
    for i in range(40))
PROJECT = """takt: 1
lines:
  - name: sim
    transport: simulated
    framing: tcp
    devices:
      - name: Meter
        address: 1
        poll_period: {poll_period}
        variables:{variables}
outputs:
  - name: cloud
    transport: mqtt
    brokers: [mqtt://127.0.0.1:{port}]
    topic: {topic}
    message: {message}
    retain: false
    {settings}
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
        if self.process is None:
            path = os.environ["PATH"] + ":/usr/sbin"
            self.process = subprocess.Popen(["mosquitto", "-c", self.config], stderr=subprocess.DEVNULL,
                                            env=os.environ | {"PATH": path})

    def kill(self):
        if self.process is not None:
            self.process.kill()
            self.process.wait()
        self.process = None


def project_text(port, message, large, retention, history):
    """`large`: 2.5 MB of samples a second, and a quota of QUOTA_MB; else some 300 samples a second."""
    settings = f"quota_mb: {QUOTA_MB}\n    period: 2ms" if large else f"retention: {retention}"
    text = PROJECT.format(port=port, message=message, settings=settings, variables=LARGE if large else SMALL,
                          topic="plant/{device}" + ("/{variable}" if message == "variable" else ""),
                          poll_period="500ms" if large else "10ms")
    return text + ("  - name: hist\n    transport: history\n" if history else "")
