"""Random projects through `takt plan --json`, judged by plan_reference: coverage, bus time, least bus time,
several periods, response times."""
import math
import random
from fractions import Fraction as Fr

import pytest

from plan_reference import (READ_LIMIT, Line, aligned_utilization, least_cost, response_times,
                            with_dead_device, with_holds)
from program import takt

TYPES = {"int16": 1, "uint32": 2, "float": 2, "double": 4, "int64": 4}
LINES = [
    dict(framing=framing, baud=baud, turnaround_us=turnaround) for framing in ("rtu", "ascii")
    for baud in (1200, 9600, 19200, 115200, 921600) for turnaround in (None, 0, 5000, 50000)
] + [dict(framing="tcp", round_trip_us=r) for r in (0, 1000, 40000)]


def random_variables(random_, function, count, spread, periods):
    made = []
    for i in range(count):
        if function in (1, 2):
            start = random_.randrange(spread)
            made.append((f"v{i}", f"type: bool, coil: {start}", start, start + 1, random_.choice(periods)))
            continue
        kind = random_.choice([*TYPES, "string"])
        length = random_.randint(1, 20) if kind == "string" else TYPES[kind]
        start = random_.randrange(spread)
        extra = f", length: {length}" if kind == "string" else ""
        made.append((f"v{i}", f"type: {kind}, register: {start}{extra}", start, start + length,
                     random_.choice(periods)))
    random_.shuffle(made)
    return made


def project_text(line, devices, more_device=""):
    head = [
        "takt: 1", f"timeout_margin: {line.margin_us}us",
        f"host: {{jitter: {line.jitter_us}us, overhead: {line.overhead_us}us}}", "lines:"
    ]
    if line.serial:
        bits = "parity: even"
        data = ", data_bits: 7" if line.framing == "ascii" else ""
        head += [
            f"  - {{name: l, transport: serial, port: /dev/ttyS9, framing: {line.framing}, "
            f"baud: {line.baud}, {bits}{data}, request_gap: {line.request_gap_us}us, "
            f"frame_gap: {line.frame_gap_us}us, devices: ["
        ]
    else:
        head += ["  - {name: l, transport: tcp, host: 127.0.0.1, devices: ["]
    for unit, settings, function, variables in devices:
        turnaround = "" if line.turnaround_us is None else f", turnaround: {line.turnaround_us}us"
        trip = "" if line.serial else f", round_trip: {line.round_trip_us}us"
        time_out = "" if line.derive else f", response_timeout: {line.response_timeout_us}us"
        head += [
            f"     {{name: d{unit}, address: {unit}, group_requests: true, strategy: optimal"
            f"{turnaround}{trip}{time_out}{settings}, variables: ["
        ]
        head += [
            f"        {{name: d{unit}_{name}, {what}, read: 0x0{function}, period: {period}ms}},"
            for name, what, _, _, period in variables
        ]
        head += ["     ]},"]
    return "\n".join(head + ["  ]}", ""])


def line_of(settings):
    settings = dict(settings)
    bits = 10 if settings["framing"] == "ascii" else 11
    return Line(bits=bits, **settings)


def judge_coverage(line, requests, function, variables, unit, limit, readable):
    """Each variable is read at least once a period; nothing forbidden is read; every bus time is right."""
    asked = {i for _, _, s, e, _ in variables for i in range(s, e)}
    for r in requests:
        assert r["function"] == function
        assert 1 <= r["quantity"] <= limit
        for i in range(r["start"], r["start"] + r["quantity"]):
            assert i in asked or readable(i), (i, r)
        assert r["bus_time_us"] == math.ceil(line.bus_time(function, r["quantity"])), r
    for name, _, start, end, period in variables:
        mine = [r for r in requests if f"d{unit}_{name}" in r["variables"]]
        assert mine, name
        for r in mine:
            assert r["start"] <= start and end <= r["start"] + r["quantity"], (name, r)
        hyper = math.lcm(*(round(r["period_ms"]) for r in mine))
        instants = sorted(t for r in mine
                          for t in range(round(r.get("phase_ms", 0)), hyper, round(r["period_ms"])))
        gaps = [b - a for a, b in zip(instants, instants[1:] + [instants[0] + hyper])]
        assert max(gaps) <= period, (name, period, mine)


