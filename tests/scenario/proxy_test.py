"""The page behind a proxy that ends TLS: nginx as docs/web.md configures it."""
import http.client
import json
import pathlib
import re
import socket
import ssl
import subprocess
import time

import pytest

from endpoints import free_port, wait_listening
from program import DEADLINE, ROOT, start, takt, until

TOKEN = "a-long-secret-token"
NAME = "plant.example.com"
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
          - {name: Wanted, type: int16, register: 10, read: 0x03, write: 0x10}
"""


def documented_server():
    """The `server` block of docs/web.md."""
    text = (pathlib.Path(ROOT) / "docs/web.md").read_text(encoding="utf-8")
    return re.search(r"```nginx\n(.*?)```", text, re.DOTALL)[1]


class Nginx:
    """The documented server on a free port, with a certificate of its own."""

    def __init__(self, folder, upstream):
        self.port = free_port()
        certificate, key = folder / "plant.pem", folder / "plant.key"
        subprocess.run(["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256",
                        "-nodes", "-days", "2", "-subj", f"/CN={NAME}",
                        "-addext", f"subjectAltName=DNS:{NAME}", "-keyout", key, "-out", certificate],
                       check=True, capture_output=True)
        server = documented_server()
        for old, new in (("listen 443 ssl", f"listen 127.0.0.1:{self.port} ssl"),
                         ("/etc/ssl/plant.pem", str(certificate)), ("/etc/ssl/plant.key", str(key)),
                         ("127.0.0.1:8502", f"127.0.0.1:{upstream}")):
            assert server.count(old) == 1
            server = server.replace(old, new)
        temporary = "".join(f"{kind}_temp_path {folder}/{kind};\n"
                            for kind in ("client_body", "proxy", "fastcgi", "uwsgi", "scgi"))
        config = folder / "nginx.conf"
        config.write_text(f"daemon off;\nmaster_process off;\npid {folder}/nginx.pid;\nerror_log stderr;\n"
                          f"events {{}}\nhttp {{\naccess_log off;\n{temporary}{server}}}\n")
        self.process = subprocess.Popen(["nginx", "-p", folder, "-c", config, "-e", "stderr"])
        self.trust = ssl.create_default_context(cafile=certificate)
        wait_listening(self.port)

    def stop(self):
        self.process.terminate()
        self.process.wait()

    def connect(self, source="127.0.0.1"):
        plain = socket.create_connection(("127.0.0.1", self.port), DEADLINE, (source, 0))
        return self.trust.wrap_socket(plain, server_hostname=NAME)


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("plant")
    (folder / "plant.yaml").write_text(PROJECT)
    (folder / "token").write_text(TOKEN + "\n")
    return folder


def serve(files, *options):
    return start("run", files / "plant.yaml", "--json", "--web", "127.0.0.1:0", "--web-token",
                 files / "token", "--allow-write", *options)


def port_of(run):
    return int(until(lambda: next((m for line in [*run.err, *run.out]
                                   if (m := re.search(r"http://127\.0\.0\.1:(\d+)/", line))), None),
                     f"an address\n{run!r}")[1])


def ask(connection, method, path, body=None, fields=()):
    """Status and answer of a request as a browser on https://plant.example.com sends it."""
    text = "" if body is None else json.dumps(body)
    wanted = {"Host": NAME, "Origin": f"https://{NAME}", "X-Takt": "1", "Content-Type": "application/json",
              "Authorization": f"Bearer {TOKEN}", "Connection": "close"} | dict(fields)
    if body is not None:
        wanted["Content-Length"] = str(len(text))
    head = "".join(f"{name}: {value}\r\n" for name, value in wanted.items())
    with connection as s:
        s.sendall(f"{method} {path} HTTP/1.1\r\n{head}\r\n{text}".encode())
        response = http.client.HTTPResponse(s, method=method)
        response.begin()
        return response.status, response.read().decode()


@pytest.fixture(scope="module")
def plant(files):
    with serve(files, "--web-name", NAME, "--web-proxy", "127.0.0.1") as run:
        run.wait_event(lambda e: e["event"] == "value" and e["quality"] == "good", "a value")
        nginx = Nginx(files, port_of(run))
        yield run, nginx
        nginx.stop()


