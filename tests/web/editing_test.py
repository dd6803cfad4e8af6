"""The API of editing over HTTP: load, evaluate, compare, save, apply, and the bounds of all that."""
import json
import signal

import pytest

from program import start, until
from web_site import Api

PROJECT = """\
# The plant.
takt: 1
lines:
  - name: bus          # simulated
    transport: simulated
    devices:
      - name: Boiler   # in the cellar
        address: 16
        poll_period: 200ms
        variables:
          - {name: Level, type: float, register: 0, read: 0x03}
locals:
  - {name: go, type: bool}
"""


@pytest.fixture
def plant(tmp_path):
    path = tmp_path / "plant.yaml"
    path.write_text(PROJECT)
    return path


def test_a_saved_project_runs_and_keeps_its_comments(plant):
    with start("run", plant, "--json", "--web", "127.0.0.1:0", "--allow-write") as run:
        api = Api(run)
        run.wait_event(lambda e: e["event"] == "value" and e["name"] == "Level" and e["quality"] == "good",
                       "a value")
        _, project = api("GET", "/project")
        device = project["document"]["lines"][0]["devices"][0]
        device["variables"].append({"name": "Second", "type": "int16", "register": "4", "read": "0x03"})
        status, plan = api("POST", "/project/evaluate", {"document": project["document"]})
        assert status == 200 and any("Second" in r["variables"] for r in plan["lines"][0]["requests"])
        body = {"document": project["document"], "revision": project["revision"], "apply": True}
        _, shown = api("POST", "/project/diff", body)
        assert [line for line in shown["diff"].splitlines() if line[0] in "+-"][2:] == \
            ["+          - {name: Second, type: int16, register: 4, read: 0x03}"]
        status, saved = api("PUT", "/project", body)
        assert status == 200 and saved["applied"], saved
        run.wait_event(lambda e: e["event"] == "value" and e["name"] == "Second" and e["quality"] == "good",
                       "the new value")
        added = "read: 0x03}\n          - {name: Second, type: int16, register: 4, read: 0x03}\n"
        assert plant.read_text() == PROJECT.replace("read: 0x03}\n", added)
        assert plant.with_name("plant.yaml~").read_text() == PROJECT
        status, again = api("PUT", "/project", body)
        assert status == 409 and again["error"]["code"] == "changed_on_disk"
        run.interrupt()


def test_nothing_is_saved_read_only_or_with_errors(plant):
    with start("run", plant, "--json", "--web", "127.0.0.1:0") as run:
        api = Api(run)
        _, project = api("GET", "/project")
        body = {"document": project["document"], "revision": project["revision"], "apply": True}
        status, answer = api("PUT", "/project", body)
        assert status == 403 and answer["error"]["code"] == "read_only"
        project["document"]["lines"][0]["devices"][0]["address"] = "300"
        status, plan = api("POST", "/project/evaluate", {"document": project["document"]})
        assert status == 200 and any(f["path"] == "lines[0].devices[0].address" and f["severity"] == "error"
                                     for f in plan["findings"])
        run.interrupt()
    assert plant.read_text() == PROJECT


def test_texts_are_in_the_language_of_the_request(plant):
    with start("run", plant, "--json", "--web", "127.0.0.1:0") as run:
        api = Api(run)
        texts = {
            api("GET", f"/history/series?lang={language}")[1]["error"]["text"]
            for language in ("en", "ru", "uk")
        }
        assert len(texts) == 3
        run.interrupt(signal.SIGTERM)
