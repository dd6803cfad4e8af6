"""The master of a request table on an emulated board, and the executor of this computer with its inputs."""
import contextlib
import struct
import subprocess

import pytest

import endpoints
from board import Board
from program import DEADLINE, PEERS, start, takt, until

PROJECT = """takt: 1
lines:
  - name: bus
    transport: serial
    port: /dev/ttyS0
    baud: 9600
    parity: none
    devices:
      - name: Meter
        address: 1
        poll_period: 100ms
        response_timeout: 3s
        poll_enable: On
        variables:
          - {name: A, type: uint16, register: 3, read: 0x03, status: Status}
          - {name: B, type: float, register: 40, read: 0x03}
          - {name: C, type: int16, register: 60, read: 0x03, write: 0x06, write_on_change: true, default: 5}
          - {name: D, type: int16, register: 61, read: 0x03, read_trigger: Again, write: 0x10,
             write_trigger: Send, default: 6}
      - name: Absent
        address: 2
        poll_period: 1s
        response_timeout: 200ms
        attempts: 2
        variables:
          - {name: E, type: int16, register: 0, read: 0x03}
locals:
  - {name: Status, type: uint16}
  - {name: Again, type: bool}
  - {name: Send, type: bool}
  - {name: On, type: bool, default: true}
"""
TABLE_AT = 0x200000  # firmware/images/table_master.cpp
GOOD, BAD = 1, 3  # table::Quality


def table_of(folder, project, *options):
    (folder / "plant.yaml").write_text(project)
    takt("table", "build", folder / "plant.yaml", "-o", folder / "table", *options)
    return folder / "table"


def loader(table):
    return ["-device", f"loader,file={table},addr={TABLE_AT},force-raw=on"]


def script(folder, duration, *commands):
    """@param commands  (ms, 0 variable or 1 local, item, value)"""
    words = [duration, *(word for command in commands for word in command)]
    (folder / "script").write_bytes(struct.pack(f"<{len(words)}I", *words))


@contextlib.contextmanager
def slave(port):
    line = f"rtu://{port}?baud=9600&parity=none"
    with start("serve", "--port", line, "--unit", 1, "--fill", "ramp") as running:
        until(lambda: any("serving" in line for line in running.out + running.err), "the slave serves")
        yield
        running.interrupt()


def played(folder, board, table, silent_for=0):
    """@param silent_for  requests before the slave is there"""
    with Board(board, "test_master", *loader(table), folder=folder) as master:
        if silent_for > 0:
            master.resume()
            for _ in range(silent_for):
                master.read_until(is_request)
            master.pause()
            master.drop_sent()
        with slave(master.port):
            master.resume()
            return master.output()


def replayed(table, notes):
    done = subprocess.run([PEERS / "table_replay", table], input="\n".join(notes) + "\n", capture_output=True,
                          text=True, timeout=DEADLINE, check=True)
    return done.stdout.splitlines()


def is_request(note):
    return note.startswith("transmit") and len(note.split()) == 3


def frames(notes):
    return [note.split()[2] for note in notes if is_request(note)]


def buffer(notes):
    return [note for note in notes if note.startswith("item")]


def item(notes, number):
    """Quality, status and words of an item of the buffer at the end."""
    line = next(line.split() for line in notes if line.startswith(f"item {number} "))
    return int(line[2]), int(line[3]), [int(word) for word in line[4:]]


# Items: the locals first, then the variables.
STATUS, AGAIN, SEND, ON, A, B, C, D, E = range(9)
SET, LOCAL = 0, 1


