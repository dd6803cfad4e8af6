#include "blueprint.hpp"

#include <array>
#include <string_view>

namespace takt::simtest {
namespace {

constexpr std::array kPeriods{200, 500, 500, 1000, 1000, 2000, 5000};

class Drawer {
public:
    explicit Drawer(std::uint64_t seed)
        : random_(sim::Random(seed).fork(0x70)), learns_(gaps_are_learnt(seed)) {}

    Blueprint draw() {
        made_.keys.emplace_back("takt", "1");
        if (chance(15)) made_.keys.emplace_back("derive_timeouts", "false");
        const auto first = 200 + 100 * random_.below(12);
        made_.keys.emplace_back("backoff", "{first: " + std::to_string(first) +
                                               "ms, limit: " + std::to_string(2 + random_.below(7)) + "s}");
        triggers_ = random_.below(4);
        statuses_ = random_.below(3);
        for (std::size_t i = 0; i < triggers_; ++i) add_trigger(i);
        for (std::size_t i = 0; i < statuses_; ++i)
            made_.locals.push_back({{"name", "status" + std::to_string(i)}, {"type", "int"}});
        const auto lines = chance(60) ? 1 : chance(60) ? 2 : 3;
        for (int i = 0; i < lines; ++i) add_line(i, lines);
        return std::move(made_);
    }

private:
    [[nodiscard]] bool chance(std::uint32_t percent) { return random_.below(100) < percent; }
    [[nodiscard]] std::string text(std::uint32_t least, std::uint32_t most) {
        return std::to_string(least + random_.below(most - least + 1));
    }

    void add_trigger(std::size_t i) {
        Keys keys{{"name", "trigger" + std::to_string(i)}, {"type", "bool"}};
        if (chance(40)) {
            keys.emplace_back("min_interval", text(1, 8) + "s");
            keys.emplace_back("burst", text(1, 2));
        }
        made_.locals.push_back(keys);
    }

    void add_line(int index, int lines) {
        LineBlueprint line;
        line.keys.emplace_back("name", "line" + std::to_string(index));
        const auto kind = random_.below(20);
        const bool serial = kind < 12;
        const bool ascii = kind >= 9 && kind < 12;
        tcp_ = kind >= 16;
        serial_ = serial;
        if (serial)
            add_serial(line.keys, index, ascii);
        else
            line.keys.insert(line.keys.end(), {{"transport", "tcp"},
                                               {"host", "device" + std::to_string(index)},
                                               {"framing", tcp_ ? "tcp" : "rtu"}});
        if (chance(25)) line.keys.emplace_back("order", "address");
        if (chance(15)) line.keys.emplace_back("frame_gap", text(2, 12) + "ms");
        if (chance(15)) line.keys.emplace_back("request_gap", text(5, 30) + "ms");
        const auto devices =
            1 + (chance(60) ? random_.below(4) : random_.below(10)) / static_cast<unsigned>(lines);
        unsigned address = 1 + random_.below(4);
        for (std::uint32_t d = 0; d < devices; ++d, address += 1 + random_.below(3))
            add_device(line, index, d, address);
        if (serial) add_broadcast(line, index);
        add_clients(line);
        made_.lines.push_back(std::move(line));
    }

    // A write to all devices of a line. It is drawn by itself, so that all else stays as without it.
    void add_broadcast(LineBlueprint& line, int index) {
        auto random = random_.fork(0xB0);
        if (random.below(5) != 0) return;
        DeviceBlueprint device;
        const std::string name = "all" + std::to_string(index);
        device.keys = {{"name", name}, {"address", "0"}};
        const bool changes = random.below(2) == 0;
        const bool wide = random.below(2) == 0;
        const auto start = 40 * random.below(3);
        for (std::uint32_t i = 0, count = 1 + random.below(3); i < count; ++i) {
            VariableBlueprint variable;
            variable.keys = {{"name", name + "_v" + std::to_string(i + 1)},
                             {"type", wide ? "int32" : "uint16"},
                             {"register", std::to_string(start + i * (wide ? 2 : 1))},
                             {"read", "none"},
                             {"write", wide || changes ? "0x10" : "0x06"}};
            if (changes) variable.keys.emplace_back("write_on_change", "true");
            device.variables.push_back(std::move(variable));
        }
        line.devices.push_back(std::move(device));
    }

    // How often clients may go before polling. Drawn by itself.
    void add_clients(LineBlueprint& line) {
        auto random = random_.fork(0xC1);
        constexpr std::array<std::string_view, 5> kIntervals{"20ms", "100ms", "500ms", "1s", "5s"};
        const auto interval = [&] { return std::string(kIntervals[random.below(kIntervals.size())]); };
        line.relayed = random.below(4) == 0;
        if (line.relayed) line.keys.emplace_back("relay_interval", interval());
        if (random.below(4) == 0) line.keys.emplace_back("command_interval", interval());
        if (random.below(8) == 0)
            line.keys.emplace_back("command_burst", std::to_string(1 + random.below(4)));
        line.response_timeout_ms = 20 + static_cast<int>(random.below(150));
    }

    void add_serial(Keys& keys, int index, bool ascii) {
        constexpr std::array<std::string_view, 5> kBaud{"9600", "19200", "38400", "57600", "115200"};
        constexpr std::array<std::string_view, 3> kParity{"none", "even", "odd"};
        keys.emplace_back("transport", "serial");
        keys.emplace_back("port", "/dev/ttySim" + std::to_string(index));
        keys.emplace_back("framing", ascii ? "ascii" : "rtu");
        keys.emplace_back("baud", std::string(kBaud[chance(60) ? 4 : random_.below(kBaud.size())]));
        keys.emplace_back("parity", std::string(kParity[random_.below(kParity.size())]));
        if (ascii) keys.emplace_back("data_bits", chance(70) ? "7" : "8");
        if (chance(20)) keys.emplace_back("stop_bits", "2");
    }

