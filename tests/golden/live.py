"""Cases of a program that runs. What it says depends on time: of each answer its shape is kept."""
import contextlib
import functools
import json
import os
import re

import endpoints
from offline import LANGUAGES
from program import start, takt, until
from web_site import Api

PLANT = """\
takt: 1
lines:
  - name: good
    transport: simulated
    devices:
      - name: Boiler
        address: 16
        poll_period: 200ms
        response_timeout: 10s
        variables:
          - {{name: Level, type: float, register: 0, read: 0x03, unit: m, tags: [daily]}}
          - {{name: Wanted, type: int16, register: 10, read: 0x03, write: 0x10, write_range: 0..100}}
          - {{name: Name, type: string, register: 20, length: 4, read: 0x03}}
          - {{name: Coil, type: bool, coil: 3, write: 0x05, write_trigger: go}}
  - name: dead
    transport: tcp
    host: 127.0.0.1
    tcp_port: {nothing}
    devices:
      - {{name: Gone, address: 1, variables: [{{name: Lost, type: int16, register: 0, read: 0x03}}]}}
locals:
  - {{name: go, type: bool}}
  - {{name: kept, type: int16, default: 5, retain: true}}
servers:
  - name: registers
    listen: 127.0.0.1
    tcp_port: {port}
    units:
      - address: 1
        banks: [{{area: holding_register, items: [0..9]}}]
        variables:
          - {{name: Served, type: float, area: holding_register, register: 0, source: {{variable: Level}}}}
outputs:
  - {{name: history, transport: history}}
  - name: broker
    transport: mqtt
    brokers: ["mqtt://127.0.0.1:{nothing}"]
    topic: "plant/{{device}}/{{variable}}"
"""
LINES = ("transport=serial&framing=rtu", "transport=serial&framing=ascii", "transport=tcp&framing=tcp",
         "transport=simulated&framing=rtu")
ROWS = {
    "table": "Имя;Тип;Регистр;Функция чтения;Период, мс\nA;WORD;0;3;100\nB;REAL;2;3;\nC;BOOL;5;1;x\n",
    "tabs": "name\ttype\tregister\tread\nA\tint16\t0\t0x03\nB\tflaot\t2\t3\n",
    "window": "Имя;Устройство\nАдрес;16\nПериод опроса, мс;100\nГруппировать запросы;Да\n",
    "no heading": "A;int16;0;3\n",
    "nothing": "",
}
GETS = ("/info", "/status", "/values", "/values?pattern=L*&raw=1", "/registers?variable=Level", "/requests",
        "/why?variable=Level", "/why?variable=Lost", "/why?variable=Nothing", "/devices/learnt", "/search",
        "/project", "/history/series", "/history?variable=Nothing", "/events", "/nothing")
CONTROL = ("status", "list", "values", "values L*", "get Level", "get Lost", "get Levl", "set kept 7",
           "set kept x", "set Level 1", "write Wanted 12", "write Wanted 1e9", "write Level 1",
           "write Lost 1", "write Wanted", "fault list", "nothing")
COMMANDS = ({}, {
    "kind": "write",
    "variable": "Nothing",
    "value": 1
}, {
    "kind": "write",
    "variable": "Wanted",
    "value": "x"
}, {
    "kind": "write",
    "variable": "Level",
    "value": 1
}, {
    "kind": "write",
    "variable": "Wanted",
    "value": 12
})
# Keys of texts that differ from run to run.
CHANGING = ("revision", "text", "oldest_waiting", "time", "since", "destination")
# Ports of the servers in the projects.
SERVED = (1502, 1510)
# Objects that are null as long as nothing happened.
PERHAPS = ("delays", "noise", "failure", "falls_behind", "back_off", "turnaround", "late_responses")
# Keys that a value may have.
SOMETIMES = ("previous_poll",)
# Answers whose texts depend on how busy the computer is, and events that each run has.
STRUCTURE = ("/history", "/status", "/events", "/requests", "status")
EVENTS = ("link", "notice", "output", "served", "summary", "value")