@pytest.mark.parametrize("board", ["an385", "an386"])
def test_the_board_sends_what_the_executor_of_this_computer_sends(results, board):
    table, notes = results[board].result()
    again = replayed(table, notes)
    assert frames(notes) == frames(again)
    assert buffer(notes) == buffer(again)
    sent = frames(notes)
    assert any(frame.startswith("0106003c004d") for frame in sent), "C is written on change"
    assert any(frame.startswith("0110003d0001020058") for frame in sent), "D is written by its trigger"
    assert any(frame.startswith("0103003d0001") for frame in sent), "D is read by its trigger"
    # Their qualities depend on how late the slave of this computer is, and are those of the executor (above).
    values = {number: item(notes, number)[2] for number in (A, B, C, D)}
    assert values == {A: [3], B: [40, 41], C: [77], D: [88]}
    assert item(notes, E)[0] == BAD
    assert sum(frame.startswith("02") for frame in sent) >= 3, "the absent device is probed"


def asked_between(notes, begin, end):
    """Requests to the device of the board between two times in milliseconds."""
    requests = [note.split() for note in notes if is_request(note)]
    return [
        frame for _, at, frame in requests
        if frame.startswith("01") and begin * 1_000_000 < int(at) < end * 1_000_000
    ]


def test_a_device_that_is_switched_off_is_not_polled(results):
    _, notes = results["switched"].result()
    # A host that stalls may let the board see the command after a request that was due before it.
    assert len(asked_between(notes, 1000, 1900)) <= 1
    assert len(asked_between(notes, 2000, 3000)) > 1


def test_a_silent_device_is_asked_again_and_returns(results):
    table, notes = results["silent"].result()
    assert frames(notes) == frames(replayed(table, notes))
    assert item(notes, A) == (GOOD, 0, [3])
    first = next(i for i, line in enumerate(notes) if line.startswith("bytes"))
    assert len(frames(notes[:first])) >= 2


def refused(folder, at):
    """@returns what the board notes of a table with a broken byte"""
    table = table_of(folder, PROJECT)
    image = bytearray(table.read_bytes())
    image[at] ^= 1
    table.write_bytes(image)
    script(folder, 200)
    with Board("an385", "test_master", *loader(table), folder=folder) as master:
        master.resume()
        return master.output()


BROKEN_AT = [0, 9, 40, 200, 1000, -1]


@pytest.mark.parametrize("at", BROKEN_AT)
def test_a_broken_table_is_refused(results, at):
    notes = results[at].result()
    assert any(line.startswith("refused") for line in notes) and not frames(notes)


CONTROLLER = """takt: 1
profile: owen-kc1
lines:
  - name: bus
    transport: serial
    port: PORT
    baud: 9600
    parity: none
    devices:
      - name: One
        address: 1
        poll_period: 500ms
        response_timeout: 3s
        group_requests: true
        variables:
          - {name: A1, type: int16, register: 3, read: 0x03}
          - {name: A2, type: int16, register: 4, read: 0x03}
          - {name: A3, type: float, register: 40, read: 0x04, period: 1500ms}
          - {name: A4, type: int16, register: 60, read: 0x03, write: 0x06, write_on_change: true}
          - {name: B1, type: int16, register: 10, read: 0x03, period: 1s, read_trigger: Again}
          - {name: B2, type: bool, register: 2, bit: 5, read: 0x01, period: 1s}
locals:
  - {name: Again, type: bool}
"""
PLACES = ("Again", "B2", "A1", "A2", "B1", "A4", "A3")


def polled_by_takt(folder):
    """@returns the characters that takt sends with the project of the controller"""
    with endpoints.serial_pair(folder) as pair, slave(pair.b):
        (folder / "plant.yaml").write_text(CONTROLLER.replace("PORT", pair.a))
        takt("run", folder / "plant.yaml", "--for", "3s", "--quiet", code=None)
        return pair.sent().hex()


def test_a_table_of_a_controller(results):
    """The frames of the board are those of `takt run` of the project, in their order."""
    table, notes = results["controller"].result()
    again = replayed(table, notes)
    assert frames(notes) == frames(again)
    assert buffer(notes) == buffer(again)
    values = {name: item(notes, place)[2][0] for place, name in enumerate(PLACES)}
    assert {name: values[name] for name in ("A1", "A2", "A4", "B1")} == {"A1": 3, "A2": 4, "A4": 77, "B1": 10}
    sent = frames(notes)
    assert any(frame.startswith("0106003c004d") for frame in sent), "A4 is written on change"
    asked = results["takt"].result()
    assert len(asked) > 8 * len(sent[0]) and "".join(sent).startswith(asked)


