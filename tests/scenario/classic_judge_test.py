"""Random projects through `takt plan --json`, judged by a second implementation of `classic` that is written
from docs/specification.md, sections 3 and 4. Nothing is shared with the planner."""
import random

import pytest

from program import takt

COUNT = {"bool": 1, "int16": 1, "uint16": 1, "int32": 2, "uint32": 2, "float": 2}
KIND = {"int16": "int", "uint16": "int", "int32": "two", "uint32": "two", "float": "two", "bool": "bool"}
LIMIT = {1: 2000, 2: 2000, 3: 125, 4: 125, 5: 1, 6: 1, 15: 1968, 16: 123}
LOCALS = "locals: [{name: t1, type: bool}, {name: t2, type: bool}, " \
    "{name: s1, type: int}, {name: s2, type: int}]"


def random_variables(random_, prefix):
    """Runs of neighbours with few disturbances, among them several variables at one register."""
    made, register, bit = [], random_.randrange(20), 0
    base = {"type": "int16", "read": 3, "write": 16, "on_change": True, "period": 100, "status": None,
            "read_trigger": None, "write_trigger": None}
    for i in range(random_.randint(1, 24)):
        step = random_.randrange(14)
        if step == 0:
            base["type"] = random_.choice(list(COUNT))
        elif step == 1:
            base["read"] = random_.choice([None, 3, 3, 4])
        elif step == 2:
            base["write"] = random_.choice([None, 16, 16, 6])
        elif step == 3:
            base["on_change"] = random_.random() < 0.6
        elif step == 4:
            base["period"] = random_.choice([100, 200])
        elif step == 5:
            base["status"] = random_.choice([None, "s1", "s2"])
        elif step == 6:
            base[random_.choice(["read_trigger", "write_trigger"])] = random_.choice([None, "t1", "t2"])
        elif step == 7:
            register = random_.randrange(40)
        v = dict(base, name=f"{prefix}v{i}", register=register, bit=None)
        if v["type"] == "bool":
            v["bit"] = bit
            if v["read"] != 3:
                v["read"] = random_.choice([1, 2]) if v["read"] else None
                v["write"] = random_.choice([None, 5, 15]) if v["read"] != 2 else None
            else:
                v["write"] = None
            bit = (bit + random_.choice([1, 1, 1, 2])) % 16
            register += bit == 0
        else:
            if v["read"] == 4 or (COUNT[v["type"]] == 2 and v["write"] == 6):
                v["write"] = None
            register += random_.choice([COUNT[v["type"]]] * 6 + [0, 1, 3])
        if v["read"] is None and v["write"] is None:
            v["read"] = 2 if v["type"] == "bool" else 4
        if v["write"] is None:
            v |= {"write_trigger": None, "on_change": False}
        if v["read"] is None:
            v["read_trigger"] = None
        made.append(v)
    random_.shuffle(made)
    return made


def follows(a, b, write):
    if b["type"] == "bool":
        adjoins = a["type"] == "bool" and a["register"] == b["register"] and b["bit"] == a["bit"] + 1
    else:
        adjoins = b["register"] == a["register"] + COUNT[a["type"]]
    same = ["status", "period"]
    same += ["write", "write_trigger", "on_change"] if write else ["read", "read_trigger"]
    alone = write and b["write"] in (5, 6)
    return adjoins and KIND[a["type"]] == KIND[b["type"]] and all(a[k] == b[k] for k in same) and not alone


def entries_of(variables, most):
    """(read function, write function, names) of each entry."""
    number, entries = {}, []
    for write in (False, True):
        function = "write" if write else "read"
        taking = [v for v in variables if v[function] and (not write or v["on_change"] or v["write_trigger"])]
        taking.sort(key=lambda v: (v[function], v["register"], v["bit"] or 0))  # stable
        for v in taking:
            number.setdefault(v["name"], len(number) + 1)
        groups = []
        for v in taking:
            last = groups[-1] if groups else None
            items = sum(COUNT[its["type"]] for its in [*(last or []), v])
            if last and items <= min(LIMIT[v[function]], most) and follows(
                    last[-1], v, write) and number[v["name"]] == number[last[-1]["name"]] + 1:
                last.append(v)
            else:
                groups.append([v])
        for group in groups:
            names = [v["name"] for v in group]
            partners = [e for e in entries if write and e[0] and e[2][0] == names[0]]
            if partners and len(partners[0][2]) == len(names):
                partners[0][1] = group[0]["write"]
            else:
                functions = [None, group[0]["write"]] if write else [group[0]["read"], None]
                entries.append([*functions, names])
    return sorted(map(tuple, entries), key=str)


def as_text(v):
    keys = [f"{k}: {v[k]}" for k in ("name", "type", "register")] + [f"period: {v['period']}ms"]
    keys += [f"{k}: {v[k]}" for k in ("status", "read_trigger", "write_trigger", "bit") if v[k] is not None]
    keys += [f"{k}: {'none' if v[k] is None else v[k]}" for k in ("read", "write")]
    return "{" + ", ".join(keys + [f"write_on_change: {str(v['on_change']).lower()}"]) + "}"


@pytest.mark.parametrize("seed", range(4))
def test_400_random_projects_are_grouped_like_the_reference(project, seed):
    random_ = random.Random(seed)
    text, expected = [f"takt: 1\n{LOCALS}\nlines:"], []
    for line in range(100):
        most = random_.choice([2, 3, 4, 7, 16, 125])
        variables = random_variables(random_, f"l{line}")
        expected.append(entries_of(variables, most))
        text.append(f"  - {{name: l{line}, port: /dev/ttyS{line}, baud: 9600, devices: [{{name: d, "
                    "address: 1, group_requests: true, strategy: classic, "
                    f"registers_per_request: {most}, variables: [")
        text += [f"      {as_text(v)}," for v in variables] + ["  ]}]}"]
    plan = takt("plan", project("\n".join(text) + "\n"), "--json", code=None).json
    for line, reference in zip(plan["lines"], expected, strict=True):
        got = [(r["function"], r["write_function"], r["variables"]) for r in line["requests"]]
        assert sorted(got, key=str) == reference, line["name"]
