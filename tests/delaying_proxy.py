"""A TCP proxy that delays each direction, as a network of that round trip does."""
import collections
import contextlib
import socket
import threading
import time


def _carry(source, target, delay):
    due, ready = collections.deque(), threading.Condition()

    def forward():
        while True:
            with ready:
                ready.wait_for(lambda: due)
                moment, data = due.popleft()
            time.sleep(max(0, moment - time.monotonic()))
            with contextlib.suppress(OSError):
                target.sendall(data) if data else target.shutdown(socket.SHUT_WR)
            if not data:
                return

    threading.Thread(target=forward, daemon=True).start()
    data = b"begin"
    while data:
        try:
            data = source.recv(65536)
        except OSError:
            data = b""
        with ready:
            due.append((time.monotonic() + delay, data))
            ready.notify()


@contextlib.contextmanager
def delaying_proxy(port, delay):
    """Yields the port of a proxy to `port`. Each byte is `delay` seconds later there."""
    with socket.create_server(("127.0.0.1", 0)) as server:

        def accept():
            with contextlib.suppress(OSError):
                while True:
                    client, _ = server.accept()
                    broker = socket.create_connection(("127.0.0.1", port))
                    for source, target in ((client, broker), (broker, client)):
                        source.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                        threading.Thread(target=_carry, args=(source, target, delay), daemon=True).start()

        threading.Thread(target=accept, daemon=True).start()
        yield server.getsockname()[1]
        with contextlib.suppress(OSError):
            server.shutdown(socket.SHUT_RDWR)