def merged(one, other):
    """The shape that has the keys and members of both."""
    if isinstance(one, dict) and isinstance(other, dict):
        return {
            key: merged(one.get(key, other.get(key)), other.get(key, one.get(key)))
            for key in sorted({*one, *other})
        }
    return other if one == 0 else one


def shape(value, words=True):
    """A JSON value without what depends on time: numbers, truth values and null become 0, of texts the digits
    become # (without `words` they are 0 too), the members of a list become one that has the keys of all, or
    the different texts."""
    if isinstance(value, dict):
        return {
            key: 0 if key in PERHAPS else shape(value[key], words and key not in CHANGING)
            for key in sorted(value)
            if key not in SOMETIMES
        }
    if isinstance(value, list):
        members = [shape(member, words) for member in value]
        if not all(isinstance(member, dict) for member in members):
            return sorted({printed(member) for member in members})
        return [functools.reduce(merged, members)] if members else []
    if isinstance(value, str):
        return text_shape(value) if words else 0
    return 0


def text_shape(text):
    """Numbers become #, with their units of time; a run of spaces is one."""
    return re.sub(
        r" +", " ",
        re.sub(r"-?#( (us|ms|s|min|h|d|мкс|мс|с|хв|мин|ч|год|д)\b)+", "#",
               re.sub(r"-?\d+([.,:]\d+)*", "#", text)))


def printed(value):
    return json.dumps(value, ensure_ascii=False, indent=1, sort_keys=True)


@contextlib.contextmanager
def plant(folder, language):
    """A run with one good line, a dead one, a server, a history and a broker that is not there."""
    path = folder / f"plant-{language}.yaml"
    path.write_text(PLANT.format(nothing=endpoints.free_port(), port=endpoints.free_port()), encoding="utf-8")
    control = folder / f"{language}.socket"
    with start("--lang",
               language,
               "run",
               path.name,
               "--json",
               "--web",
               "127.0.0.1:0",
               "--allow-write",
               "--control",
               control,
               cwd=folder) as run:
        api = Api(run)

        def steady():
            values = {v["name"]: v for v in api("GET", "/values")[1]["values"]}
            outputs = {o["name"]: o for o in api("GET", "/status")[1]["outputs"]}
            return values["Level"]["quality"] == "good" and values["Lost"]["quality"] == "bad" and \
                outputs.get("broker", {}).get("failure") and "Level" in str(api("GET", "/history/series")[1])

        until(steady, "a good value, a bad one, one in the history, and a broker that was tried")
        yield run, api, control


def asked(api, method, path, language, body=None):
    status, answer = api(method, f"{path}{'&' if '?' in path else '?'}lang={language}", body)
    return f"{status}\n{printed(shape(answer, words=not path.startswith(STRUCTURE)))}"


def fields(folder):
    """What the page needs to edit: keys of each kind of project, rows of a pasted table."""
    said = {}
    with plant(folder, "en") as (_, api, _control):
        for language in LANGUAGES:
            for profile in ("generic", "owen-kc1"):
                for line in LINES:
                    path = f"/fields?lang={language}&profile={profile}&{line}"
                    said[path] = printed(api("GET", path)[1])
            for name, rows in ROWS.items():
                body = {
                    "text": rows,
                    "profile": "generic",
                    "transport": "serial",
                    "device": "D",
                    "names": ["A"]
                }
                said[f"import {name} {language}"] = printed(api("POST", f"/import?lang={language}", body)[1])
    return said


def edited(document):
    """The document with another first name of each list, and one more variable in each device."""
    for kind in ("lines", "servers", "outputs", "locals", "instruments"):
        for member in document.get(kind, [])[:1] if isinstance(document.get(kind), list) else []:
            member["name"] = f"{member.get('name')}: renamed, 'quoted' #1"
    for line in document.get("lines", []):
        for device in line.get("devices", []):
            if isinstance(device.get("variables"), list):
                device["variables"].append({
                    "name": "added",
                    "type": "float",
                    "register": "900",
                    "read": "0x03"
                })
    return document


