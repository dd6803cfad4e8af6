"""takt history of a damaged database: each form reports the damage and shows the rest, exit code 7."""
import shutil
import sqlite3

import pytest

from program import takt

PLANT = """takt: 1
lines:
  - {name: bus, transport: simulated, devices: [{name: Tank, address: 1, poll_period: 20ms, variables: [
      {name: Level, type: int16, register: 0, read: 0x03}]}]}
outputs: [{name: history, transport: history}]
"""
REPORT = "Damaged parts of the database: 1. Samples of these times may be missing"


@pytest.fixture(scope="module", name="written")
def fixture_written(tmp_path_factory):
    """The history of a short run, whole."""
    folder = tmp_path_factory.mktemp("history")
    plant = folder / "plant.yaml"
    plant.write_text(PLANT)
    takt("run", plant, "--for", "1s")
    assert takt("history", plant, "Level", "--csv").lines[1:]
    return folder


@pytest.fixture(name="plant")
def fixture_plant(written, tmp_path):
    """The same with one flipped bit in its largest blob."""
    shutil.copytree(written, tmp_path, dirs_exist_ok=True)
    with sqlite3.connect(tmp_path / "plant.history.db") as database:
        table, row, data = max(
            (((table, *row) for table in ("log", "chunk")
              for row in database.execute(f"SELECT rowid, data FROM {table}"))), key=lambda its: len(its[2]))
        flipped = bytearray(data)
        flipped[len(flipped) // 2] ^= 1
        database.execute(f"UPDATE {table} SET data = ? WHERE rowid = ?", (bytes(flipped), row))
    return tmp_path / "plant.yaml"


def test_as_text(plant):
    result = takt("history", plant, "Level", code=7)
    assert "Level" in result.lines[1] + result.lines[2] and REPORT in result.out, result


def test_as_csv(plant, written):
    result = takt("history", plant, "Level", "--csv", code=7)
    whole = takt("history", written / "plant.yaml", "Level", "--csv")
    damaged = [line for line in result.lines if ",damaged," in line]
    assert len(damaged) == 1 and " until 20" in damaged[0]
    assert set(result.lines) - set(damaged) < set(whole.lines), "the rest is right"
    assert REPORT in result.err


def test_as_json(plant):
    result = takt("history", plant, "Level", "--json", code=7)
    assert [its["part"] in ("log", "chunk") for its in result.json["damage"]] == [True]
    assert REPORT in result.err


def test_the_list_of_variables(plant):
    with sqlite3.connect(plant.with_suffix(".history.db")) as database:
        database.execute("UPDATE series SET unit = 'm'")
    for form in ([], ["--json"]):
        result = takt("history", plant, *form, code=7)
        assert "Damaged parts" in result.out + result.err, result
