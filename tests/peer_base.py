"""Peers that work in threads of their own: on a pseudo-terminal and as TCP listeners. They need the standard
library only."""
import os
import select
import socket
import threading
import tty


class ThreadedPeer:
    """While the context lasts: `_open()`, then `_run()` in a thread of its own until `_stop` is set, then
    `_close()`."""

    def __enter__(self):
        self._open()
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()
        return self

    def __exit__(self, *_):
        self._stop.set()
        self._thread.join()
        self._close()


class PtyPeer(ThreadedPeer):
    """Works on a pseudo-terminal: `port` is the path to open."""

    def _open(self):
        self._master, self._slave = os.openpty()
        tty.setraw(self._slave)
        self.port = os.ttyname(self._slave)

    def _close(self):
        os.close(self._master)
        os.close(self._slave)

    def _readable(self, seconds):
        return bool(select.select([self._master], [], [], seconds)[0])


class TcpPeer:
    """Listens on `port` (0: one of its own) while the context lasts. `_connected(peer)` handles each
    connection. It may call `_begin(function, *arguments)`, which starts a thread that ends when `_stop` is
    set."""

    def __init__(self, port=0):
        self._listener = socket.create_server(("127.0.0.1", port))
        self._listener.settimeout(0.02)
        self.port = self._listener.getsockname()[1]
        self._stop = threading.Event()
        self._threads = []
        self._begin(self._accept)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._stop.set()
        for thread in self._threads:
            thread.join()
        self._listener.close()

    def _begin(self, function, *arguments):
        self._threads.append(threading.Thread(target=function, args=arguments, daemon=True))
        self._threads[-1].start()

    def _accept(self):
        while not self._stop.is_set():
            try:
                peer, _ = self._listener.accept()
            except TimeoutError:
                continue
            self._connected(peer)
