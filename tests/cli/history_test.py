"""takt history: its errors and exit codes. What it shows is tested with the reports."""
import sqlite3

import pytest

from program import takt


def test_no_database(tmp_path):
    assert "plant.history.db" in takt("history", tmp_path / "plant.yaml", "a", code=2).err


@pytest.mark.parametrize("option, value", [("--from", "yesterday"), ("--to", "2026-02-30"),
                                           ("--from", "now")])
def test_times_that_are_refused(tmp_path, option, value):
    assert value in takt("history", tmp_path / "plant.yaml", "a", f"{option}={value}", code=2).err


def test_a_database_of_another_program(tmp_path):
    path = tmp_path / "plant.history.db"
    with sqlite3.connect(path) as database:
        database.execute("CREATE TABLE a (b)")
    takt("history", tmp_path / "plant.yaml", "a", code=2)
    path.write_text("no database at all")
    takt("history", tmp_path / "plant.yaml", "a", code=2)
