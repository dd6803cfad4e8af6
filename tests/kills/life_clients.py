"""Clients of a plant's program that run beside it and judge what they get: pages, a relay, a mirror."""
import http.client
import json
import random
import socket
import threading
import time
from collections import Counter

from field import CONSTANTS, FIXED, constant
from ledger import Violation, require

HANGS = 60.0  # seconds; only detects programs that hang
CLOCKS = 0.003  # by which the ages of one moment may differ: milliseconds are rounded


class Client(threading.Thread):
    """Works until `ended`. `failure` is a Violation or a mistake of the test. While the program does not run,
    `_turn()` raises OSError or http.client.HTTPException, and is tried again."""

    def __init__(self, seed):
        super().__init__(daemon=True)
        self.random = random.Random(seed)
        self.ended, self.failure, self.counts = False, None, Counter()

    def run(self):
        while not self.ended:
            try:
                self._turn()
                time.sleep(self.random.uniform(0, 0.05))
            except TimeoutError:
                self.failure = Violation(f"{type(self).__name__}: no answer within {HANGS:g} s")
                return
            except (OSError, http.client.HTTPException, json.JSONDecodeError):
                time.sleep(0.02)
            except Exception as error:
                self.failure = error
                return


class PageClient(Client):
    """Judges ages, and edits the comment of a local of its own. `editing`: held while a page saves."""

    def __init__(self, seed, index, port, devices, editing):
        super().__init__(seed)
        self.local, self.port, self.devices, self.editing = f"Page{index}", port, devices, editing
        self.known = {"0"}  # what the comment may be: after a save without an answer, the old or the new one

    def _turn(self):
        if self.random.random() < 0.1:
            self._edit()
        else:
            self._look()

    def _ask(self, method, path, body=None):
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=HANGS)
        try:
            headers = {"X-Takt": "1", "Content-Type": "application/json"} if body else {}
            connection.request(method, f"/api/v1{path}", json.dumps(body) if body else None, headers)
            response = connection.getresponse()
            answer = json.loads(response.read())
        finally:
            connection.close()
        self.counts[f"page {response.status}"] += 1
        code = answer["error"]["code"] if "error" in answer else ""
        require(response.status < 500 or response.status == 503 or code, "the page failed", path, answer)
        return response.status, answer

    def _look(self):
        name, device = self.random.choice(list(self.devices.items()))
        asked_from = device.count
        asked = time.monotonic()
        status, answer = self._ask("GET", f"/values?pattern={name}.Count")
        received = time.monotonic()
        if status != 200:
            return
        for value in answer["values"]:
            if value["quality"] != "good":
                continue
            number = value["value"]
            require(0 < number <= device.count, "a value that the device did not send", value, device.count)
            age, sent = value["age_ms"] / 1000, device.answers[number].sent
            require(age >= asked - sent - CLOCKS, "an age is understated", value, asked - sent)
            # The request was sent after the answer before.
            before = device.answers[number - 1].asked
            require(number == 1 or age <= received - before + CLOCKS, "an age is overstated", value,
                    received - before)
            self.counts["ages"] += 1
            self.counts["values behind"] = max(self.counts["values behind"], asked_from - number)

    def _edit(self):
        status, project = self._ask("GET", "/project")
        if status != 200:
            return
        if project["document"] is None:
            return  # the file is broken at present
        own = next(x for x in project["document"]["locals"] if x["name"] == self.local)
        found = own["comment"]
        require(found in self.known, "an edit is lost", self.local, found, self.known)
        wanted = str(self.random.randrange(10**9))
        own["comment"] = wanted
        self.known = {found, wanted}
        body = {"document": project["document"], "revision": project["revision"], "apply": True}
        with self.editing:
            status, _ = self._ask("PUT", "/project", body)
        # Another status than these two leaves it open whether the file was saved.
        if status == 200:
            self.known = {wanted}
            self.counts["edits"] += 1
        elif status in (409, 429):
            self.known = {found}


class ModbusClient(Client):
    """Reads registers 0x03 of one unit over TCP."""

    def __init__(self, seed, port, unit):
        super().__init__(seed)
        self.port, self.unit = port, unit

    def _turn(self):
        with socket.create_connection(("127.0.0.1", self.port), timeout=HANGS) as peer:
            while not self.ended:
                self._ask(peer)

    def _read(self, peer, start, size):
        """The registers, or None: an exception."""
        transaction = self.random.randrange(1 << 16)
        head = transaction.to_bytes(2, "big") + b"\0\0\0\6" + bytes((self.unit, 3))
        peer.sendall(head + start.to_bytes(2, "big") + size.to_bytes(2, "big"))
        answer = b""
        while len(answer) < 9 or len(answer) < 6 + int.from_bytes(answer[4:6], "big"):
            data = peer.recv(512)
            if not data:
                raise OSError
            answer += data
        require(answer[:4] == head[:4] and answer[6] == self.unit, "a response to another request",
                head.hex(" "), answer.hex(" "))
        self.counts[f"{type(self).__name__} {'answers' if answer[7] == 3 else 'exceptions'}"] += 1
        if answer[7] != 3:
            return None
        require(answer[8] == 2 * size and len(answer) == 9 + 2 * size, "a response of another length",
                answer.hex(" "))
        return [int.from_bytes(answer[i:i + 2], "big") for i in range(9, len(answer), 2)]


class RelayClient(ModbusClient):
    """Reads constants of a device through the relay: a mix-up of responses shows."""

    def _ask(self, peer):
        size = self.random.randint(1, 20)
        start = self.random.randrange(CONSTANTS.start, CONSTANTS.stop - size)
        words = self._read(peer, start, size)
        expected = [constant(self.unit, start + i) for i in range(size)]
        require(words in (None, expected), "the relay answers with other registers", start, words, expected)
        time.sleep(self.random.uniform(0, 0.03))


class MirrorClient(ModbusClient):
    """Reads Count and Fixed of a device from the mirror."""

    def __init__(self, seed, port, unit, device):
        super().__init__(seed, port, unit)
        self.device, self.newest = device, 0

    def _ask(self, peer):
        words = self._read(peer, 0, 3)
        if words is not None:
            number = words[0] << 16 | words[1]
            require(words[2] == FIXED, "the mirror has a wrong value", words)
            require(self.newest <= number <= self.device.count, "the mirror goes back or ahead", number,
                    self.newest, self.device.count)
            self.newest = number
        time.sleep(self.random.uniform(0, 0.03))
