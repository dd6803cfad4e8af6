"""The page and the API of a running program, over real sockets."""
import http.client
import json
import re
import socket

from api_schema import check_answer
from program import DEADLINE, until


def port_of(run):
    """The port of the page, from the address that the program prints."""
    found = until(
        lambda: next((m for line in [*run.err, *run.out] if
                      (m := re.search(r"http://127\.0\.0\.1:(\d+)/", line))), None), f"an address\n{run!r}")
    return int(found[1])


class Site:
    """A running program with its page."""

    def __init__(self, run):
        self.port = port_of(run)

    def connect(self):
        return socket.create_connection(("127.0.0.1", self.port), timeout=DEADLINE)

    def send(self, text, body=""):
        """Status and body of a request that is written by hand."""
        with self.connect() as s:
            s.sendall((text + "\r\n\r\n").encode() + body.encode())
            answer = b""
            while b"\r\n\r\n" not in answer and (got := s.recv(65536)):
                answer += got
            head, _, rest = answer.partition(b"\r\n\r\n")
            length = re.search(rb"(?i)content-length: (\d+)", head)
            while length and len(rest) < int(length[1]) and (got := s.recv(65536)):
                rest += got
        status, answered = int(head.split()[1]), rest.decode(errors="replace")
        method, _, target = text.partition(" ")
        check_answer(method, target.partition(" ")[0], status, answered)
        return status, answered

    def get(self, path, *fields, host="127.0.0.1"):
        return self.send("\r\n".join([f"GET {path} HTTP/1.1", f"Host: {host}:{self.port}", *fields]))

    def post(self, path, body, *fields):
        text = json.dumps(body)
        return self.send(
            "\r\n".join([
                f"POST /api/v1{path} HTTP/1.1", f"Host: 127.0.0.1:{self.port}", "X-Takt: 1",
                "Content-Type: application/json", f"Content-Length: {len(text)}", *fields
            ]), text)


class Api:
    """A client of /api/v1 of one running program."""

    def __init__(self, run):
        self.port = port_of(run)

    def __call__(self, method, path, body=None):
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=DEADLINE)
        try:
            headers = {"X-Takt": "1", "Content-Type": "application/json"} if method != "GET" else {}
            connection.request(method, f"/api/v1{path}", None if body is None else json.dumps(body), headers)
            answer = connection.getresponse()
            text = answer.read().decode()
            check_answer(method, path, answer.status, text)
            return answer.status, json.loads(text)
        finally:
            connection.close()
