"""Reads the files of a journal without the program: segments, cursors and the samples in them.

The formats are those at the head of src/store/journal/journal_record.cpp and journal_cursor.cpp, and of
src/publish/outputs/sample_codec.cpp.
"""
import array
import bisect
import pathlib
import struct
from dataclasses import dataclass, field

HEADER = struct.Struct("<IIHHQQQqqQ")
GAP = struct.Struct("<HHIQQQqq")
SLOT = struct.Struct("<IIQQQqQQQQQQqQ")
RECORD_MAGIC = 0x314A4B54
CURSOR_MAGIC = 0x32434B54
SLOT_OFFSET = 4096
SAMPLES, GAP_TYPE = 1, 2
CAUSES = {
    1: "restart",
    2: "buffer_full",
    3: "disk_failed",
    4: "disk_full",
    5: "source_lost",
    6: "quota",
    7: "damaged"
}
QUALITIES = ("never_read", "good", "uncertain", "bad")


def crc_table(bits):
    """Of the reversed polynomial of CRC-32C, for so many bits at a time."""
    table = list(range(1 << bits))
    for _ in range(bits):
        table = [value >> 1 ^ (0x82F63B78 if value & 1 else 0) for value in table]
    return table


TABLE_8, TABLE_16 = crc_table(8), crc_table(16)


def crc32c(data):
    crc, table = 0xFFFFFFFF, TABLE_16
    for pair in array.array("H", bytes(data[:len(data) & ~1])):
        crc = crc >> 16 ^ table[(crc ^ pair) & 0xFFFF]
    if len(data) & 1:
        crc = crc >> 8 ^ TABLE_8[(crc ^ data[-1]) & 0xFF]
    return crc ^ 0xFFFFFFFF


@dataclass(frozen=True, slots=True)
class Gap:
    cause: str
    samples: int
    first_ns: int
    last_ns: int


@dataclass(frozen=True, slots=True)
class Record:
    """A record; `before` counts all samples before it, so its samples have the numbers before + 1 and on."""
    type: int
    samples: int
    sequence: int
    before: int
    wall_ns: int
    monotonic_ns: int
    epoch: int
    payload: bytes

    @property
    def end(self):
        return self.before + self.samples

    @property
    def gap(self):
        if self.type != GAP_TYPE:
            return None
        cause, _, _, samples, _, _, first, last = GAP.unpack(self.payload)
        return Gap(CAUSES[cause], samples, first, last)


def parse_record(data, at):
    """The record at an offset and its size, or None."""
    if at + HEADER.size > len(data):
        return None
    magic, length, type_, _, samples, sequence, before, wall, monotonic, epoch = HEADER.unpack_from(data, at)
    if magic != RECORD_MAGIC or not 64 <= length <= 60064 or at + length > len(data):
        return None
    if crc32c(data[at:at + length - 4]) != struct.unpack_from("<I", data, at + length - 4)[0]:
        return None
    payload = bytes(data[at + HEADER.size:at + length - 4])
    return Record(type_, samples, sequence, before, wall, monotonic, epoch, payload), length


@dataclass
class Segment:
    """What was read of a segment file: its good records and the bytes between or after them."""
    path: pathlib.Path
    parsed: int = 0
    records: list = field(default_factory=list)
    ends: list = field(default_factory=list)  # offset behind each record
    bad_bytes: int = 0  # behind `parsed`

    def read(self):
        """Reads what was added since the last call. A file that was cut is read from its beginning."""
        size = self.path.stat().st_size
        if size < self.parsed:
            self.parsed, self.records, self.ends = 0, [], []
        if size == self.parsed and not self.bad_bytes:
            return
        with open(self.path, "rb") as file:
            file.seek(self.parsed)
            data = file.read()
        at, good = 0, 0
        while at < len(data):
            found = parse_record(data, at)
            if found:
                self.records.append(found[0])
                at += found[1]
                good = at
                self.ends.append(self.parsed + at)
                continue
            at = data.find(b"TKJ1", at + 1)
            if at < 0:
                break
        self.parsed += good
        self.bad_bytes = len(data) - good


