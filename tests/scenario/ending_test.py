"""SIGTERM ends a run with its summary: within 1 s if it waits for peers, within 3 s for a disk or a pipe."""
import os
import pathlib
import signal
import socket
import subprocess
import time

import pytest

from fake_slave import TcpSlave
from mqtt_plant import Broker
from program import TAKT, WITHOUT_WAITING, environment, has_signal, start, until

SOURCE = pathlib.Path(__file__).parent.parent / "support" / "stalled_calls.cpp"
SIMULATED = "{name: sim, transport: simulated, devices: [%s]}"
DEVICE = ("{name: Meter, address: 1, poll_period: 50ms, response_timeout: 60s, variables: "
          "[{name: Power, type: float, register: 0, read: 0x03}]}")
HISTORY = "outputs: [{name: history, transport: history}]\n"


def plant(folder, line=SIMULATED % DEVICE, more=""):
    path = folder / "plant.yaml"
    path.write_text(f"takt: 1\nlines: [{line}]\n{more}")
    return path


def over_tcp(host, port):
    return f"{{name: net, transport: tcp, host: {host}, tcp_port: {port}, devices: [{DEVICE}]}}"


def mqtt(host, port):
    return f"outputs: [{{name: cloud, transport: mqtt, brokers: ['mqtt://{host}:{port}'], topic: a}}]\n"


def has_begun(running):
    running.wait_event(lambda e: e["event"] == "value", "a value", deadline=WITHOUT_WAITING)


def ended_after(process):
    begin = time.monotonic()
    process.send_signal(signal.SIGTERM)
    code = process.wait(WITHOUT_WAITING)
    return time.monotonic() - begin, code


@pytest.fixture(scope="module", name="slower")
def fixture_slower(tmp_path_factory):
    """How much longer than on an idle machine a run needs to end that waits for nothing, in seconds."""
    with start("run", plant(tmp_path_factory.mktemp("idle")), "--json") as running:
        has_begun(running)
        took, code = ended_after(running.process)
    assert code == 0
    return 4 * took


@pytest.fixture(scope="module", name="stalled")
def fixture_stalled(tmp_path_factory):
    library = tmp_path_factory.mktemp("stall") / "stalled_calls.so"
    subprocess.run(["clang++-19", "-std=c++20", "-O1", "-shared", "-fPIC", "-o", library, SOURCE], check=True)
    return {"LD_PRELOAD": str(library), "ASAN_OPTIONS": "verify_asan_link_order=0"}


@pytest.fixture(name="silent")
def fixture_silent():
    """Accepts connections and never answers."""
    with TcpSlave() as slave:
        yield slave


def summary_of(running):
    return running.events()[-1]


@pytest.mark.parametrize("waits_for", ["broker", "broker name", "device", "device name"])
def test_a_peer(tmp_path, silent, stalled, slower, waits_for):
    host = "slow.example" if "name" in waits_for else "127.0.0.1"
    is_broker = waits_for.startswith("broker")
    path = plant(tmp_path, **({"more": mqtt(host, silent.port)} if is_broker else
                              {"line": over_tcp(host, silent.port)}))
    with start("run", path, "--json", env=stalled | {"TAKT_STALL_NAME": "slow.example"}) as running:
        if "name" in waits_for:
            until(lambda: running.catches(signal.SIGTERM), "the handler of signals")
            time.sleep(0.5)
        else:
            until(lambda: silent.accepted, "a connection")
        took, code = ended_after(running.process)
        result = running.finish(None)
    assert summary_of(running)["event"] == "summary", result
    assert took < 1 + slower, (took, slower)
    assert code in (0, 4, 7), result


def test_a_broker_that_stops_to_answer(tmp_path, slower):
    broker = Broker(tmp_path)
    broker.start()
    try:
        with start("run", plant(tmp_path, more=mqtt("127.0.0.1", broker.port)), "--json") as running:
            running.wait_event(lambda e: e.get("output", {}).get("state") == "delivering", "a connection",
                               deadline=WITHOUT_WAITING)
            broker.process.send_signal(signal.SIGSTOP)
            time.sleep(0.3)
            took, code = ended_after(running.process)
            result = running.finish(None)
    finally:
        broker.kill()
    assert (code, summary_of(running)["event"]) == (0, "summary"), result
    assert took < 1 + slower, (took, slower)


def test_a_client_of_the_page_that_does_not_read(tmp_path, slower):
    with start("run", plant(tmp_path), "--json", "--web", "127.0.0.1:0") as running:
        page = until(lambda: next((x for x in running.err if x.startswith("Page: ")), None), "the page")
        port = int(page.split(":")[3].split("/")[0])
        with socket.create_connection(("127.0.0.1", port)) as client:
            client.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1024)
            client.sendall(f"GET /api/v1/live HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n\r\n".encode())
            has_begun(running)
            took, code = ended_after(running.process)
        result = running.finish(None)
    assert (code, summary_of(running)["event"]) == (0, "summary"), result
    assert took < 1 + slower, (took, slower)


@pytest.mark.parametrize("form", [[], ["--json"]], ids=["text", "json"])
def test_a_reader_of_the_output_that_stops(tmp_path, slower, form):
    reading, writing = os.pipe()
    os.set_blocking(writing, False)
    with pytest.raises(BlockingIOError):
        while True:
            os.write(writing, b"x" * 512)
    os.set_blocking(writing, True)
    process = subprocess.Popen([TAKT, "run", plant(tmp_path), *form], stdout=writing, stderr=subprocess.PIPE,
                               env=environment())
    try:
        until(lambda: has_signal(process.pid, "SigCgt:", signal.SIGTERM), "the handler of signals")
        time.sleep(0.5)
        took, code = ended_after(process)
        err = process.stderr.read().decode()
    finally:
        process.kill()
        process.wait()
        os.close(reading)
        os.close(writing)
    assert took < 3 + slower, (took, slower, err)
    assert (code, err) == (7, "takt: stdout: its reader does not read; the rest of the output is lost\n"), err


@pytest.mark.parametrize("output", ["history", "journal"])
def test_a_disk_that_stalls(tmp_path, silent, stalled, slower, output):
    mark = tmp_path / "stalled"
    more = HISTORY if output == "history" else mqtt("127.0.0.1", silent.port)
    env = stalled | {"TAKT_STALL_FILE": str(mark)}
    with start("run", plant(tmp_path, more=more), "--json", env=env) as running:
        has_begun(running)
        mark.touch()
        time.sleep(1.2)  # a commit begins
        took, code = ended_after(running.process)
        result = running.finish(None)
    assert took < 3 + slower, (took, slower, result)
    assert code == 7, result
    assert summary_of(running)["event"] == "summary", result
    assert "the disk does not answer; samples that may not be stored: " in result.err, result
