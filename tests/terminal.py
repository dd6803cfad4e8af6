"""A program on a terminal of its own: a pty, and an emulation of the few sequences that Takt sends
(ECMA-48)."""
import fcntl
import os
import pty
import re
import signal
import struct
import subprocess
import termios
import threading

from program import DEADLINE, TAKT, environment, until


class Screen:
    """Rows and columns; lines that are too long wrap, the last line scrolls."""

    def __init__(self, rows, columns):
        self.rows, self.columns = rows, columns
        self.cells, self.row, self.column = [[]], 0, 0
        self.scrolled = []
        self._rest = ""

    def feed(self, text):
        text, self._rest = self._rest + text, ""
        while text:
            sequence = re.match(r"\x1b\[([0-9;]*)([A-Za-z])", text)
            if sequence:
                self._control(sequence[1], sequence[2])
                text = text[sequence.end():]
            elif text[0] == "\x1b":
                self._rest = text  # it is cut
                return
            else:
                self._put(text[0])
                text = text[1:]

    def _control(self, number, letter):
        if letter == "A":
            self.row = max(0, self.row - int(number or 1))
        elif letter == "H":
            self.row = self.column = 0
        elif letter == "K":
            del self.cells[self.row][self.column:]
        elif letter == "J" and number == "2":
            self.cells = [[] for _ in self.cells]
        elif letter == "J":
            del self.cells[self.row][self.column:]
            del self.cells[self.row + 1:]
        else:
            raise AssertionError(f"an unknown sequence: {number}{letter}")

    def _put(self, character):
        if character == "\r":
            self.column = 0
        elif character == "\n":
            self._down()
        else:
            if self.column == self.columns:
                self._down()
                self.column = 0
            line = self.cells[self.row]
            line += [" "] * (self.column + 1 - len(line))
            line[self.column] = character
            self.column += 1

    def _down(self):
        if self.row == self.rows - 1:
            self.scrolled.append("".join(self.cells.pop(0)))
            self.row -= 1
        self.row += 1
        while len(self.cells) <= self.row:
            self.cells.append([])

    def lines(self):
        return ["".join(line).rstrip() for line in self.cells]


class Terminal:
    """`takt arguments…` on a terminal. Use as a context: the program is killed at the end."""

    def __init__(self, *arguments, rows=24, columns=80):
        self.near, self.far = pty.openpty()
        self.screen, self.raw = None, ""
        self.resize(rows, columns)
        self.before = termios.tcgetattr(self.far)
        self.process = subprocess.Popen([TAKT, *map(str, arguments)], stdin=self.far, stdout=self.far,
                                        stderr=self.far, env=environment(), start_new_session=True,
                                        preexec_fn=lambda: fcntl.ioctl(0, termios.TIOCSCTTY, 0))
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self):
        rest = b""
        while True:
            try:
                data = os.read(self.near, 65536)
            except OSError:
                return
            if not data:
                return
            data = rest + data
            text = data.decode(errors="ignore")
            rest = data[len(text.encode()):] if len(data) - len(text.encode()) < 4 else b""
            self.raw += text
            self.screen.feed(text)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.process.poll() is None:
            self.process.kill()
        self.process.wait()
        os.close(self.far)
        self._reader.join(5)
        os.close(self.near)

    def resize(self, rows, columns):
        self.screen = Screen(rows, columns)
        fcntl.ioctl(self.near, termios.TIOCSWINSZ, struct.pack("HHHH", rows, columns, 0, 0))

    def press(self, keys):
        os.write(self.near, keys.encode())

    def shows(self, condition, what):
        """Waits until the lines of the screen meet the condition, and gives them."""

        def seen():
            lines = self.screen.lines()
            return condition(lines) and lines

        try:
            return until(seen, what)
        except AssertionError as missing:
            raise AssertionError(f"{missing}\n" + "\n".join(self.screen.lines())) from None

    def settings(self):
        return termios.tcgetattr(self.far)

    def ends(self, code=0):
        assert self.process.wait(DEADLINE) == code, "\n".join(self.screen.lines())
        assert self.settings() == self.before, "the terminal is as before"

    def interrupt(self):
        """Ctrl-C as a key."""
        self.press("\x03")
        self.ends()

    def signal(self, number=signal.SIGTERM):
        self.process.send_signal(number)
        self.ends()