class JournalFolder:
    """The folder of an output's journal."""

    def __init__(self, folder, name, kept=None):
        """`kept`: a folder with the segments that the program removed (TAKT_REMOVED of kill_points.cpp)."""
        self.folder, self.name, self.kept = pathlib.Path(folder), name, kept
        self.segments = {}

    def forget(self, path):
        """The file was changed by other means than the program's."""
        self.segments.pop(path, None)

    def read(self, limit_of=None):
        """The records of the stream in order. The first record of a segment ends those of the one before.
        `limit_of`: the size up to which a file is read."""
        paths = sorted(self.folder.glob("segment-*"))
        self.segments = {path: self.segments.get(path) or Segment(path) for path in paths}
        stream = []
        for path in paths:
            segment = self.segments[path]
            segment.read()
            count = bisect.bisect_right(segment.ends, limit_of(path)) if limit_of else len(segment.records)
            if count == 0:
                continue
            first = segment.records[0].sequence
            if stream and stream[-1].sequence >= first:
                del stream[bisect.bisect_left(stream, first, key=lambda record: record.sequence):]
            stream += segment.records[:count]
        return stream

    def removed(self, limit_of):
        """The records up to a size of files that were removed since the last read()."""
        gone = [segment for path, segment in sorted(self.segments.items()) if not path.exists()]
        for path in sorted(self.kept.iterdir()) if self.kept else ():
            if self.folder / path.name not in self.segments:
                segment = Segment(path)
                segment.read()
                segment.path = self.folder / path.name
                gone.append(segment)
            path.unlink()
        return [
            record for segment in gone
            for record in segment.records[:bisect.bisect_right(segment.ends, limit_of(segment.path))]
        ]

    def bytes(self):
        return sum(path.stat().st_size for path in self.folder.glob("segment-*"))

    @property
    def cursor_path(self):
        return self.folder / f"cursor-{self.name}"

    def cursor(self):
        return newest_slot(self.cursor_path.read_bytes()) if self.cursor_path.exists() else None


@dataclass(frozen=True, slots=True)
class Cursor:
    counter: int
    sequence: int
    samples: int
    delivered: int
    dropped: int


def parse_slot(data):
    if len(data) != SLOT.size + 4 or crc32c(data[:-4]) != struct.unpack("<I", data[-4:])[0]:
        return None
    magic, _, counter, sequence, samples, _, _, delivered, dropped, *_ = SLOT.unpack(data[:-4])
    return Cursor(counter, sequence, samples, delivered, dropped) if magic == CURSOR_MAGIC else None


def newest_slot(data):
    """The newer of the good slots of a cursor file, or None."""
    slots = [parse_slot(data[offset:offset + SLOT.size + 4]) for offset in (0, SLOT_OFFSET)]
    return max((slot for slot in slots if slot), key=lambda slot: slot.counter, default=None)


@dataclass(frozen=True, slots=True)
class Sample:
    variable: str
    value: object
    quality: str
    time_ns: int
    before_ns: int  # the poll before; None: unknown


class Payload:

    def __init__(self, data):
        self.data, self.at = data, 0

    def byte(self):
        self.at += 1
        return self.data[self.at - 1]

    def varint(self):
        number = shift = 0
        while True:
            byte = self.byte()
            number |= (byte & 0x7F) << shift
            if byte < 0x80:
                return number
            shift += 7

    def signed(self):
        bits = self.varint()
        return bits >> 1 ^ -(bits & 1)

    def bytes(self):
        size = self.varint()
        self.at += size
        return self.data[self.at - size:self.at]

    def float(self):
        self.at += 4
        return struct.unpack("<f", self.data[self.at - 4:self.at])[0]

    def double(self):
        self.at += 8
        return struct.unpack("<d", self.data[self.at - 8:self.at])[0]


def decode_samples(data):
    """The samples of a record, as src/publish/outputs/sample_codec.cpp describes them."""
    payload = Payload(data)
    if payload.byte() != 2:
        raise ValueError("another version of samples")
    variables, texts = [], [b""] * 4  # variable, device, line, unit
    for _ in range(payload.varint()):
        texts = [text[:payload.varint()] + payload.bytes() for text in texts]
        payload.at += 2  # type, scaled
        variables.append(texts[0].decode())
    samples, time = [], 0
    for _ in range(payload.varint()):
        variable = variables[payload.varint()]
        flags, more = payload.byte(), payload.byte()
        time += payload.signed()
        before = time - payload.varint() if flags & 0x80 else None
        if more & 1:
            payload.varint()  # the reason
        kind = flags >> 4 & 7
        value = (None if kind == 0 else bool(more & 2) if kind == 1 else
                 payload.signed() if kind == 2 else payload.varint() if kind == 3 else payload.double(
                 ) if kind == 4 else payload.bytes().decode() if kind == 5 else payload.float())
        samples.append(Sample(variable, value, QUALITIES[flags & 3], time, before))
    if payload.at != len(data):
        raise ValueError("bytes behind the samples")
    return samples
