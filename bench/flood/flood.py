#!/usr/bin/env python3
"""Measures whether polling keeps its periods beside clients that flood the servers and the page of a project.

usage: bench/flood/flood.py [--takt PROGRAM] [--clients 0,50,500] [--seconds N] [--busy N]
                            [--option OPTION]...

A device on Modbus TCP notes when each request arrives. Three requests are polled every 50 ms. A third each of
the clients sends requests to the relay, to the mirror and to the page as fast as the program takes them, and
reads no response. An option, such as --option=--realtime, is passed to `takt run`. --busy starts so many
processes that compute.

The device runs before all other processes, also before the master with --realtime, so that it notes the time
of the master and not its own. That needs root. The load average before and after each measurement shows what
else ran.
"""
import argparse
import contextlib
import json
import multiprocessing
import os
import pathlib
import selectors
import signal
import socket
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
PERIOD = 0.05
LATE = 1.05 * PERIOD
STARTS = (0, 200, 400)
ABOVE_REALTIME = 60  # the I/O thread has 49
PROJECT = """takt: 1
lines:
  - name: line
    host: 127.0.0.1
    tcp_port: {device}
    devices:
      - name: D
        address: 1
        poll_period: 50ms
        variables:
          - {{name: A, type: uint16, register: 0, read: 0x03}}
          - {{name: B, type: uint16, register: 200, read: 0x03}}
          - {{name: C, type: uint16, register: 400, read: 0x03}}
servers:
  - name: gate
    listen: 127.0.0.1
    tcp_port: {gate}
    max_connections: 400
    relay: [{{line: line, units: [1]}}]
    units: [{{address: 9, mirror: {{area: holding_register}}}}]
"""


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def serve_device(port, pipe):
    """Answers reads. Sends the times of the polled requests at SIGTERM."""
    os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(ABOVE_REALTIME))
    arrivals = {start: [] for start in STARTS}
    signal.signal(signal.SIGTERM, lambda *_: (pipe.send(arrivals), os._exit(0)))
    with socket.create_server(("127.0.0.1", port)) as listener:
        while True:
            peer, _ = listener.accept()
            peer.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            with peer, contextlib.suppress(ConnectionError):
                held = b""
                while data := peer.recv(4096):
                    held += data
                    while len(held) >= 12:
                        request, held = held[:12], held[12:]
                        start, size = int.from_bytes(request[8:10], "big"), request[11]
                        if start in arrivals and size == 1:
                            arrivals[start].append(time.monotonic())
                        body = request[6:8] + bytes((2 * size, )) + bytes(2 * size)
                        peer.sendall(request[:4] + len(body).to_bytes(2, "big") + body)


def flood(targets, seconds):
    """`targets`: (port, bytes of requests) of each client. Reads nothing; opens closed connections again."""
    selector, end = selectors.DefaultSelector(), time.monotonic() + seconds
    sent = 0

    def connect(target):
        peer = socket.socket()
        peer.setblocking(False)
        peer.connect_ex(("127.0.0.1", target[0]))
        selector.register(peer, selectors.EVENT_WRITE, target)

    for target in targets:
        connect(target)
    while time.monotonic() < end:
        for key, _ in selector.select(0.1):
            try:
                sent += key.fileobj.send(key.data[1])
            except BlockingIOError:
                continue
            except OSError:
                selector.unregister(key.fileobj)
                key.fileobj.close()
                connect(key.data)
        time.sleep(0.001)  # leave the second core to the program
    return sent


@contextlib.contextmanager
def busy_processes(count):
    processes = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(count)]
    try:
        yield
    finally:
        for process in processes:
            process.kill()
            process.wait()


def load():
    return pathlib.Path("/proc/loadavg").read_text().split()[0]


def clients_of(count, gate, page):
    relay = b"".join(n.to_bytes(2, "big") + b"\0\0\0\6\1\3\0\7\0\5" for n in range(300))
    mirror = b"".join(n.to_bytes(2, "big") + b"\0\0\0\6\x09\3\0\0\0\3" for n in range(300))
    values = b"GET /api/v1/values HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n" * 100
    return [((gate, relay), (gate, mirror), (page, values))[i % 3] for i in range(count)]


def measure(options, count):
    device, gate, page = free_port(), free_port(), free_port()
    mine, its = multiprocessing.Pipe()
    peer = multiprocessing.Process(target=serve_device, args=(device, its), daemon=True)
    peer.start()
    with tempfile.TemporaryDirectory() as folder:
        project = pathlib.Path(folder) / "flood.yaml"
        project.write_text(PROJECT.format(device=device, gate=gate))
        command = [options.takt, "run", project, "--json", "--quiet", "--web", f"127.0.0.1:{page}"]
        program = subprocess.Popen([*command, *options.option], stdout=subprocess.PIPE,
                                   stderr=subprocess.DEVNULL)
        time.sleep(1)
        begin = time.monotonic()
        if count:
            sent = flood(clients_of(count, gate, page), options.seconds)
        else:
            sent = time.sleep(options.seconds) or 0
        end = time.monotonic()
        program.send_signal(signal.SIGINT)
        out, _ = program.communicate(timeout=60)
    peer.terminate()
    arrivals = mine.recv()
    peer.join()
    within = [[t for t in times if begin <= t <= end] for times in arrivals.values()]
    gaps = sorted(b - a for times in within for a, b in zip(times, times[1:]))
    summary = json.loads(out.splitlines()[-1])
    return {
        "clients": count,
        "polls_a_second": sum(map(len, within)) / len(STARTS) / (end - begin),
        "in_period": sum(gap <= LATE for gap in gaps) / len(gaps),
        "p99_ms": 1000 * gaps[int(0.99 * len(gaps))],
        "longest_ms": 1000 * gaps[-1],
        "sent_mb": sent / 1e6,
        "late_refreshes": sum(r["late_refreshes"] for line in summary["lines"] for r in line["requests"]),
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--takt", default=ROOT / "build/release/bin/takt")
    parser.add_argument("--clients", default="0,50,500")
    parser.add_argument("--seconds", type=float, default=10)
    parser.add_argument("--busy", type=int, default=0, metavar="N")
    parser.add_argument("--option", action="append", default=[])
    options = parser.parse_args()
    print("clients  polls/s  in period      p99  longest  sent     later than the proof  load")
    with busy_processes(options.busy):
        for count in map(int, options.clients.split(",")):
            before = load()
            its = measure(options, count)
            print(f"{count:7}  {its['polls_a_second']:7.1f}  {its['in_period']:9.1%}  "
                  f"{its['p99_ms']:4.0f} ms  {its['longest_ms']:4.0f} ms  {its['sent_mb']:4.0f} MB  "
                  f"{its['late_refreshes']:20}  {before} to {load()}", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
