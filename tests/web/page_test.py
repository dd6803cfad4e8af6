"""The page and its API over real sockets: routes as docs/openapi.json lists them, the rules against other
sites, bad requests, browsers that stop reading, and the end of a run."""
import json
import pathlib
import re
import socket

import pytest

from program import DEADLINE, ROOT, WITHOUT_WAITING, start, takt, until
from web_site import Site

PROJECT = """\
takt: 1
lines:
  - name: bus
    transport: simulated
    devices:
      - name: Boiler
        address: 16
        poll_period: 50ms
        variables:
          - {name: Level, type: float, register: 0, read: 0x03}
          - {name: Wanted, type: int16, register: 10, read: 0x03, write: 0x10}
"""
PATHS = json.loads((pathlib.Path(ROOT) / "docs/openapi.json").read_text(encoding="utf-8"))["paths"]


@pytest.fixture
def plant(tmp_path):
    path = tmp_path / "plant.yaml"
    path.write_text(PROJECT)
    return path


@pytest.fixture
def site(plant):
    with start("run", plant, "--json", "--web", "127.0.0.1:0", "--allow-write") as run:
        run.wait_event(lambda e: e["event"] == "value" and e["quality"] == "good", "a value")
        site = Site(run)
        site.run = run
        yield site


def test_every_route_of_the_description_exists(site):
    for path, methods in PATHS.items():
        for method in methods:
            if path in ("/stream", "/traffic"):
                with site.connect() as s:
                    s.sendall(f"GET /api/v1{path} HTTP/1.1\r\nHost: 127.0.0.1:{site.port}\r\n\r\n".encode())
                    assert b"200" in s.recv(64), path
                continue
            status, body = site.get(f"/api/v1{path}") if method == "get" else site.post(path, {})
            assert '"not_found"' not in body or path.startswith("/history"), (path, status, body[:200])
            assert status != 405 or method == "put", (path, status)
    status, body = site.get("/api/v1/nothing")
    assert status == 404 and json.loads(body)["error"]["code"]


def test_info_has_the_version_of_the_program(site):
    status, body = site.get("/api/v1/info")
    assert status == 200
    assert f"takt {json.loads(body)['version']}\n" == takt("--version").out


def test_each_thread_has_a_name(site):
    threads = pathlib.Path(f"/proc/{site.run.process.pid}/task")
    names = sorted((thread / "comm").read_text().strip() for thread in threads.iterdir())
    assert names.count("takt") == 1 and {"takt-io", "takt-web", "takt-live"} <= set(names), names


def test_the_page_is_served_with_its_policy(site):
    status, body = site.get("/")
    assert status == 200 and "<title>Takt</title>" in body
    status, _ = site.get("/app.js")
    assert status == 200


@pytest.mark.parametrize("fields,host,expected", [
    ([], "evil.example", 421),
    (["Origin: http://evil.example"], "127.0.0.1", 403),
    (["Sec-Fetch-Site: cross-site"], "127.0.0.1", 403),
    (["X-Long: " + "a" * 70000], "127.0.0.1", 431),
])
def test_other_sites_are_refused(site, fields, host, expected):
    status, _ = site.get("/api/v1/status", *fields, host=host)
    assert status == expected


def test_changes_need_the_mark_and_json(site):
    head = f"POST /api/v1/commands HTTP/1.1\r\nHost: 127.0.0.1:{site.port}\r\nContent-Length: 2"
    assert site.send(head + "\r\nContent-Type: application/json", "{}")[0] == 403
    assert site.send(head + "\r\nX-Takt: 1\r\nContent-Type: text/plain", "{}")[0] == 415


def test_wrong_commands_say_what_is_wrong(site):
    for body in ({}, {
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
            "kind": "jump",
            "variable": "Wanted",
            "value": 1
    }):
        status, text = site.post("/commands", body)
        answer = json.loads(text)
        assert status >= 400 and answer["error"]["text"] or answer.get("outcome") == "refused", (body, status,
                                                                                                 text)
    status, text = site.post("/commands", {"kind": "write", "variable": "Wanted", "value": 7})
    assert status == 200 and json.loads(text)["outcome"] == "done"


def test_without_allow_write_nothing_changes(plant):
    with start("run", plant, "--json", "--web", "127.0.0.1:0") as run:
        status, text = Site(run).post("/commands", {"kind": "write", "variable": "Wanted", "value": 7})
        assert status == 403 and json.loads(text)["error"]["code"] == "read_only"


def test_another_address_needs_a_token(plant, tmp_path):
    refused = takt("run", plant, "--web", "0.0.0.0:0", code=2)
    assert "--web-token" in refused.err
    token = tmp_path / "token"
    token.write_text("a-long-secret-token\n")
    token.chmod(0o600)
    with start("run", plant, "--json", "--web", "127.0.0.1:0", "--web-token", token) as run:
        site = Site(run)
        assert site.get("/api/v1/status")[0] == 401
        assert site.get("/api/v1/status", "Authorization: Bearer a-long-secret-token")[0] == 200
        assert site.get("/api/v1/status?token=a-long-secret-token")[0] == 200


def test_browsers_that_stop_reading_harm_nobody(site):
    stalled = []
    for path in ["/stream", "/traffic"] * 4:
        s = site.connect()
        s.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        s.sendall(f"GET /api/v1{path} HTTP/1.1\r\nHost: 127.0.0.1:{site.port}\r\n\r\n".encode())
        stalled.append(s)
    halves = [site.connect() for _ in range(40)]
    for s in halves:
        s.sendall(b"GET / HT")
    before = len(site.run.out)
    with site.connect() as s:
        s.sendall(f"GET /api/v1/stream HTTP/1.1\r\nHost: 127.0.0.1:{site.port}\r\n\r\n".encode())
        seen = b""
        while seen.count(b"event: values") < 10:
            got = s.recv(65536)
            assert got, "the stream goes on"
            seen += got
    assert site.get("/api/v1/status")[0] == 200
    until(lambda: len(site.run.out) > before + 5, "polling goes on")
    for s in [*stalled, *halves]:
        s.close()


def test_ctrl_c_ends_with_open_streams(site):
    streams = [site.connect() for _ in range(3)]
    for s in streams:
        s.sendall(f"GET /api/v1/stream HTTP/1.1\r\nHost: 127.0.0.1:{site.port}\r\n\r\n".encode())
        s.recv(100)
    site.run.interrupt(deadline=WITHOUT_WAITING)
    for s in streams:
        s.close()
