"""The records of a journal that count, and the rules for what is on the disk.

A sample counts as soon as it is on the disk. It has a number, `seq`: its record's count of samples before it,
and its place in the record.
"""
import bisect
import struct
from datetime import datetime, timezone

from journal_files import SAMPLES, decode_samples

SEGMENT_BYTES = 16 << 20


class Violation(Exception):
    """What the program must not do."""


def require(condition, rule, *facts):
    if not condition:
        raise Violation(f"{rule}: {', '.join(str(fact) for fact in facts)}" if facts else rule)


def text_of(ns):
    """As the program writes a time: milliseconds, rounded down."""
    time = datetime.fromtimestamp(ns // 1_000_000_000, timezone.utc)
    return f"{time:%Y-%m-%dT%H:%M:%S}.{ns // 1_000_000 % 1000:03d}Z"


def float32(value):
    return struct.unpack("<f", struct.pack("<f", value))[0]


def same_value(sent, kept):
    if isinstance(kept, float):
        return isinstance(sent, (int, float)) and float32(sent) == float32(kept)
    return sent == kept and isinstance(sent, bool) == isinstance(kept, bool)


class Ledger:
    """The records of a journal that were durable when the program was killed."""

    def __init__(self, quota_bytes=None, keeps=True):
        self.quota_bytes = quota_bytes  # small enough to be reached
        self.keeps = keeps  # acknowledged records stay
        self.records = {}  # by sequence number
        self.first_on_disk = self._checked_from = 1  # sequence number
        self.newest = None
        self.holes = set()  # (first missing sample, samples) between records on the disk
        self.cursor = None
        self.starts = []  # (wall time before, wall time after) of each start
        self._samples, self._befores, self._by_before = {}, [], []
        self._ends = {}

    def add(self, stream, cut):
        """The records that are durable now. `cut`: what was not synchronised may have been removed."""
        self._check_order(stream, cut)
        new = []
        for record in stream:
            known = self.records.get(record.sequence)
            require(known is None or known == record, "a sequence number was used again", known, record)
            if known is None:
                new.append(record)
        if self.newest:
            require(stream and stream[-1].sequence >= self.newest.sequence, "records are missing at the end",
                    self.newest.sequence, stream[-1].sequence if stream else 0)
        self._check_holes(stream)
        if stream:
            self.first_on_disk = stream[0].sequence
        before = self.newest
        for record in new:
            self._check_epoch(record, before, cut)
            before = self._insert(record)

    def add_removed(self, records):
        """Records that became durable and were removed since the last add(), in their order."""
        for record in records:
            if record.sequence not in self.records:
                self._check_epoch(record, self.newest, True)
                self._insert(record)

    def _check_order(self, stream, cut):
        for before, after in zip(stream, stream[1:]):
            require(after.sequence > before.sequence and after.before >= before.end,
                    "records are not in order", before, after)
            if after.sequence != before.sequence + 1 or after.before != before.end:
                require(cut, "records are missing on the disk", before.sequence, after.sequence)
                self.holes.add((before.end + 1, after.before - before.end))

    def _check_holes(self, stream):
        present = {record.sequence for record in stream}
        for sequence in self.records:
            require(sequence < stream[0].sequence or sequence in present, "a durable record is missing",
                    sequence)

    def check_removed(self, disk_bytes):
        """To be called after set_cursor()."""
        removed = [
            self.records[n] for n in range(self._checked_from, self.first_on_disk) if n in self.records
        ]
        self._checked_from = self.first_on_disk
        acknowledged = self.cursor.sequence if self.cursor else 0
        if removed and (self.keeps or removed[-1].sequence > acknowledged):
            size = disk_bytes + sum(len(record.payload) for record in removed)
            require(self.quota_bytes and size > self.quota_bytes - SEGMENT_BYTES - (1 << 20),
                    "a record was removed before its time", removed[-1].sequence, acknowledged, size)

    def _check_epoch(self, record, before, cut):
        if before and record.epoch == before.epoch:
            return
        if cut and before and before.sequence != record.sequence - 1:
            return  # the power cut took the beginning of the epoch
        gap = record.gap
        require(gap and gap.cause == "restart" and gap.samples == 0, "a start has no gap of cause restart",
                record)
        require(record.epoch == (before.epoch + 1 if before else gap.last_ns // 1_000_000_000),
                "an epoch does not follow the one before", record)
        require(any(begin <= gap.last_ns <= end for begin, end in self.starts), "a gap ends at no start", gap)
        if not before:
            require(gap.first_ns == gap.last_ns, "the first gap has a length", gap)
        else:
            require(gap.first_ns == before.wall_ns, "a gap does not begin at the last durable record", gap,
                    before)

    def _insert(self, record):
        self.records[record.sequence] = self.newest = record
        self._ends.setdefault(record.end, []).append(record)
        if record.samples:
            self._befores.append(record.before)
            self._by_before.append(record)
        return record

    def set_cursor(self, cursor, acknowledged_to=None):
        """The durable cursor. `acknowledged_to`: samples up to this one were acknowledged by the broker."""
        require(cursor or not self.cursor, "the cursor is gone")
        if not cursor:
            return
        require(cursor.delivered + cursor.dropped == cursor.samples,
                "the counters of the cursor do not add up", cursor)
        last = self.cursor
        require(not last or cursor.sequence >= last.sequence, "the cursor went back", last, cursor)
        if acknowledged_to is not None:
            require(cursor.samples <= acknowledged_to, "the cursor is past the last acknowledgement", cursor,
                    acknowledged_to)
        record = self.records.get(cursor.sequence)
        require(not record or record.end == cursor.samples, "the cursor counts other samples than its record",
                cursor, record)
        self.cursor = cursor

    def go_back(self):
        """A replay may move the cursor back."""
        self.cursor = None

    def end(self):
        return self.newest.end if self.newest else 0

    def holding(self, number):
        """The record with a sample, or None."""
        at = bisect.bisect_left(self._befores, number) - 1
        record = self._by_before[at] if at >= 0 else None
        return record if record and number <= record.end else None

    def sample(self, number):
        """(record, sample) or None: it is missing, or a part of a gap."""
        record = self.holding(number)
        if not record or record.type != SAMPLES:
            return None
        if record.sequence not in self._samples:
            if len(self._samples) > 4096:
                self._samples.clear()
            self._samples[record.sequence] = decode_samples(record.payload)
        return record, self._samples[record.sequence][number - record.before - 1]

    def numbers(self):
        """Of all samples that are owed to the destination."""
        for record in self._by_before:
            if record.type == SAMPLES:
                yield from range(record.before + 1, record.end + 1)

    def gaps(self):
        return [record for record in self.records.values() if record.gap]

    def epoch_after(self, sequence):
        """Of the run whose first record follows this one; 0: it has no durable record."""
        newest = max(self.restarts(), key=lambda record: record.sequence, default=None)
        return newest.epoch if newest and newest.sequence > sequence else 0

    def restarts(self):
        return [record for record in self.gaps() if record.gap.cause == "restart"]

    def ending_at(self, number):
        return self._ends.get(number, [])

    def beginning_at(self, number):
        """Records whose first sample has this number."""
        at = bisect.bisect_left(self._befores, number - 1)
        found = [self._by_before[at]] if at < len(self._befores) and self._befores[at] == number - 1 else []
        return found + [record for record in self.ending_at(number - 1) if record.before == number - 1]