@contextlib.contextmanager
def runnable(path, folder):
    """A copy of a project that runs here: its serial ports exist, its servers have free ports. Gives the name
    of the copy and what it has in place of what stands in the project."""
    text = (folder / path).read_text(encoding="utf-8")
    replaced = {f"tcp_port: {port}": f"tcp_port: {endpoints.free_port()}" for port in SERVED}
    with contextlib.ExitStack() as ports:
        for port in sorted(set(re.findall(r"/dev/tty\w+", text))):
            held, slave = os.openpty()
            ports.callback(os.close, held)
            ports.callback(os.close, slave)
            link = folder / port.removeprefix("/dev/")
            link.unlink(missing_ok=True)
            link.symlink_to(os.ttyname(slave))
            replaced[port] = link.name
        for was, now in replaced.items():
            text = text.replace(was, now)
        copy = folder / path.parent / f"live-{path.name}"
        copy.write_text(text, encoding="utf-8")
        yield copy.relative_to(folder), {now.split()[-1]: was.split()[-1] for was, now in replaced.items()}


def project_texts(path, folder):
    """What the page shows of a project and of a change to it, and the difference that saving would make."""
    said = {}
    with runnable(path, folder) as (copy, replaced), \
            start("run", copy, "--web", "127.0.0.1:0", "--allow-write", "--quiet", cwd=folder) as run:
        until(lambda: run.process.poll() is not None or any("http://" in x for x in [*run.err, *run.out]),
              "a page")
        if run.process.poll() is not None:
            done = run.finish(code=None)
            said["run"] = f"exit code {done.code}\n{done.out}--- stderr\n{done.err}"
        else:
            said = page_texts(Api(run))
            run.process.terminate()
            run.finish(code=None)
    for now, was in replaced.items():
        whole = rf"(?<![\d.]){re.escape(now)}(?!\d)"  # a port, not the middle of another number
        said = {name: re.sub(whole, was, text) for name, text in said.items()}
    return {name: text.replace(str(folder), "FOLDER") for name, text in said.items()}


def page_texts(api):
    project = api("GET", "/project")[1]
    revision = project.pop("revision")
    said = {"document": printed(project)}
    for language in LANGUAGES:
        body = {"document": project["document"]}
        status, plan = api("POST", f"/project/evaluate?measures=1&lang={language}", body)
        text = printed(plan | {"took_ms": 0})
        if "learn" in said["document"]:  # what was learnt so far is a part of the load
            text = re.sub(r'"share": [\d.]+', '"share": 0', text)
        said[f"evaluate {language}"] = f"{status}\n{text}"
    body = {"document": edited(project["document"]), "revision": revision, "apply": True}
    return said | {"diff": printed(api("POST", "/project/diff", body)[1])}


def controlled(control, language, command, form):
    """What `takt ctl` prints: of JSON the shape, of lines the text without numbers."""
    done = takt("--lang", language, "ctl", *form.split(), control, *command.split(), code=None)
    out = "\n".join(text_shape(line) for line in done.lines)
    if form and done.out.startswith("{"):
        out = printed(shape(json.loads(done.out), words=command not in STRUCTURE))
    return f"exit code {done.code}\n{out}\n--- stderr\n{text_shape(done.err)}"


def answers(folder):
    """Answers of API and control socket, and the end of a run, in three languages."""
    said = {}
    for language in LANGUAGES:
        with plant(folder, language) as (run, api, control):
            for path in GETS:
                said[f"GET {path} {language}"] = asked(api, "GET", path, language)
            for number, body in enumerate(COMMANDS):
                for path in ("/commands/preview", "/commands"):
                    said[f"POST {path} {number} {language}"] = asked(api, "POST", path, language, body)
            for command in CONTROL:
                for form in ["--json"] if command in STRUCTURE else ["--json", ""]:
                    said[f"ctl {command} {form} {language}"] = controlled(control, language, command, form)
            run.interrupt()
            for event in (event for event in run.events() if event["event"] in EVENTS):
                name = f"event {event['event']} {language}"
                said[name] = printed(merged(shape(event, words=False), json.loads(said.get(name, "{}"))))
    return {name: text.replace(text_shape(str(folder)), "FOLDER") for name, text in said.items()}