def test_page_writes_and_streams_through_a_proxy(plant):
    _, nginx = plant
    status, page = ask(nginx.connect(), "GET", "/")
    assert status == 200 and "<title>Takt</title>" in page
    command = {"kind": "write", "variable": "Wanted", "value": 7}
    status, answer = ask(nginx.connect("127.0.0.5"), "POST", "/api/v1/commands", command)
    assert status == 200 and json.loads(answer)["outcome"] == "done", answer
    _, events = ask(nginx.connect(), "GET", "/api/v1/events")
    assert "127.0.0.5" in events  # who wrote: the client, not the proxy
    with nginx.connect() as s:
        s.sendall(f"GET /api/v1/stream?token={TOKEN} HTTP/1.1\r\nHost: {NAME}\r\n\r\n".encode())
        begin, seen = time.monotonic(), b""
        while seen.count(b"event: reads") + seen.count(b"event: values") < 5:
            got = s.recv(65536)
            assert got, seen
            seen += got
        assert time.monotonic() - begin < 5.0  # at once, not when a buffer of nginx is full


def test_other_sites_are_refused_through_a_proxy(plant):
    _, nginx = plant
    command = {"kind": "write", "variable": "Wanted", "value": 7}
    for fields, expected in (({"Origin": "https://evil.example"}, 403), ({"Origin": f"http://{NAME}"}, 403),
                             ({"Host": "evil.example", "Origin": "https://evil.example"}, 421),
                             ({"Authorization": "Bearer wrong"}, 401)):
        status, answer = ask(nginx.connect(), "POST", "/api/v1/commands", command, fields.items())
        assert status == expected, (fields, answer)


def test_clients_behind_a_proxy_have_limits_of_their_own(plant):
    _, nginx = plant
    # What a client puts in front of its address does not make it another client.
    statuses = [ask(nginx.connect("127.0.0.6"), "GET", "/none",
                    fields={"X-Forwarded-For": f"192.0.2.{i % 250}"}.items())[0] for i in range(3)]
    assert statuses == [404] * 3
    streams = []
    for i in range(17):
        streams.append(nginx.connect("127.0.0.6"))
        streams[-1].sendall(f"GET /api/v1/stream?token={TOKEN} HTTP/1.1\r\nHost: {NAME}\r\n"
                            f"X-Forwarded-For: 192.0.2.{i}\r\n\r\n".encode())
    assert [int(s.recv(4096).split()[1]) for s in streams] == [200] * 16 + [429]
    with nginx.connect("127.0.0.7") as s:
        s.sendall(f"GET /api/v1/stream?token={TOKEN} HTTP/1.1\r\nHost: {NAME}\r\n\r\n".encode())
        assert int(s.recv(4096).split()[1]) == 200
    for s in streams:
        s.close()


def direct(run, source="127.0.0.1"):
    return socket.create_connection(("127.0.0.1", port_of(run)), DEADLINE, (source, 0))


TLS = {"Origin": f"https://{NAME}", "X-Forwarded-Proto": "https"}


@pytest.mark.parametrize("options,host,source,fields,expected", [
    ([], NAME, "127.0.0.1", {}, 421),
    (["--web-name", "VM.local", "--web-name", NAME], "vm.local:8502", "127.0.0.1", {}, 200),
    # Fields count from a named proxy only.
    (["--web-name", NAME, "--web-proxy", "127.0.0.1"], NAME, "127.0.0.2", TLS, 403),
    (["--web-name", NAME, "--web-proxy", "127.0.0.0/8"], "127.0.0.1", "127.0.0.2",
     TLS | {"X-Forwarded-Host": NAME}, 200),
])
def test_names_and_fields(files, options, host, source, fields, expected):
    with serve(files, *options) as run:
        wanted = {"Host": host, "Origin": f"http://{host}"} | fields
        status, answer = ask(direct(run, source), "POST", "/api/v1/commands/preview",
                             {"variable": "Wanted", "value": 7}, wanted.items())
        assert status == expected, answer


@pytest.mark.parametrize("option,value", [
    ("--web-name", "https://plant.example.com"), ("--web-name", "plant.example.com:443"), ("--web-name", "*"),
    ("--web-name", "a..b"), ("--web-name", ""),
    ("--web-proxy", "proxy.example.com"), ("--web-proxy", "127.0.0.1:80"), ("--web-proxy", "10.0.0.0/33"),
    ("--web-proxy", ""),
])
def test_wrong_names_and_addresses_are_errors(files, option, value):
    result = takt("run", files / "plant.yaml", "--web", "127.0.0.1:0", option, value, code=2)
    assert f"{option}: '{value}' is not valid" in result.err
