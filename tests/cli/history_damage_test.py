"""takt history of a damaged database: each form reports the damage and shows the rest, exit code 7."""
import contextlib
import shutil
import sqlite3

import pytest

from program import takt

PLANT = """takt: 1
lines:
  - {name: bus, transport: simulated, devices: [{name: Tank, address: 1, poll_period: 20ms, variables: [
      {name: Level, type: int16, register: 0, read: 0x03},
      {name: Flow, type: int16, register: 1, read: 0x03}]}]}
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


def change_page(plant, name, change):
    """Changes the first page of a table or an index."""
    path = plant.with_suffix(".history.db")
    with contextlib.closing(sqlite3.connect(path)) as database:
        database.execute("PRAGMA wal_checkpoint(TRUNCATE)")
        (page,) = database.execute("SELECT rootpage FROM sqlite_master WHERE name = ?", (name,)).fetchone()
    data = bytearray(path.read_bytes())
    begin = (page - 1) * 4096
    data[begin:begin + 4096] = change(data[begin:begin + 4096])
    path.write_bytes(data)


def test_a_damaged_variable_is_no_unknown_one(written, tmp_path):
    shutil.copytree(written, tmp_path, dirs_exist_ok=True)
    plant = tmp_path / "plant.yaml"
    with sqlite3.connect(tmp_path / "plant.history.db") as database:
        database.execute("UPDATE series SET unit = 'm' WHERE name = 'Level'")
    whole = takt("history", written / "plant.yaml", "Flow", "--csv").lines
    csv = takt("history", plant, "Level", "Flow", "--csv", code=7)
    assert whole[1:] and set(whole) <= set(csv.lines), csv
    assert [line for line in csv.lines if line.startswith("Level,20") and ",damaged,series until 20" in line]
    json = takt("history", plant, "Level", "Flow", "--json", code=7).json
    assert [its["name"] for its in json["variables"]] == ["Flow"]
    assert [(its["part"], its["variable"]) for its in json["damage"]] == [("series", "Level")]
    assert json["damage"][0]["samples"] > 0
    text = takt("history", plant, "Level", "Flow", code=7)
    assert "nearest" not in text.out + text.err and REPORT in text.out, text
    assert "the nearest is `Flow`" in takt("history", plant, "Flop", code=2).err


@pytest.mark.parametrize("length", (512, 4096))
def test_no_row_of_a_variable_is_left(written, tmp_path, length):
    shutil.copytree(written, tmp_path, dirs_exist_ok=True)
    change_page(tmp_path / "plant.yaml", "series", lambda page: page[:-length] + bytes(length))
    for form in ([], ["--csv"], ["--json"], ["--svg", "-"]):
        result = takt("history", tmp_path / "plant.yaml", "Level", "Flow", *form, code=7)
        report = result.out if not form else result.err
        assert "Damaged parts of the database: 2" in report and "empty" not in result.err, result


def test_a_file_that_is_set_aside_leaves_its_name_and_a_gap(written, tmp_path):
    shutil.copytree(written, tmp_path, dirs_exist_ok=True)
    plant = tmp_path / "plant.yaml"
    change_page(plant, "rollup", lambda page: bytes(4096))
    run = takt("run", plant, "--for", "1s")
    aside = f"damaged file moved to {tmp_path}/plant.history.db.damaged-1"
    assert aside in run.out[:run.out.index("output history: ended")], run
    result = takt("history", plant, "Level", code=7)
    assert "journal or history damaged" in result.out and "gap that the writer recorded" in result.out, result


def test_a_damaged_index_is_built_again(written, tmp_path):
    shutil.copytree(written, tmp_path, dirs_exist_ok=True)
    plant = tmp_path / "plant.yaml"
    change_page(plant, "rollup_by_end", lambda page: page[:12] + bytes([page[12] ^ 1]) + page[13:])
    before = takt("history", plant, "Level", "--csv").lines
    run = takt("run", plant, "--for", "1s")
    assert "damaged file moved" not in run.out, run
    assert before[1:] and set(before) < set(takt("history", plant, "Level", "--csv").lines)
