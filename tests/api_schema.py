"""Answers and stream events of the API against docs/openapi.json. No key may be there that it lacks."""
import functools
import json
import pathlib

import jsonschema

SCHEMAS = "#/components/schemas/"
DESCRIPTION = json.loads(
    (pathlib.Path(__file__).resolve().parent.parent / "docs/openapi.json").read_text(encoding="utf-8"))
# The schemas of the events of /stream.
STREAM = {
    "snapshot": "Snapshot",
    "values": "ValueBatch",
    "reads": "ReadBatch",
    "status": "Status",
    "notice": "Notice"
}


def closed(schema, part_of_all=False):
    """The schema without further keys; `part_of_all`: one of allOf, which closes them together."""
    if isinstance(schema, list):
        return [closed(item) for item in schema]
    if not isinstance(schema, dict):
        return schema
    if part_of_all and "$ref" in schema:
        return {"$ref": schema["$ref"].replace(SCHEMAS, SCHEMAS + "open-")}
    made = {key: closed(value) for key, value in schema.items() if key != "allOf"}
    if "allOf" in schema:
        made["allOf"] = [closed(part, True) for part in schema["allOf"]]
        made["unevaluatedProperties"] = False
    elif schema.get("properties") and "additionalProperties" not in schema and not part_of_all:
        made["additionalProperties"] = False
    return made


@functools.cache
def definitions():
    schemas = DESCRIPTION["components"]["schemas"]
    made = {name: closed(schema) for name, schema in schemas.items()}
    made |= {f"open-{name}": closed(schema, True) for name, schema in schemas.items()}
    return made


@functools.cache
def validator(text):
    schema = {**closed(json.loads(text)), "components": {"schemas": definitions()}}
    return jsonschema.Draft202012Validator(schema)


def check(schema, value, what):
    best = jsonschema.exceptions.best_match(validator(json.dumps(schema)).iter_errors(value))
    assert best is None, f"{what}: {'/'.join(map(str, best.absolute_path))}: {best.message[:600]}"


def check_answer(method, path, status, body):
    """An answer with JSON of a route of the API; others are not looked at."""
    route = path.split("?")[0].removeprefix("/api/v1")
    operation = DESCRIPTION["paths"].get(route, {}).get(method.lower())
    if operation is None or not body.startswith("{"):
        return
    if status != 200:
        check({"$ref": SCHEMAS + "Error"}, json.loads(body), f"{method} {route} {status}")
        return
    content = operation["responses"]["200"]["content"].get("application/json")
    if content:
        check(content["schema"], json.loads(body), f"{method} {route}")


def check_event(name, data):
    """An event of /stream."""
    check({"$ref": SCHEMAS + STREAM[name]}, data, f"event {name}")