def judge(project, seed, line, gaps, periods, count, spread):
    random_ = random.Random(seed)
    function = random_.choice([1, 2, 3, 3, 4, 4])
    limit = READ_LIMIT[function]
    settings = f", gaps: {gaps}"
    if function > 2 and random_.random() < 0.3:
        limit = random_.randint(20, 125)
        settings += f", registers_per_request: {limit}"
    forbidden = set()
    if gaps != "never" and random_.random() < 0.5:
        first = random_.randrange(spread)
        forbidden = set(range(first, first + 5))
        settings += f", no_read: [[{first}, {first + 4}]]"
    variables = random_variables(random_, function, count, spread, periods)
    path = project(project_text(line, [(7, settings, function, variables)]))
    plan = takt("plan", path, "--json", code=None).json
    requests = plan["lines"][0]["requests"]
    readable = (lambda i: False) if gaps == "never" else (lambda i: i not in forbidden)
    judge_coverage(line, requests, function, variables, 7, limit, readable)
    used = sum(line.bus_time(function, r["quantity"]) / (Fr(r["period_ms"]) * 1000) for r in requests)
    assert plan["lines"][0]["utilization"] == pytest.approx(float(used), rel=1e-9)
    asked = {i for _, _, s, e, _ in variables for i in range(s, e)}
    best = aligned_utilization(line, function, [v[2:] for v in variables], limit, readable)
    alone = sum(
        least_cost(line, function, [v[2:4] for v in variables
                                    if v[4] == p], limit, lambda i: i in asked or readable(i)) / (p * 1000)
        for p in {v[4]
                  for v in variables})
    return used, best, alone


@pytest.mark.parametrize("seed", range(24))
def test_one_period_costs_the_least(project, seed):
    random_ = random.Random(seed)
    line = line_of(random_.choice(LINES))
    used, best, _ = judge(project, seed, line, random_.choice(["never", "always", "learn"]), [200],
                          random_.randint(1, 60), random_.choice([60, 400, 3000]))
    assert used == best


PERIODS = [(100, 1000), (100, 200, 500, 1000), (250, 1000, 5000), (300, 500), (100, 150, 1000),
           (97, 101, 103, 107)]


@pytest.mark.parametrize("seed", range(24))
def test_several_periods_cost_no_more_than_aligned_rounds(project, seed):
    random_ = random.Random(1000 + seed)
    line = line_of(random_.choice(LINES))
    periods = PERIODS[seed % len(PERIODS)]
    used, best, alone = judge(project, seed, line, random_.choice(["never", "always"]), periods,
                              random_.randint(2, 40), random_.choice([60, 400]))
    assert used <= alone
    if periods[0] != 97:
        assert used <= best * Fr(102, 100), float(used / best)


def judge_responses(project, seed):
    random_ = random.Random(5000 + seed)
    settings = random_.choice([s for s in LINES if s["framing"] == "rtu" and s["baud"] >= 9600])
    # A written time-out counts, also where the turnaround is known.
    time_out = random_.choice([dict(), dict(derive=False, response_timeout_us=100_000)])
    line = line_of(settings | time_out)
    devices = []
    for unit in range(1, random_.randint(2, 7)):
        function, count = random_.choice([3, 4]), random_.randint(1, 10)
        period = random_.choice([200, 300, 500, 1000, 2000, 5000])
        variables = [(f"v{i}", f"type: float, register: {10 + 2 * i}", 10 + 2 * i, 12 + 2 * i, period)
                     for i in range(count)]
        devices.append((unit, "", function, variables))
    text = project_text(line, devices) + "faults: {burst: 1, every: 1s}\nbackoff: 2s\n"
    plan = takt("plan", project(text), "--json", code=None).json["lines"][0]
    requests = plan["requests"]
    tasks = []
    order = sorted(range(len(requests)), key=lambda i: (requests[i]["period_ms"], requests[i]["unit"]))
    for i, r in enumerate(requests):
        c, f = line.proved(r["function"], r["quantity"])
        assert (r["c_us"], r["f_us"]) == (c, f)
        assert r["deadline_us"] == r["period_ms"] * 1000
        tasks.append(
            dict(c=[c], F=f, T=round(r["period_ms"] * 1000), J=line.jitter_us, b=1, prio=order.index(i),
                 device=r["unit"], attempts=3))
    free = with_holds(tasks, response_times)
    faulty = with_holds(tasks, lambda made: response_times(made, 1, 1_000_000))
    devices = {k["device"] for k in tasks}

    def worst_of_dead(made):
        """Of each task, over each other device being dead."""
        by_device = {d: response_times(with_dead_device(made, d, 2_000_000)) for d in devices}
        worst = response_times(made)
        for i, k in enumerate(made):
            others = [by_device[d][i] for d in devices if d != k["device"]]
            if others:
                worst[i] = None if None in others else max(others)
        return worst

    dead = with_holds(tasks, worst_of_dead)
    for i, r in enumerate(requests):
        assert r["response_us"] == free[i]
        if line.turnaround_us is not None:  # else a request may have to wait for a late answer, too
            assert r["response_fault_us"] == faulty[i]
        assert r["response_dead_us"] == dead[i]
        if free[i] is not None:
            assert r["age_us"] == tasks[i]["T"] + free[i]
    feasible = all(x is not None and x <= k["T"] for x, k in zip(free, tasks))
    assert plan["feasible"] == feasible


@pytest.mark.parametrize("seed", range(24))
def test_response_times_are_those_of_the_equations(project, seed):
    judge_responses(project, seed)
