"""The rules for what was published and what arrived, by the records that were on the disk."""
from collections import Counter

from field import FIXED
from journal_files import decode_samples
from ledger import float32, require, same_value, text_of

DERIVED = ("quota", "damaged")  # gaps that are not records


def check_sample(item, ledger):
    """Every value of a message is the one on the disk."""
    require(
        sorted(item.values) == list(range(item.first, item.first + item.count)), "numbers in a message", item)
    for number, sent in item.values.items():
        found = ledger.sample(number)
        require(found, "a sample was published that is not durable", item)
        record, kept = found
        require(record.epoch == item.epoch, "a sample has another epoch than its record", item, record)
        before = text_of(kept.before_ns) if kept.before_ns is not None else None
        of_before = sent.get("after" if kept.quality == "good" else "last_good")
        same = (sent["variable"] == kept.variable and same_value(sent["value"], kept.value)
                and sent["quality"] == kept.quality and sent["time"] == text_of(kept.time_ns)
                and of_before == before)
        require(same, "a sample differs from the one on the disk", sent, kept)


def check_gap(item, ledger):
    """A gap is a record, or is exactly what is missing on the disk."""
    gap, next_number = item.gap, item.first + item.count
    if gap["cause"] in DERIVED:
        befores = {text_of(record.wall_ns) for record in ledger.ending_at(item.first - 1)}
        afters = {(text_of(record.wall_ns), record.epoch) for record in ledger.beginning_at(next_number)}
        # Before the first record there is the first start, which may have written none.
        from_start = item.first == 1 and text_of(ledger.starts[0][0]) <= gap["first"] <= min(befores)
        require(gap["first"] in befores or from_start, "a derived gap does not begin at the record before",
                item, befores)
        require((gap["last"], item.epoch) in afters, "a derived gap does not end at the record after", item,
                afters)
        if gap["cause"] == "damaged":
            require((item.first, item.count) in ledger.holes, "a gap where nothing is damaged", item)
            return
        require(ledger.quota_bytes, "a gap of the quota, which was not reached", item)
        first = ledger.records.get(ledger.first_on_disk)
        require(not first or next_number <= first.before + 1, "a gap has samples that are on the disk", item)
        return
    matching = [
        record for record in ledger.ending_at(next_number - 1)
        if record.gap and record.before == item.first - 1
    ]
    for record in matching:
        kept = record.gap
        if (record.epoch, kept.cause, kept.samples, text_of(kept.first_ns),
                text_of(kept.last_ns)) == (item.epoch, gap["cause"], gap["samples"], gap["first"],
                                           gap["last"]):
            return
    require(False, "a gap that is not on the disk", item, matching)


class Delivery:
    """Judges the messages of an output with transport mqtt."""

    NONE, SAMPLE, GAP = 0, 1, 2

    def __init__(self, ledger):
        self.ledger = ledger
        self.acknowledged = set()  # numbers
        self.acknowledged_to = 0  # all up to this one
        self.fate = bytearray(1)  # of each number, when it was published last
        self.published = set()  # (kind, first, epoch) ever
        self.received = set()  # numbers
        self.gaps_received = set()  # (first, epoch, cause)
        self.covered = set()  # numbers in gaps that arrived
        self.counts = Counter()
        self._published_at = self._received_at = 0
        self._expected = self._expected_there = None
        self._connections_of_run = Counter()

    def check(self, wire):
        """Judges what is new. The ledger has what was durable before."""
        while self._published_at < len(wire.events):
            event, run, item = wire.events[self._published_at]
            self._published_at += 1
            if event == "connect":
                self._expected = None
                self._connections_of_run[run] += 1
            elif item.kind in ("sample", "gap"):
                (self._publish if event == "publish" else self._acknowledge)(item, run)
        while self._received_at < len(wire.received):
            item = wire.received[self._received_at]
            self._received_at += 1
            if item.kind == "online":
                self._expected_there = None
            elif item.kind in ("sample", "gap"):
                self._receive(item)

    def _check_content(self, item):
        if not item.checked:
            (check_sample if item.kind == "sample" else check_gap)(item, self.ledger)
            item.checked = True

    def _publish(self, item, run):
        self._check_content(item)
        if self._expected is None:
            require(item.first <= self.acknowledged_to + 1,
                    "a connection begins behind what is not acknowledged", item, self.acknowledged_to)
        else:
            require(item.first == self._expected, "not in order", item, self._expected)
        self._expected = item.first + item.count
        end = item.first + item.count
        self.fate.extend(bytes(max(0, end - len(self.fate))))
        self.fate[item.first:end] = bytes((self.SAMPLE if item.kind == "sample" else self.GAP, )) * item.count
        self._check_repeated(item, run)
        self.counts[f"gaps {item.gap['cause']}" if item.gap else "messages"] += 1

    def _check_repeated(self, item, run):
        key = (item.kind, item.first, item.count, item.epoch, item.gap["cause"] if item.gap else "")
        if key in self.published:
            self.counts["repeated"] += 1
            require(item.repeated, "a repeat is not marked", item)
        elif item.epoch == self.epoch_of_run and self._connections_of_run[run] == 1:
            require(not item.repeated, "the first delivery is marked as a repeat", item)
        self.published.add(key)

    epoch_of_run = 0  # of the run that ended last; 0: it has no durable record

    def _acknowledge(self, item, _run):
        self.acknowledged.update(range(item.first, item.first + item.count))
        while self.acknowledged_to + 1 in self.acknowledged:
            self.acknowledged_to += 1

    def _receive(self, item):
        self._check_content(item)
        if self._expected_there is not None:
            require(item.first == self._expected_there, "the subscriber gets another order", item,
                    self._expected_there)
        self._expected_there = item.first + item.count
        if item.kind == "gap":
            self.gaps_received.add((item.first, item.epoch, item.gap["cause"]))
            self.covered.update(range(item.first, item.first + item.count))
        else:
            self.received.update(item.values)
        self.counts["received"] += 1

    def missing(self):
        """Numbers of samples that are owed and did not arrive, also not as a gap."""
        return [n for n in self.ledger.numbers() if n not in self.received and n not in self.covered]

    def missing_gaps(self):
        on_disk = [record for record in self.ledger.gaps() if record.sequence >= self.ledger.first_on_disk]
        return [
            record for record in on_disk
            if (record.before + 1, record.epoch, record.gap.cause) not in self.gaps_received
        ]

    def check_counters(self, output, exact):
        """At an orderly end. `exact`: nothing was replayed."""
        counters = {key: output[key] for key in ("sampled", "delivered", "waiting", "dropped")}
        require(output["sampled"] == output["delivered"] + output["waiting"] + output["dropped"],
                "the counters do not add up", counters)
        require(output["sampled"] == self.ledger.end(), "other samples are counted than are on the disk",
                counters, self.ledger.end())
        if exact and output["waiting"] == 0:
            fate = self.fate[1:output["sampled"] + 1]
            require(output["delivered"] == fate.count(self.SAMPLE), "delivered", counters,
                    fate.count(self.SAMPLE))
            require(output["dropped"] == fate.count(self.GAP), "dropped", counters, fate.count(self.GAP))


