"""takt schema: the examples are valid for it, and projects with mistakes are not."""
import copy

import jsonschema
import pytest
import yaml

from program import ROOT, takt

EXAMPLES = sorted((ROOT / "examples").glob("*.yaml"))


@pytest.fixture(scope="module")
def validator():
    schema = takt("schema").json
    jsonschema.Draft202012Validator.check_schema(schema)
    return jsonschema.Draft202012Validator(schema)


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_examples_are_valid(validator, path):
    assert takt("check", path).code == 0
    errors = [
        f"{list(error.absolute_path)}: {error.message}"
        for error in validator.iter_errors(yaml.safe_load(path.read_text(encoding="utf-8")))
    ]
    assert not errors


def put(path, value):
    """A change of a project: the value of a key, or the removal of it."""

    def change(project):
        at = project
        for key in path[:-1]:
            at = at[key]
        if value is None:
            del at[path[-1]]
        else:
            at[path[-1]] = value

    return change


DEVICE = ("lines", 0, "devices", 0)
VARIABLE = DEVICE + ("variables", 0)
WRONG = {
    "unknown key": put(DEVICE + ("adress", ), 1),
    "missing name": put(DEVICE + ("name", ), None),
    "address": put(DEVICE + ("address", ), 300),
    "attempts": put(DEVICE + ("attempts", ), "three"),
    "period without unit": put(DEVICE + ("poll_period", ), "100"),
    "strategy": put(DEVICE + ("strategy", ), "clever"),
    "type": put(VARIABLE + ("type", ), "integer"),
    "function": put(VARIABLE + ("read", ), 0x10),
    "register": put(VARIABLE + ("register", ), 65536),
    "boolean": put(VARIABLE + ("write_on_change", ), "yes"),
    "list": put(("lines", ), {"name": "x"}),
    "transport": put(("lines", 0, "transport"), "udp"),
    "version": put(("takt", ), 2),
}


@pytest.mark.parametrize("name", WRONG)
def test_mistakes_are_not_valid(validator, name):
    project = yaml.safe_load((ROOT / "examples/boiler.yaml").read_text(encoding="utf-8"))
    assert validator.is_valid(project)
    wrong = copy.deepcopy(project)
    WRONG[name](wrong)
    assert not validator.is_valid(wrong)