    void add_device(LineBlueprint& line, int index, std::uint32_t number, unsigned address) {
        DeviceBlueprint device;
        const std::string name = "d" + std::to_string(index) + "_" + std::to_string(number);
        device.keys = {{"name", name}, {"address", std::to_string(address)}};
        device.period_ms = kPeriods[random_.below(kPeriods.size())];
        const auto turnaround = 1 + random_.below(15);
        const auto in_flight = tcp_ && chance(60) ? 2 + random_.below(7) : 1;
        // It works on its requests one after the other.
        const auto timeout = in_flight * turnaround + 20 + random_.below(150);
        const bool known = in_flight == 1 && (serial_ ? chance(80) : chance(50));
        if (known) device.keys.emplace_back("turnaround", std::to_string(turnaround) + "ms");
        if (!known || chance(30))
            device.keys.emplace_back("response_timeout", std::to_string(timeout) + "ms");
        if (!serial_) device.keys.emplace_back("round_trip", std::to_string(turnaround) + "ms");
        device.keys.emplace_back("attempts", text(1, 4));
        if (in_flight > 1) device.keys.emplace_back("in_flight", std::to_string(in_flight));
        if (chance(10)) device.keys.emplace_back("backoff", text(300, 1500) + "ms");
        DeviceTraits traits{.prefix = name + "_v"};
        add_strategy(device.keys, traits);
        add_locals(device.keys, name);
        device.variables = VariableDrawer(random_, traits, triggers_, statuses_).draw(1 + random_.below(12));
        line.devices.push_back(std::move(device));
    }

    void add_strategy(Keys& keys, DeviceTraits& traits) {
        const auto strategy = random_.below(10);
        traits.optimal = strategy >= 5;
        keys.emplace_back("strategy", strategy < 2 ? "single" : strategy < 5 ? "classic" : "optimal");
        if (chance(40)) keys.emplace_back("registers_per_request", text(4, 40));
        if (traits.optimal && chance(60)) {
            traits.gaps_readable = true;
            const bool always = chance(70);
            keys.emplace_back("gaps", always ? "always" : "learn");
            traits.gaps_readable = always || !learns_ || random_.fork(6).below(2) == 0;
        }
        traits.mask_writes = chance(30);
        traits.modifies = chance(30);
        if (traits.mask_writes) keys.emplace_back("fc22", "true");
        if (traits.modifies) keys.emplace_back("read_modify_write", "true");
        if (traits.optimal && chance(30)) keys.emplace_back("fc23", "true");
        if (traits.optimal && chance(20)) keys.emplace_back("write_single", "allowed");
    }

    void add_locals(Keys& keys, const std::string& name) {
        if (chance(25)) {
            keys.emplace_back("poll_enable", name + "_on");
            made_.locals.push_back(
                {{"name", name + "_on"}, {"type", "bool"}, {"default", chance(80) ? "true" : "false"}});
        }
        if (chance(30)) {
            keys.emplace_back("status", name + "_status");
            made_.locals.push_back({{"name", name + "_status"}, {"type", "int"}});
        }
    }

    sim::Random random_;
    bool learns_;  // else gaps must be readable: the master does not detect that they are not
    Blueprint made_;
    std::size_t triggers_ = 0;
    std::size_t statuses_ = 0;
    bool tcp_ = false;
    bool serial_ = false;
};

std::string flow(const Keys& keys) {
    std::string text = "{";
    for (const auto& [key, value] : keys) text += (text.size() > 1 ? ", " : "") + key + ": " + value;
    return text + "}";
}

std::string block(const Keys& keys, const std::string& indent) {
    std::string text;
    for (const auto& [key, value] : keys) text += indent + key + ": " + value + "\n";
    return text;
}

/// The first key of a list item is behind its dash.
std::string item(const Keys& keys, const std::string& indent) {
    std::string text = block(keys, indent + "  ");
    text[indent.size()] = '-';
    return text;
}

}  // namespace

bool gaps_are_learnt(std::uint64_t seed) {
    return sim::Random(seed).fork(0x1EA2).below(2) == 0;
}

Blueprint draw_blueprint(std::uint64_t seed) {
    return Drawer(seed).draw();
}

std::string to_yaml(const Blueprint& blueprint, int slower) {
    std::string text = block(blueprint.keys, "") + "lines:\n";
    for (const auto& line : blueprint.lines) {
        text += item(line.keys, "  ") + "    devices:\n";
        for (const auto& device : line.devices) {
            text += item(device.keys, "      ");
            text += "        poll_period: " + std::to_string(device.period_ms * slower) + "ms\n";
            text += "        variables:\n";
            for (const auto& variable : device.variables) {
                Keys keys = variable.keys;
                if (variable.period_ms > 0)
                    keys.emplace_back("period", std::to_string(variable.period_ms * slower) + "ms");
                text += "          - " + flow(keys) + "\n";
            }
        }
    }
    int port = 15'020;
    for (const auto& line : blueprint.lines) {
        if (!line.relayed) continue;
        if (port == 15'020) text += "servers:\n";
        const std::string name = line.keys.front().second;
        text += "  - name: gate_" + name +
                "\n    listen: 127.0.0.1\n    tcp_port: " + std::to_string(port++) +
                "\n    relay:\n      - {line: " + name +
                ", units: [1..247], response_timeout: " + std::to_string(line.response_timeout_ms) + "ms}\n";
    }
    if (!blueprint.locals.empty()) text += "locals:\n";
    for (const auto& local : blueprint.locals) text += "  - " + flow(local) + "\n";
    return text;
}

}  // namespace takt::simtest
