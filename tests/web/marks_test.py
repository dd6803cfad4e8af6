"""Marks of the trends over the end of a program: a restart, a kill, a damaged file, and a folder that cannot
be written."""
import json
import re
import subprocess

import pytest

from program import TAKT, Running, start, until
from web_site import Api

PROJECT = """\
takt: 1
lines:
  - name: bus
    transport: simulated
    devices:
      - name: Boiler
        address: 16
        poll_period: 100ms
        variables:
          - {name: Wanted, type: int16, register: 0, read: 0x03, write: 0x10}
outputs:
  - {name: history, transport: history}
"""


@pytest.fixture
def plant(tmp_path):
    path = tmp_path / "plant.yaml"
    path.write_text(PROJECT)
    return path


def run(plant, *options):
    return start("run", plant, "--quiet", "--web", "127.0.0.1:0", "--allow-write", *options)


def write(api, value):
    status, outcome = api("POST", "/commands", {"kind": "write", "variable": "Wanted", "value": str(value)})
    assert (status, outcome["outcome"]) == (200, "done"), outcome


def commands(api, language="en"):
    events = api("GET", f"/events?lang={language}")[1]["events"]
    assert [e["time"] for e in events] == sorted(e["time"] for e in events)
    return [e["text"].removesuffix(OUTCOME) for e in events if e["kind"] == "command"]


OUTCOME = ": acknowledged, not read back"


def text_of(path):
    return path.read_text() if path.exists() else ""


def marks_of(plant):
    """The texts of the file's marks."""
    lines = text_of(plant.with_name("plant.marks.jsonl")).splitlines()
    return [json.loads(line)["en"].removesuffix(OUTCOME) for line in lines[1:]]


def test_a_restart_keeps_marks(plant):
    for round in range(3):
        with run(plant) as takt:
            api = Api(takt)
            until(lambda: len(commands(api)) == round, f"the marks of {round} earlier runs")
            write(api, round)
            since = api("GET", "/events")[1]["since"]
            takt.process.terminate()
            takt.finish()
    with run(plant) as takt:
        api = Api(takt)
        until(lambda: commands(api) == ["Wanted = 0", "Wanted = 1", "Wanted = 2"], "all marks")
        events = api("GET", "/events")[1]
        assert events["since"] == since, "nothing was dropped since the first run"
        assert {e.get("origin") for e in events["events"] if e["kind"] == "command"} == {"127.0.0.1"}
        assert sum(e["text"] == "Boiler: answering" for e in events["events"]) >= 3
        assert api("GET", "/events?lang=ru")[1]["events"][0]["text"] != events["events"][0]["text"]


def test_a_kill_keeps_what_was_written(plant):
    with run(plant) as takt:
        write(Api(takt), 7)
        until(lambda: "Wanted = 7" in marks_of(plant), "the mark in the file")
        takt.process.kill()
    with run(plant) as takt:
        api = Api(takt)
        until(lambda: commands(api) == ["Wanted = 7"], "the mark")


def test_a_torn_end_is_cut_and_reported(plant, tmp_path):
    with run(plant) as takt:
        write(Api(takt), 7)
        until(lambda: "Wanted = 7" in marks_of(plant), "the mark in the file")
        takt.process.kill()
    with plant.with_name("plant.marks.jsonl").open("ab") as file:
        file.write(b'{"time":1795619061087,"kind":"comm')
    with run(plant, "--log", tmp_path / "log") as takt:
        api = Api(takt)
        until(lambda: commands(api) == ["Wanted = 7"], "the mark")
        until(lambda: "34 bytes that are no mark" in text_of(tmp_path / "log"), "the message")
    assert not list(tmp_path.glob("*.damaged-*"))


@pytest.mark.parametrize("foreign", [b"\x00\xff" * 5000, b"takt: 1\n", b"[" * 100_000 + b"\n", b"{}\n{}\n"],
                         ids=["bytes", "yaml", "nesting", "json"])
def test_a_foreign_file_is_set_aside(plant, tmp_path, foreign):
    plant.with_name("plant.marks.jsonl").write_bytes(foreign)
    with run(plant, "--log", tmp_path / "log") as takt:
        api = Api(takt)
        write(api, 7)
        until(lambda: "Wanted = 7" in marks_of(plant), "the mark in the file")
        assert commands(api) == ["Wanted = 7"]
    assert (tmp_path / "plant.marks.jsonl.damaged-1").read_bytes() == foreign
    assert "moved to" in (tmp_path / "log").read_text()


def test_a_second_program_keeps_its_marks_in_memory(plant, tmp_path):
    with run(plant) as first:
        write(Api(first), 1)
        until(lambda: "Wanted = 1" in marks_of(plant), "the mark in the file")
        with run(plant, "--log", tmp_path / "log") as second:
            until(lambda: "plant.marks.jsonl: used by another program" in text_of(tmp_path / "log"),
                  "the message")
            api = Api(second)
            write(api, 2)
            assert commands(api) == ["Wanted = 2"]
        assert "Wanted = 2" not in marks_of(plant)


def test_a_project_without_a_history_has_no_file(plant):
    plant.write_text(PROJECT[:PROJECT.index("outputs:")])
    with run(plant) as takt:
        api = Api(takt)
        write(api, 1)
        assert commands(api) == ["Wanted = 1"]
        takt.process.terminate()
        takt.finish()
    assert [p.name for p in plant.parent.iterdir() if "marks" in p.name] == []


def test_a_read_only_folder_costs_the_file_only(plant, tmp_path):
    """The folder is a read-only mount of the program's own mount namespace."""
    folder, log = tmp_path / "read_only", tmp_path / "log"
    folder.mkdir()
    plant = plant.rename(folder / plant.name)
    mounted = [
        "unshare", "-m", "sh", "-c",
        f"mount --bind {folder} {folder} && mount -o remount,bind,ro {folder} && exec \"$@\"", "sh"
    ]
    if subprocess.run([*mounted, "true"], check=False, capture_output=True).returncode:
        pytest.skip("nothing can be mounted here")
    with Running(
        [*mounted, TAKT, "run", plant, "--quiet", "--web", "127.0.0.1:0", "--allow-write", "--log",
         log]) as takt:
        api = Api(takt)
        write(api, 1)
        until(lambda: re.search("marks of trends cannot .*Read-only file system", text_of(log)),
              f"the message\n{takt!r}")
        assert commands(api) == ["Wanted = 1"]
        assert any("marks of trends cannot be written" in e["text"]
                   for e in api("GET", "/events")[1]["events"])
    assert not plant.with_name("plant.marks.jsonl").exists()
