"""More samples than a broker acknowledges: mosquitto as Debian has it (20 messages in flight) behind a delay
of 50 ms each way, and 850 samples a second."""
import contextlib

import pytest

from delaying_proxy import delaying_proxy
from mqtt_plant import Broker, Subscriber, messages
from program import start, takt, until

RATE = 850
DEVICES, VARIABLES = 17, 5


def project_text(port, *keys):
    devices = "".join(f"""
      - name: D{d}
        address: {d + 1}
        poll_period: 100ms
        variables:""" + "".join(f"""
          - {{name: V{d}_{v}, type: int16, register: {v}, read: 0x03}}""" for v in range(VARIABLES))
                      for d in range(DEVICES))
    return f"""
takt: 1
lines:
  - name: sim
    transport: simulated
    framing: tcp
    devices:{devices}
outputs:
  - name: cloud
    transport: mqtt
    brokers: [mqtt://127.0.0.1:{port}]
    topic: plant/{{device}}/{{variable}}
    retain: false
    period: 100ms
""" + "".join(f"    {key}\n" for key in keys)


def status_of(control):
    answer = takt("ctl", control, "status", "--json", code=None)
    return answer.json if answer.out else {}


def output_of(control):
    return (status_of(control).get("outputs") or [{}])[0]


@pytest.fixture
def behind(tmp_path):
    broker = Broker(tmp_path)
    broker.config.write_text(f"listener {broker.port} 127.0.0.1\nallow_anonymous true\n")
    broker.start()

    @contextlib.contextmanager
    def begin(*keys):
        project, control = tmp_path / "plant.yaml", tmp_path / "control"
        project.write_text(project_text(port, *keys))
        with start("run", project, "--control", control) as running:
            until(control.exists, "the control socket")
            yield control
            running.interrupt()

    with delaying_proxy(broker.port, 0.05) as port:
        yield tmp_path, broker, begin
    broker.kill()


def test_an_output_that_falls_behind_says_why(behind):
    _, _, begin = behind
    with begin() as control:
        until(lambda: output_of(control).get("state") == "falls_behind", "the state")
        status = status_of(control)
        text = takt("ctl", control, "status", code=None).out
    output = status["outputs"][0]
    assert status["health"] == "degraded"
    assert output["mqtt"]["window"] == 20
    assert 95 < output["mqtt"]["round_trip_ms"] < 1000
    # 20 messages for each round trip: 200 a second at best.
    assert RATE - 220 < output["falls_behind"]["samples_per_s"] < RATE * 1.1
    assert output["delivered"] < 0.3 * output["sampled"]
    problem = next(problem for problem in status["problems"] if problem["kind"] == "output")
    for shown in (problem["text"], text):
        assert "falls behind:" in shown and "window 20 ×" in shown
    assert "`backlog: array`" in problem["advice"] and "max_inflight_messages" in problem["advice"]


def test_arrays_carry_what_waits(behind):
    folder, broker, begin = behind
    subscriber = Subscriber(broker, folder / "sub")
    with begin("backlog: array") as control:
        until(lambda: output_of(control).get("delivered", 0) > RATE, "some samples")
        made = output_of(control)["sampled"]
        # On an idle machine within 3 s: two rounds of 2 messages of each of 85 topics.
        until(lambda: output_of(control)["delivered"] >= 0.99 * made, "nearly all of them")
        output = output_of(control)
    subscriber.catch_up()
    subscriber.stop()
    arrays, numbers, last = 0, set(), {}
    for topic, payload in messages(folder / "sub"):
        if not topic.startswith("plant/"):
            continue
        arrays += isinstance(payload, list)
        for sample in payload if isinstance(payload, list) else [payload]:
            assert topic == f"plant/{sample['device']}/{sample['variable']}"
            assert sample["seq"] > last.get(topic, 0), "order holds for each topic"
            last[topic] = sample["seq"]
            numbers.add(sample["seq"])
    assert arrays > 100
    # Behind them are messages of portions that were not complete at the end.
    assert numbers.issuperset(range(1, output["delivered"] + 1))
