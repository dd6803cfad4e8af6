"""Boards of qemu-system-arm with the images of build/firmware (tools/firmware)."""
import os
import pathlib
import re
import socket
import struct
import subprocess
import termios
import tty

FOLDER = pathlib.Path(__file__).resolve().parent
ROOT = FOLDER.parent.parent
IMAGES = ROOT / "build" / "firmware"
# machine of QEMU, preset, folder of the port
MACHINES = {
    "microbit": ("microbit", "cortex-m0", "microbit"),
    "an385": ("mps2-an385", "cortex-m3", "mps2"),
    "an386": ("mps2-an386", "cortex-m4", "mps2"),
    "lm3s6965": ("lm3s6965evb", "cortex-m3", "lm3s6965")
}
SEMIHOSTING = ["-semihosting-config", "enable=on,target=native"]
EXACT = ["-icount", "shift=6,sleep=off"]  # virtual time: one instruction takes 64 ns, WFI no time
PATIENCE = 120


def image(board, name):
    machine, preset, port = MACHINES[board]
    path = IMAGES / preset / f"{port}_{name}.elf"
    assert path.exists(), f"{path} is missing. Run: ./dev firmware"
    return machine, path


def command(board, name, *options):
    machine, path = image(board, name)
    return ["qemu-system-arm", "-M", machine, "-display", "none", "-monitor", "none", "-kernel", str(path),
            *options]


def plugin(folder, *options):
    """@returns the options of QEMU that load trace.c, which writes the file "trace" in the folder"""
    library = pathlib.Path(folder) / "trace.so"
    source = FOLDER / "trace.c"
    subprocess.run(["clang-19", "-shared", "-fPIC", "-Wall", "-Werror", source, "-o", library], check=True)
    return ["-plugin", ",".join([str(library), *options])]


def addresses(board, name, *symbols):
    """@returns the addresses of functions of an image"""
    _, path = image(board, name)
    listed = subprocess.run(["arm-none-eabi-readelf", "-sW", path], capture_output=True, text=True,
                            check=True).stdout
    found = {words[7]: words[1] for words in map(str.split, listed.splitlines()) if len(words) == 8}
    return {symbol: int(found[symbol], 16) & ~1 for symbol in symbols}


def run(board, name, folder, *options, patience=PATIENCE):
    """Runs an image that ends by itself. @returns its output by semihosting, and that of its UART"""
    machine = command(board, name, "-serial", "file:uart", *SEMIHOSTING, *EXACT, *options)
    done = subprocess.run(machine, cwd=folder, stdin=subprocess.DEVNULL, capture_output=True, text=True,
                          timeout=patience, check=False)
    assert done.returncode == 0, done.stderr
    lines = re.findall(r"^(\w+) (\d+)$", done.stdout + done.stderr, re.MULTILINE)
    numbers = {name: int(value) for name, value in lines}
    return numbers, (pathlib.Path(folder) / "uart").read_bytes()


class Board:
    """A board whose UARTs are the pseudo-terminals `ports`; `port` is the first one. With a folder it is
    stopped until resume(), and its virtual time with it; it writes lines by semihosting."""

    def __init__(self, board, name, *options, folder=None, ports=1):
        self.lines = []
        # QEMU gets the other ends: of a pseudo-terminal of its own, it looks only once a second whether
        # somebody has opened it. One that nobody has open would be at its end: they stay open here.
        ends, self._held = zip(*(os.openpty() for _ in range(ports)))
        for port in self._held:
            tty.setraw(port)
        self.ports = [os.ttyname(port) for port in self._held]
        self.port = self.ports[0]
        options = list(options)
        for number, end in enumerate(ends):
            uart = f"serial,id=uart{number},path=/dev/fdset/{number}"
            options += ["-add-fd", f"fd={end},set={number}", "-chardev", uart]
            options += ["-serial", f"chardev:uart{number}"]
        self._control, end = socket.socketpair()
        if folder is not None:
            options += [*SEMIHOSTING, "-S", "-chardev", f"socket,id=control,fd={end.fileno()}", "-mon",
                        "chardev=control,mode=control"]
            self._order("qmp_capabilities")
        ends += (end.detach(),)
        self.process = subprocess.Popen(command(board, name, *options), stdin=subprocess.DEVNULL,
                                        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                                        cwd=folder, pass_fds=ends)
        for end in ends:
            os.close(end)

    def drop_sent(self):
        """Drops what it has sent and nobody has read."""
        for port in self._held:
            termios.tcflush(port, termios.TCIFLUSH)

    def _order(self, name):
        self._control.sendall(f'{{"execute": "{name}"}}\n'.encode())

    def resume(self):
        self._order("cont")

    def pause(self):
        self._order("stop")

    def read_until(self, condition):
        """Reads lines until the condition holds for one of them."""
        for line in self.process.stdout:
            self.lines.append(line.rstrip("\n"))
            if condition(self.lines[-1]):
                return
        raise AssertionError("\n".join(self.lines[-20:]))

    def output(self):
        """Of an image that ends by itself: all lines that it wrote."""
        text, _ = self.process.communicate(timeout=PATIENCE)
        self.lines += text.splitlines()
        assert self.process.returncode == 0, "\n".join(self.lines[-20:])
        return self.lines

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.kill()
        self.process.wait()
        self.process.stdout.close()
        self._control.close()
        for port in self._held:
            os.close(port)


def script(baud, strict, ascii_framing, steps):
    head = struct.pack("<III", baud, strict, ascii_framing)
    return head + b"".join(struct.pack("<II", *step) for step in steps)
