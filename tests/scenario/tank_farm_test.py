"""examples/tank-farm.yaml: by itself, and with its devices behind a pair of ptys, polled faster than each
minute."""
import signal

import pytest

from program import ROOT, start, takt, until

TEXT = (ROOT / "examples/tank-farm.yaml").read_text()


def good(name):
    return lambda e: e["event"] == "value" and e["name"] == name and e["quality"] == "good"


def test_every_value_of_the_example_is_read(tmp_path):
    (tmp_path / "plant.yaml").write_text(TEXT)
    with start("run", tmp_path / "plant.yaml", "--json") as run:
        for name in ("Level1", "Level2", "Temperature1", "Temperature2", "HighLimit1", "HighLimit2", "Valve1",
                     "Valve2", "Tripped"):
            run.wait_event(good(name), name)
        run.interrupt()


@pytest.fixture
def plant(tmp_path, pair):
    """The project on a line of its own; its devices are served at the other end."""
    text = TEXT.replace("poll_period: 1min", "poll_period: 300ms").replace("min_interval: 5s",
                                                                           "min_interval: 20ms")
    text = text.replace("response_timeout: 500ms",
                        "response_timeout: 5s").replace("derive_timeouts: true\n", "")
    text = text.replace("byte_timeout: 50ms", "byte_timeout: 1s")  # a busy machine is no broken line
    path = tmp_path / "plant.yaml"
    path.write_text(text.replace("transport: simulated", f"transport: serial\n    port: {pair.a}"))
    with start("serve", path, "--port", pair.b) as served:
        yield path
        served.interrupt()


def test_writes_are_verified_and_retained_values_survive(plant, tmp_path):
    control, frames = tmp_path / "control", tmp_path / "frames"
    with start("run", plant, "--control", control, "--traffic", frames, "--json") as run:
        run.wait_event(good("HighLimit2"), "the limits")
        assert takt("ctl", control, "set", "HighLimit1", 3.5).out == "ok HighLimit1 3.5\n"
        assert takt("ctl", control, "write", "Valve1", 1).out == "done Valve1\n"
        assert takt("ctl", control, "set", "order", 2.25).out == "ok order 2.25\n"
        until(lambda: takt("ctl", control, "get", "HighLimit1").out == "ok HighLimit1 3.5\n", "read again")
        run.process.send_signal(signal.SIGKILL)
        run.process.wait()
    sent = [line.split("] ")[2].split(" |")[0] for line in frames.read_text().splitlines() if " Tx: " in line]
    written = next(i for i, pdu in enumerate(sent) if pdu.startswith("01 10 00 10 00 04"))
    assert sent[written + 1].startswith("01 03 00 10 00 04"), "a write is followed by the read that compares"
    with start("run", plant, "--control", tmp_path / "again", "--json") as run:
        until(lambda: takt("ctl", tmp_path / "again", "get", "order", code=None).out == "ok order 2.25\n",
              "what was ordered")
        run.wait_event(lambda e: good("HighLimit1")(e) and e["value"] == 3.5, "the limit in the device")
        run.interrupt()
