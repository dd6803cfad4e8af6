"""Every output of the program for fixed inputs, byte by byte beside the stored ones: what a change does to
any of them is seen here. `./dev golden --accept` stores them anew."""
import os
import pathlib

import live
import offline
import pytest
import records

ACCEPT = os.environ.get("TAKT_GOLDEN") == "accept"


def compare(group, texts):
    if ACCEPT:
        records.accept(group, texts)
    said = records.difference(records.stored(group), texts)
    assert not said, f"\n{said}\n\nIf this was meant: ./dev golden --accept"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    made = tmp_path_factory.mktemp("golden") / "in"
    made.mkdir()
    offline.lay(made)
    return made


@pytest.mark.parametrize("path", offline.projects(), ids=lambda p: p.stem)
def test_project(folder, path):
    made = offline.texts(offline.project_cases(path), folder) | offline.table_texts(path, folder)
    compare(f"project-{path.stem}", made | live.project_texts(path, folder))


def test_broken_projects(folder):
    cases = [case for path in offline.projects() for case in offline.broken(folder / path, folder)]
    compare("broken", offline.texts(cases, folder))


def test_captures(folder):
    compare("captures", offline.texts(offline.capture_cases(folder), folder))


def test_commands(folder):
    compare("commands", offline.texts(offline.command_cases(), folder))


def test_answers_of_a_run(folder):
    compare("answers", live.answers(folder))


def test_fields_and_pasted_rows(folder):
    compare("fields", live.fields(folder))


def test_nothing_is_stored_without_a_case():
    groups = {f"project-{p.stem}" for p in offline.projects()
             } | {"broken", "captures", "commands", "answers", "fields"}
    assert {pathlib.Path(p.stem).stem for p in records.DATA.iterdir()} == groups
