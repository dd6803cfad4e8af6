"""Visitors of the page who take all they can get, beside others who use it: evaluations, announced bodies,
streams. A visitor is an address: 127.0.0.2 is another one than 127.0.0.1."""
import json
import random
import re
import signal
import socket
import time

import pytest

from program import DEADLINE, start, until

PROJECT = """\
takt: 1
lines:
  - name: bus
    transport: simulated
    devices:
      - name: Boiler
        address: 16
        poll_period: 100ms
        variables:
          - {name: Level, type: float, register: 0, read: 0x03}
"""
# An answer that waits for nothing else comes within this time, also on a busy machine.
SOON = 3.0


def slow_document(devices=40, variables=250):
    """Evaluated with measures it takes some seconds: scattered registers on a line that is too slow."""
    choose = random.Random(1)

    def variable(device, number, register):
        return {"name": f"V{device}_{number}", "type": "float", "register": str(register), "read": "0x03",
                "period": choose.choice(("10s", "15s", "23s", "37s"))}

    return {"takt": "1", "lines": [{
        "name": "bus", "transport": "simulated", "baud": "115200",
        "devices": [{
            "name": f"D{d}", "address": str(d + 1), "poll_period": "1s",
            "variables": [variable(d, v, r)
                          for v, r in enumerate(sorted(choose.sample(range(0, 60000, 2), variables)))]
        } for d in range(devices)]
    }]}


SLOW = json.dumps({"document": slow_document()}, separators=(",", ":"))


class Visitor:
    """Requests from one address."""

    def __init__(self, run, address):
        self.port = int(until(lambda: next((m for line in [*run.err, *run.out]
                                            if (m := re.search(r"http://127\.0\.0\.1:(\d+)/", line))), None),
                              f"an address\n{run!r}")[1])
        self.address = address

    def send(self, head, body="", announced=None):
        """A connection with a request that is sent."""
        size = len(body) if announced is None else announced
        s = socket.create_connection(("127.0.0.1", self.port), DEADLINE, (self.address, 0))
        fields = f"Host: 127.0.0.1:{self.port}\r\nX-Takt: 1\r\nContent-Type: application/json\r\n"
        length = f"Content-Length: {size}\r\n" if size else ""
        s.sendall(f"{head} HTTP/1.1\r\n{fields}{length}\r\n{body}".encode())
        return s

    def get(self, path):
        return answer(self.send(f"GET /api/v1{path}"))

    def post(self, path, body):
        return answer(self.send(f"POST /api/v1{path}", json.dumps(body)))

    def evaluate(self, client, body=SLOW):
        return self.send(f"POST /api/v1/project/evaluate?measures=1&client={client}", body)


def answer(connection, limit=DEADLINE):
    """Status and body; the connection is closed."""
    with connection as s:
        s.settimeout(limit)
        got = b""
        while b"\r\n\r\n" not in got:
            more = s.recv(65536)
            assert more, got
            got += more
        head, _, rest = got.partition(b"\r\n\r\n")
        length = re.search(rb"(?i)content-length: (\d+)", head)
        while length and len(rest) < int(length[1]) and (more := s.recv(65536)):
            rest += more
    return int(head.split()[1]), rest.decode(errors="replace")


def took(act):
    begin = time.monotonic()
    result = act()
    return result, time.monotonic() - begin


@pytest.fixture
def run(tmp_path):
    path = tmp_path / "plant.yaml"
    path.write_text(PROJECT)
    with start("run", path, "--json", "--quiet", "--web", "127.0.0.1:0", "--allow-write") as run:
        yield run


def small(visitor):
    """An evaluation of the project as it is."""
    document = json.loads(visitor.get("/project")[1])["document"]
    return visitor.post("/project/evaluate?client=small", {"document": document})


def test_evaluations_of_one_visitor_delay_no_other(run):
    greedy, other = Visitor(run, "127.0.0.1"), Visitor(run, "127.0.0.2")
    other.get("/status")
    held = [greedy.evaluate(i) for i in range(12)]
    time.sleep(0.3)
    for act in (lambda: other.get("/status"), lambda: other.get("/project"), lambda: small(other),
                lambda: greedy.get("/status")):
        (status, body), seconds = took(act)
        assert status == 200, body
        assert seconds < SOON
    # Their ends end them: the next one of the same visitor begins at once.
    for s in held:
        s.close()
    (status, _), seconds = took(lambda: small(greedy))
    assert status == 200 and seconds < SOON


def test_more_requests_than_may_wait_are_refused_to_their_visitor(run):
    greedy, other = Visitor(run, "127.0.0.1"), Visitor(run, "127.0.0.2")
    held = [greedy.evaluate(i) for i in range(24)]
    refused = [s for s in held[18:] if answer(s, SOON)[0] == 429]
    assert len(refused) == 6
    assert small(other)[0] == 200
    for s in held:
        s.close()


def test_a_newer_evaluation_ends_the_older_ones(run):
    visitor = Visitor(run, "127.0.0.1")
    older = [visitor.evaluate("page") for _ in range(3)]
    time.sleep(0.3)
    body = json.dumps({"document": {"takt": "1"}})
    newest = visitor.send("POST /api/v1/project/evaluate?client=page", body)
    for s in older:
        status, body = answer(s, SOON)
        assert (status, json.loads(body)["error"]["code"]) == (409, "superseded")
    assert answer(newest, SOON)[0] == 200


def test_announced_bodies_hold_nothing(run):
    greedy, other = Visitor(run, "127.0.0.1"), Visitor(run, "127.0.0.2")
    slow = [greedy.send("POST /api/v1/project/evaluate", "{", announced=16 << 20) for _ in range(12)]
    time.sleep(0.2)
    for visitor in (other, greedy):
        (status, body), seconds = took(lambda who=visitor: small(who))
        assert status == 200, body
        assert seconds < SOON
    for s in slow:
        s.close()


def test_nothing_is_received_from_strangers(tmp_path):
    path, token = tmp_path / "plant.yaml", tmp_path / "token"
    path.write_text(PROJECT)
    token.write_text("a-long-secret-token\n")
    with start("run", path, "--quiet", "--web", "127.0.0.1:0", "--web-token", token) as run:
        stranger = Visitor(run, "127.0.0.3")
        for _ in range(8):
            (status, body), seconds = took(
                lambda: answer(stranger.send("POST /api/v1/project/evaluate", "{", announced=16 << 20)))
            assert (status, json.loads(body)["error"]["code"]) == (401, "token")
            assert seconds < SOON
        assert stranger.get("/status")[0] == 401


def test_streams_of_one_visitor_leave_some_to_others(run):
    greedy, other = Visitor(run, "127.0.0.1"), Visitor(run, "127.0.0.2")
    streams = [greedy.send("GET /api/v1/stream") for _ in range(20)]
    statuses = [int(s.recv(4096).split()[1]) for s in streams]
    assert statuses.count(200) == 16 and statuses.count(429) == 4
    with other.send("GET /api/v1/stream") as s:
        assert int(s.recv(4096).split()[1]) == 200
    for s in streams:
        s.close()


def test_a_stop_ends_evaluations(run):
    visitor = Visitor(run, "127.0.0.1")
    longer = json.dumps({"document": slow_document(50, 400)})
    held = [visitor.evaluate(i, longer) for i in range(3)]
    time.sleep(0.5)
    run.process.send_signal(signal.SIGTERM)
    ended, seconds = took(run.finish)
    assert '"event":"summary"' in ended.out.replace(" ", "")
    assert seconds < SOON
    for s in held:
        s.close()
