"""gaps: learn with the real program over a pty: a device that refuses unused registers."""
import json
import pathlib

from fake_slave import SerialSlave
from frames import request
from program import start, takt, until

GAPS = 5
PROJECT = """takt: 1
lines:
  - name: field
    port: {port}
    baud: 115200
    devices:
      - name: Boiler
        address: 16
        poll_period: 400ms
        turnaround: 40ms
        response_timeout: 10s
        group_requests: true
        strategy: optimal
        gaps: learn
        variables:
""" + "".join(f"          - {{name: V{i}, register: {5 * i}, type: int16, read: 0x03}}\n"
              for i in range(GAPS + 1))


class Device:
    """Registers that hold their own number; reads that touch `lacks` are refused."""

    def __init__(self, lacks=(), code=2):
        self.lacks, self.code, self.asked = set(lacks), code, 0

    def __call__(self, frame):
        start, count = frame[2] << 8 | frame[3], frame[4] << 8 | frame[5]
        items = range(start, start + count)
        if self.lacks.intersection(items):
            self.asked += 1
            return request("rtu", frame[0], f"83 {self.code:02X}")
        return request("rtu", frame[0], f"03 {2 * count:02X} " + " ".join(f"{i:04X}" for i in items))


def reads(slave):
    """The last reads as (start, count), oldest first."""
    return [(f[2] << 8 | f[3], f[4] << 8 | f[5]) for f in slave.seen[-4:]]


def write_project(path, port):
    path.write_text(PROJECT.replace("{port}", str(port)))
    return path


def learnt(result):
    return lambda e: e["event"] == "learnt" and e["result"] == result


def known(project):
    path = project.with_suffix(".learnt.json")
    return json.loads(path.read_text())["lines"][0]["devices"][0]["areas"][0] if path.exists() else None


def planned(project):
    return takt("plan", project, "--json").json["lines"][0]


def test_the_bad_gap_is_given_up_and_remembered_after_a_kill(tmp_path, pair):
    project = write_project(tmp_path / "plant.yaml", pair.a)
    line = planned(project)
    assert [(r["start"], r["quantity"]) for r in line["requests"]] == [(0, 26)]
    assert len(line["learnt"][0]["untried"]) == GAPS
    device = Device({12})
    with SerialSlave(pair.b, device) as slave:
        with start("run", project, "--json") as run:
            event = run.wait_event(learnt("refused"), "a gap is given up")
            seen = [event[key] for key in ("device", "function", "first", "last", "exception")]
            assert seen == ["Boiler", 3, 11, 14, 2]
            until(lambda: set(reads(slave)) == {(0, 11), (15, 11)}, "two reads around the gap")
            until(lambda: (known(project) or {}).get("refused"), "it is written down")
            run.process.kill()
            run.process.wait()
        for event in run.events():
            assert event["event"] != "value" or not event["reason"].startswith("exception"), event
        asked = device.asked
        assert 3 <= asked <= 3 + 2 * 3, "bisected, and confirmed"
        line = planned(project)
        assert [(r["start"], r["quantity"]) for r in line["requests"]] == [(0, 11), (15, 11)]
        assert [(r["first"], r["last"], r["exception"])
                for r in line["learnt"][0]["refused"]] == [(11, 14, 2)]
        assert not line["learnt"][0]["untried"]
        assert "11..14 (exception 2" in takt("plan", project).out
        seen = len(slave.seen)
        with start("run", project, "--json") as run:
            run.wait_event(lambda e: e["event"] == "value" and e["name"] == "V5" and e["value"] == 25,
                           "a value")
            until(lambda: len(slave.seen) > seen + 10, "some rounds")
            run.interrupt()
        assert {(f[2] << 8 | f[3], f[4] << 8 | f[5]) for f in slave.seen[seen:]} == {(0, 11), (15, 11)}
        assert device.asked == asked, "what is known is not tried again"


def test_a_device_that_refuses_a_gap_later(tmp_path, pair):
    project = write_project(tmp_path / "plant.yaml", pair.a)
    device = Device()
    with SerialSlave(pair.b, device) as slave, start("run", project, "--json") as run:
        run.wait_event(learnt("confirmed"), "all is well")
        until(lambda: set(reads(slave)) == {(0, 26)}, "one read")
        device.lacks = {22}
        run.wait_event(learnt("doubted"), "it is refused now")
        run.wait_event(learnt("refused"), "and given up")
        until(lambda: set(reads(slave)) == {(0, 21), (25, 1)}, "two reads around the gap")
        run.interrupt()
        for event in run.events():
            assert event["event"] != "value" or event["quality"] != "bad" or "exception" not in event[
                "reason"], event


def test_a_damaged_file_is_reported_and_not_changed(tmp_path, pair):
    project = write_project(tmp_path / "plant.yaml", pair.a)
    path = pathlib.Path(tmp_path / "plant.learnt.json")
    path.write_text('{"takt_learnt": 1, "lines": [')
    finding = next(f for f in takt("plan", project, "--json").json["findings"]
                   if f["code"].startswith("learnt"))
    assert (finding["code"], finding["severity"], finding["file"]) == ("learnt.damaged", "warning", str(path))
    with SerialSlave(pair.b, Device({12})) as slave, start("run", project, "--json") as run:
        run.wait_event(learnt("refused"), "it learns all the same")
        until(lambda: set(reads(slave)) == {(0, 11), (15, 11)}, "two reads around the gap")
        assert "plant.learnt.json" in run.interrupt().err
    assert path.read_text() == '{"takt_learnt": 1, "lines": [', "not overwritten"


def test_another_device_under_that_name(tmp_path, pair):
    project = write_project(tmp_path / "plant.yaml", pair.a)
    with SerialSlave(pair.b, Device({12})), start("run", project, "--json") as run:
        run.wait_event(learnt("refused"), "a gap is given up")
        until(lambda: (known(project) or {}).get("refused"), "it is written down")
        run.interrupt()
    project.write_text(project.read_text().replace("address: 16", "address: 17"))
    result = takt("plan", project, "--json").json
    assert "learnt.stale" in [f["code"] for f in result["findings"]]
    assert not result["lines"][0]["learnt"][0]["refused"]