def check_history(ledger, rows, gaps):
    """Every sample of the journal is in the history once, and nothing else. `rows`: (variable, time, value,
    quality); `gaps`: (first, last time) of those with the cause restart."""
    owed = Counter()
    for number in ledger.numbers():
        _, sample = ledger.sample(number)
        value = float32(sample.value) if isinstance(sample.value, float) else sample.value
        owed[(sample.variable, text_of(sample.time_ns), value, sample.quality)] += 1
    kept = Counter(rows)
    missing, surplus = owed - kept, kept - owed
    require(not missing, "samples are missing in the history", list(missing)[:3], missing.total())
    require(not surplus, "samples are in the history twice, or are no samples",
            list(surplus)[:3], surplus.total())
    times = [(text_of(record.gap.first_ns), text_of(record.gap.last_ns)) for record in ledger.restarts()]
    # The first start is a gap without a length.
    owed_gaps, kept_gaps = (sorted(gap for gap in some if gap[0] != gap[1]) for some in (times, gaps))
    require(owed_gaps == kept_gaps, "gaps of cause restart in the history", owed_gaps, kept_gaps)


class Counting:
    """Judges the samples of counting devices: while no gap is between them, the values of a counter follow
    one another, because the device counts each answer and each answer is a sample. A doubtful answer makes
    the value uncertain instead."""

    def __init__(self, ledger, devices):
        self.ledger, self.devices = ledger, devices
        self.counts = Counter()
        self._judged_to, self._before = 0, None
        self._last, self._doubtful = {}, set()  # by device: the last value, since the last gap

    def check(self):
        """Judges the records that are new."""
        for sequence in sorted(n for n in self.ledger.records if n > self._judged_to):
            record = self.ledger.records[sequence]
            self._judged_to = sequence
            before, self._before = self._before, record
            if record.gap or not before or (before.end, before.epoch) != (record.before, record.epoch):
                self._last = {}
            if record.gap:
                continue
            for sample in decode_samples(record.payload):
                self._check_sample(sample)

    def _check_sample(self, sample):
        name, _, value = sample.variable.rpartition(".")
        if sample.quality != "good":
            self._doubtful.add(name)
            return
        if value == "Fixed":
            require(sample.value == FIXED, "a sample with a value of another register", sample)
            return
        device = self.devices[name]
        last = self._last.get(name)
        require(0 < sample.value <= device.count, "a sample that the device did not send", sample,
                device.count)
        if sample.value == last:
            self.counts["sampled again by a reload"] += 1
            return
        if last is not None:
            require(sample.value > last, "a value goes back", sample, last)
            missing = [n for n in range(last + 1, sample.value) if not device.was_late(n)]
            require(not missing or name in self._doubtful, "a response is not sampled", sample, last)
        self._last[name] = sample.value
        self._doubtful.discard(name)
        self.counts["counted samples"] += 1
