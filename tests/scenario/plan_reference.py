"""Plans judged from outside: bus time, least bus time, coverage and response times computed anew from the
project, after docs/planning.md, "Bus time", and docs/guarantees.md, "Model". Nothing is shared with the
planner."""
import math
from fractions import Fraction as Fr

UNKNOWN_TURNAROUND_US = 5000
READ_LIMIT = {1: 2000, 2: 2000, 3: 125, 4: 125}


class Line:
    """The times of a project's line and device, in exact microseconds."""

    def __init__(self, framing="rtu", baud=19200, bits=11, turnaround_us=None, response_timeout_us=500_000,
                 request_gap_us=0, frame_gap_us=0, round_trip_us=1000, jitter_us=1000, overhead_us=200,
                 margin_us=2000, derive=True):
        self.__dict__.update(locals())
        self.serial = framing != "tcp"
        self.character = Fr(bits * 1_000_000, baud) if self.serial else Fr(1, 100)
        self.silence = Fr(0)
        if framing == "rtu":
            self.silence = self.character * Fr(7, 2) if baud <= 19200 else Fr(1750)
        self.pause = max(self.silence, Fr(frame_gap_us))

    def characters(self, pdu):
        return {"rtu": pdu + 3, "ascii": 2 * (pdu + 2) + 3, "tcp": pdu + 7}[self.framing]

    def frames(self, function, quantity):
        data = {1: -(-quantity // 8), 2: -(-quantity // 8), 3: 2 * quantity, 4: 2 * quantity}
        if function in data:
            return self.characters(5), self.characters(2 + data[function])
        if function in (5, 6):
            return self.characters(5), self.characters(5)
        if function == 15:
            return self.characters(6 + -(-quantity // 8)), self.characters(5)
        if function == 16:
            return self.characters(6 + 2 * quantity), self.characters(5)
        if function == 22:
            return self.characters(7), self.characters(7)
        raise ValueError(function)

    def bus_time(self, function, quantity):
        asked, answered = self.frames(function, quantity)
        time = (asked + answered) * self.character
        if self.serial:
            turnaround = UNKNOWN_TURNAROUND_US if self.turnaround_us is None else self.turnaround_us
            time += self.pause + max(Fr(turnaround), self.silence)
        else:
            time += self.frame_gap_us + self.round_trip_us
        return max(time, Fr(self.request_gap_us))

    def proved(self, function, quantity):
        """C and F in whole microseconds."""
        asked, answered = (n * self.character for n in self.frames(function, quantity))
        known = self.turnaround_us is not None
        turnaround = max(Fr(self.turnaround_us if known else self.response_timeout_us), self.silence)
        base = turnaround if known and self.derive else Fr(self.response_timeout_us)
        time_out = math.ceil(base + answered + self.margin_us)
        c = max(asked + turnaround + answered + self.pause + self.overhead_us, Fr(self.request_gap_us))
        f = max(math.ceil(c), math.ceil(asked + time_out + self.pause + self.overhead_us))
        return math.ceil(c), f


def least_cost(line, function, spans, limit, readable):
    """Least bus time of requests that cover all spans (start, end): plain dynamic programme over every
    window. `readable(item)`: may an item that is not requested be read."""
    spans = sorted(set(spans))
    if not spans:
        return Fr(0)
    asked = set()
    for start, end in spans:
        asked.update(range(start, end))
    starts = sorted({s for s, _ in spans})
    costs = [line.bus_time(function, n) for n in range(1, limit + 1)]
    # best[k]: all spans with start < starts[k] covered
    best = [None] * (len(starts) + 1)
    best[0] = Fr(0)
    ends = {s: max(e for a, e in spans if a == s) for s in starts}
    for k, first in enumerate(starts):
        if best[k] is None:
            continue
        end = first
        for m in range(k, len(starts)):
            if starts[m] > end and not all(i in asked or readable(i) for i in range(end, starts[m])):
                break
            end = max(end, ends[starts[m]])
            if end - first > limit:
                break
            cost = best[k] + costs[end - first - 1]
            if best[m + 1] is None or cost < best[m + 1]:
                best[m + 1] = cost
    return best[len(starts)]


def aligned_utilization(line, function, variables, limit, readable):
    """Phases aligned, re-optimised at each tick. variables: (start, end, period_ms)."""
    periods = sorted({p for _, _, p in variables})
    hyper = math.lcm(*periods)
    seen, total = {}, Fr(0)
    ticks = sorted({t for p in periods for t in range(0, hyper, p)})
    for t in ticks:
        due = tuple(p for p in periods if t % p == 0)
        if due not in seen:
            asked = {i for s, e, _ in variables for i in range(s, e)}
            seen[due] = least_cost(line, function, [(s, e) for s, e, p in variables if p in due], limit,
                                   lambda i: readable(i) or i in asked)
        total += seen[due]
    return total / (hyper * 1000)


def response_times(tasks, burst=0, every=None, failure_of=None):
    """Guarantees, "Fixed priority": tasks are dicts c (frames), F, T, J, b, prio; less is more urgent."""

    def errors(t, first):
        return 0 if not every else max(0, burst + t // every + first)

    def bound(i, lost):
        me = tasks[i]
        total, last = sum(me["c"]), me["c"][-1]
        higher = [k for k in tasks if k["prio"] < me["prio"]]
        equal = [k for j, k in enumerate(tasks) if k["prio"] == me["prio"] and j != i]
        lower = [k for k in tasks if k["prio"] > me["prio"]]
        blocking = max([k["F"] if lost else max(k["c"]) for k in lower], default=0)
        worst = max(k["F"] for k in higher + equal + [me])
        loss = -1 if lost else 0
        if sum(Fr(sum(k["c"]), k["T"])
               for k in higher + equal + [me]) + (Fr(worst, every) if every else 0) > 1:
            return None

        def half_open(k, t):
            return k["b"] + (t + k["J"] - 1) // k["T"]

        def closed(k, t):
            return k["b"] + (t + k["J"]) // k["T"]

        t = blocking + sum(sum(k["c"]) for k in higher + equal + [me])
        while True:
            u = (blocking + sum(half_open(k, t) * sum(k["c"])
                                for k in higher + equal + [me]) + errors(t, loss) * worst)
            if u == t:
                break
            t = u
            if t > 10**10:
                return None
        result = 0
        for q in range(half_open(me, t)):
            a = max(0, q - me["b"] + 1) * me["T"] - me["J"]
            w = blocking + (q + 1) * total - last
            while True:
                u = (blocking + (q + 1) * total - last + sum(closed(k, w) * sum(k["c"]) for k in higher) +
                     sum(closed(k, max(0, a)) * sum(k["c"]) for k in equal) + errors(w + last, loss) * worst)
                if u == w:
                    break
                w = u
            result = max(result, w + last - a)
        return result

    if not every:
        return [bound(i, False) for i in range(len(tasks))]
    both = [(bound(i, False), bound(i, True)) for i in range(len(tasks))]
    return [None if None in pair else max(pair) for pair in both]


def with_dead_device(tasks, device, backoff):
    """The same tasks while all requests of `device` fail."""
    return [
        dict(k, c=[k["F"]] * k["attempts"], T=max(k["T"], backoff)) if k["device"] == device else k
        for k in tasks
    ]


# Each unit shows once in this time that it is in step (docs/decisions/0039-surplus-responses.md).
CHECK_US = 1_000_000


def needs_hold(me, response):
    """Whether reads of a unit with one request may go on for the whole time, each less than a cost after the
    one before. @param response  None: unbounded"""
    if response is None:
        return True
    cost = sum(me["c"])
    latest = response - cost  # start after the release
    starts = lambda time: me["b"] + (time + latest) // me["T"]
    end = CHECK_US + 2 * cost
    steps = range((CHECK_US + latest) // me["T"] + 1, (end + latest) // me["T"] + 1)
    return any(2 * cost * (starts(time) - 1) > time
               for time in [CHECK_US] + [n * me["T"] - latest for n in steps])


def with_holds(tasks, analyse):
    """`analyse`: the responses of tasks. A hold is a task of the highest priority for the request that it
    holds back; for the others that request comes up to so much later."""

    def responses_with(held):
        holds = [
            sum(k["c"]) + max((max(o["c"]) for o in tasks if o is not k), default=0) if i in held else 0
            for i, k in enumerate(tasks)
        ]
        later = [dict(k, J=k["J"] + hold) for k, hold in zip(tasks, holds)]
        responses = analyse(later)
        for i in held:
            own = [*later[:i], tasks[i], *later[i + 1:]]
            task = dict(c=[holds[i]], F=0, T=CHECK_US, J=holds[i], b=1, prio=-1, device=None, attempts=1)
            responses[i] = analyse([*own, task])[i]
        return responses

    held = set()
    while True:
        responses = responses_with(held)
        needed = held | {i for i, k in enumerate(tasks) if needs_hold(k, responses[i])}
        if needed == held:
            return responses
        held = needed