TROUBLED = CONTROLLER.replace("group_requests: true", """group_requests: true
        read_modify_write: true""").replace(
    "locals:", """\
          - {name: B3, type: bool, register: 62, bit: 3, read: 0x03, write: 0x06, write_on_change: true}
          - {name: B4, type: int16, register: 63, read: 0x03, status: Good}
      - name: Absent
        address: 2
        poll_period: 1s
        response_timeout: 200ms
        attempts: 2
        status: Lost
        variables:
          - {name: C1, type: int16, register: 0, read: 0x03}
      - name: Switched
        address: 3
        poll_period: 1s
        response_timeout: 200ms
        poll_enable: On
        variables:
          - {name: D1, type: int16, register: 0, read: 0x03}
locals:
  - {name: On, type: bool}
  - {name: Good, type: int16}
  - {name: Lost, type: int16}""")
TROUBLED_PLACES = ("On", "Good", "Lost", "Again", "B2", "A1", "A2", "B1", "A4", "B3", "B4", "A3", "C1", "D1")
NOT_ANSWERING = 105  # docs/specification.md, section 7


def test_bits_statuses_and_poll_enable_of_a_controller(results):
    table, notes = results["troubled"].result()
    again = replayed(table, notes)
    assert frames(notes) == frames(again)
    assert buffer(notes) == buffer(again)
    wanted = {"B3": 0, "B4": 63, "Good": 0, "Lost": NOT_ANSWERING}
    assert {name: item(notes, TROUBLED_PLACES.index(name))[2][0] for name in wanted} == wanted
    sent = frames(notes)
    bit = next(i for i, frame in enumerate(sent) if frame.startswith("0106003e0036"))
    assert sent[bit - 1].startswith("0103003e0001"), "B3 is written into its register as it was read"
    switched_on = next(i for i, frame in enumerate(sent) if frame.startswith("0303"))
    assert 0 < switched_on < bit, "first asked when it was switched on"
    assert any(frame.startswith("0203") for frame in sent[:switched_on]), "a silent device is polled before"


OWEN = ("--profile", "owen-kc1")
EVERYTHING = (3000, (800, SET, C, 77), (1000, SET, D, 88), (1200, LOCAL, SEND, 1), (1500, LOCAL, AGAIN, 1),
              (1800, LOCAL, ON, 0), (2200, LOCAL, ON, 1))
# board, project, duration and commands, options of `takt table build`, requests before the slave is there
PLAYS = {
    "silent": ("an385", PROJECT.replace("response_timeout: 3s", "response_timeout: 500ms"), (8000,), (), 3),
    "an385": ("an385", PROJECT, EVERYTHING),
    "an386": ("an386", PROJECT, EVERYTHING),
    "switched": ("an385", PROJECT, (3000, (800, LOCAL, ON, 0), (2000, LOCAL, ON, 1))),
    "controller": ("an385", CONTROLLER, (5000, (3500, SET, PLACES.index("A4"), 77),
                                         (3800, LOCAL, PLACES.index("Again"), 1)), OWEN),
    "troubled": ("an385", TROUBLED, (4000, (2000, LOCAL, TROUBLED_PLACES.index("On"), 1),
                                     (2700, SET, TROUBLED_PLACES.index("B3"), 0)), OWEN),
}


def play(folder, board, project, commands, options=(), silent_for=0):
    """@returns the table, and the notes of the board"""
    table = table_of(folder, project.replace("PORT", "/dev/ttyS0"), *options)
    script(folder, *commands)
    return table, played(folder, board, table, silent_for)


CASES = {name: (play, *of) for name, of in PLAYS.items()} | {at: (refused, at) for at in BROKEN_AT}
CASES["takt"] = (polled_by_takt,)
