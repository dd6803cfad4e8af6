"""Texts of project files."""

UNUSED_PORT = "/dev/takt-test-no-such-port"


def quick(runs):
    """Settings of a device, so that a test need not wait for the defaults. In a project that runs, an answer
    of a busy machine is no time-out: tests of time-outs write their own."""
    return {"poll_period": "100ms", "response_timeout": "10s" if runs else "100ms"}


# A server of ten holding registers; its variables follow. For str.format(port=…).
TEN_REGISTERS = """servers:
  - name: s
    listen: 127.0.0.1
    tcp_port: {port}
    units:
      - address: 1
        banks:
          - {{area: holding_register, items: [0..9]}}
        high_register_first: true
        variables:
"""


# Banks of all items, as those of a blank device.
ALL_ITEMS = "banks: [" + ", ".join(
    f"{{area: {area}, items: [0..65535]}}"
    for area in ("coil", "discrete_input", "input_register", "holding_register")) + "]"


def slave(place, unit, banks=ALL_ITEMS):
    """A project of one server with unit 1. `place` is where it answers, `unit` further keys of the unit:
    lines of `key: value`."""
    lines = [*place, "units:", "  - address: 1", *(f"    {key}" for key in (banks, *unit))]
    return "takt: 1\nservers:\n  - name: s\n" + "".join(f"    {line}\n" for line in lines)


def serial(variables, *, port=UNUSED_PORT, framing="rtu", profile="generic", local="", line="", **device):
    """A project of one serial line with the device Node1, unit 16.

    `variables` are mappings as in the file, without braces ("name: V1, type: float, …"). Without a name
    they are V1, V2, … `line` has further keys of the line, `device` settings of it, `local` the locals.
    """
    settings = {
        "name": "Node1",
        "address": 16,
        **quick(port != UNUSED_PORT), "group_requests": "true",
        "strategy": "classic"
    } | device
    text = [
        "takt: 1", f"profile: {profile}", "lines:", "  - name: rs485-1", "    transport: serial",
        f"    port: {port}", f"    framing: {framing}", "    baud: 115200", "    parity: none"
    ]
    if framing == "ascii":
        text.append("    data_bits: 7")
    text += [f"    {key}" for key in line.split("\n") if key]
    text.append("    devices:")
    for number, (key, value) in enumerate(settings.items()):
        text.append(f"      {'-' if number == 0 else ' '} {key}: {value}")
    return "\n".join(text) + "\n" + variable_list(variables, "        ") + local_list(local)


def tcp(variables, port, *, local="", **device):
    """A project of one Modbus TCP line to 127.0.0.1 with the device Node1, unit 1."""
    settings = {
        "name": "Node1",
        "address": 1,
        **quick(True), "group_requests": "true",
        "strategy": "classic"
    } | device
    text = [
        "takt: 1", "lines:", "  - name: net", "    transport: tcp", "    host: 127.0.0.1",
        f"    tcp_port: {port}", "    framing: tcp", "    devices:"
    ]
    for number, (key, value) in enumerate(settings.items()):
        text.append(f"      {'-' if number == 0 else ' '} {key}: {value}")
    return "\n".join(text) + "\n" + variable_list(variables, "        ") + local_list(local)


def variable_list(variables, indent):
    lines = [f"{indent}variables:"]
    for number, mapping in enumerate(variables, 1):
        name = "" if mapping.startswith("name:") else f"name: V{number}, "
        lines.append(f"{indent}  - {{{name}{mapping}}}")
    return "\n".join(lines) + "\n"


def local_list(local):
    return "locals:\n" + "".join(f"  - {{{x}}}\n" for x in local) if local else ""


def at(registers, what):
    """One variable of the kind `what` at each of `registers`."""
    return [f"register: {register}, {what}" for register in registers]


def scenario_1(grouped=True, registers_per_request=125, port=UNUSED_PORT):
    """docs/specification.md, section 5, scenario 1 (ungrouped: scenario 2): ten floats, unit 16."""
    settings = {"poll_period": "100ms", "group_requests": str(grouped).lower()}
    if grouped:
        settings["registers_per_request"] = registers_per_request
    else:
        settings["strategy"] = "single"
    return serial(at(range(0, 20, 2), "type: float, read: 0x03"), port=port, **settings)


def scenario_3(grouped=True, port=UNUSED_PORT, pair_period="100ms", third_period="50ms"):
    """docs/specification.md, section 5, scenario 3: three ints with periods and start-reading triggers."""
    settings = {"group_requests": str(grouped).lower()}
    if grouped:
        settings["registers_per_request"] = 16
    else:
        settings["strategy"] = "single"
    return serial([
        f"name: First, type: int, register: 500, read: 0x03, period: {pair_period}, read_trigger: T512",
        f"name: Second, type: int, register: 501, read: 0x03, period: {pair_period}, read_trigger: T512",
        f"name: Third, type: int, register: 506, read: 0x04, period: {third_period}, read_trigger: T600",
    ], port=port, local=["name: T512, type: bool", "name: T600, type: bool"], **settings)
