#include "project_text.hpp"

#include <array>
#include <string_view>

#include "field.hpp"

namespace takt::gatewaysim {
namespace {

class ProjectDrawer {
public:
    explicit ProjectDrawer(sim::Random random) : random_(random) {}

    DrawnProject draw() {
        made_.heavy = chance(20);
        made_.text = "takt: 1\nlines:\n";
        const int lines = chance(25) ? 2 : 1;
        for (int i = 0; i < lines; ++i) add_line(i);
        made_.text +=
            "locals:\n  - {name: Mode, type: uint32}\n  - {name: Go, type: bool}\n"
            "  - {name: Secret, type: uint32}\n" +
            locals_;
        add_output();
        return std::move(made_);
    }

private:
    bool chance(std::uint32_t percent) { return random_.below(100) < percent; }
    std::uint32_t between(std::uint32_t least, std::uint32_t most) {
        return least + random_.below(most - least + 1);
    }
    void add(std::string_view indent, std::string_view key, const std::string& value) {
        made_.text += std::string(indent) + std::string(key) + ": " + value + "\n";
    }

    void add_line(int index) {
        tcp_ = chance(40);
        made_.text += "  - name: L" + std::to_string(index) + "\n    transport: simulated\n";
        add("    ", "framing", tcp_ ? "tcp" : "rtu");
        const bool fast = chance(80) || made_.heavy;
        if (!tcp_) add("    ", "baud", fast ? "115200" : "19200");
        made_.text += "    devices:\n";
        const auto devices = between(1, made_.heavy ? 2 : 3);
        for (std::uint32_t i = 0; i < devices; ++i) add_device("D" + std::to_string(++devices_), i + 1);
    }

    void add_device(const std::string& name, std::uint32_t address) {
        made_.text += "      - name: " + name + "\n";
        add("        ", "address", std::to_string(address));
        constexpr std::array<std::string_view, 4> kPeriods{"150ms", "300ms", "700ms", "2s"};
        add("        ", "poll_period",
            std::string(kPeriods[random_.below(made_.heavy ? 2 : kPeriods.size())]));
        add("        ", tcp_ ? "round_trip" : "turnaround", std::to_string(between(1, 8)) + "ms");
        // Behind a device that does not answer, commands wait until they expire.
        add("        ", "response_timeout", chance(20) ? std::to_string(between(1, 4)) + "s" : "60ms");
        add("        ", "backoff", "1500ms");
        if (chance(30)) {
            add("        ", "poll_enable", name + "on");
            locals_ += "  - {name: " + name + "on, type: bool, default: true}\n";
        }
        made_.text += "        variables:\n";
        const auto variables = made_.heavy ? between(5, 8) : between(2, 5);
        for (std::uint32_t i = 0; i < variables; ++i) add_measured(name, i);
        std::string on_change = chance(80) ? ", write_on_change: true" : "";
        if (!on_change.empty() && chance(30))
            on_change += ", min_interval: " + std::to_string(between(1, 20)) + "s";
        add_written(name + "set", 0, on_change);
        add_written(name + "order", 2, "");
        if (chance(50)) add_written(name + "hidden", 4, "");
    }

    void add_measured(const std::string& device, std::uint32_t index) {
        constexpr std::array kUses{RegisterUse::fast, RegisterUse::slow, RegisterUse::constant,
                                   RegisterUse::noise};
        const bool text = made_.heavy ? index < 6 : chance(10);
        const auto use = text ? RegisterUse::text : kUses[random_.below(kUses.size())];
        const auto start =
            static_cast<std::uint32_t>(use) * kRegistersOfAUse + (text ? 64 * index : 4 * index);
        std::string type = "string, length: " + std::to_string(made_.heavy ? between(60, 120) : 4);
        constexpr std::array<std::string_view, 4> kTypes{"uint16", "int16", "uint32", "float"};
        if (!text) type = kTypes[random_.below(use == RegisterUse::fast ? kTypes.size() : 2)];
        std::string more;
        if (!text && chance(20)) more = ", scale: 0.1, unit: kW";
        const bool first = device == "D1" && index == 0;  // a selection by a tag has something to select
        if (first || chance(30))
            more += std::string(", tags: [") + (first || chance(50) ? "energy" : "alarm") + "]";
        add_variable(device + "v" + std::to_string(index), type, start, more);
    }

    void add_written(const std::string& name, std::uint32_t offset, const std::string& more) {
        const auto start = static_cast<std::uint32_t>(RegisterUse::written) * kRegistersOfAUse + offset;
        add_variable(name, "uint32", start, ", write: 0x10" + more);
    }

    void add_variable(const std::string& name, const std::string& type, std::uint32_t start,
                      const std::string& more) {
        made_.text += "          - {name: " + name + ", type: " + type +
                      ", register: " + std::to_string(start) + ", read: 0x03" + more + "}\n";
    }

    void add_output() {
        made_.brokers = chance(40) ? 2 : 1;
        made_.text += "outputs:\n  - name: cloud\n    transport: mqtt\n    client_id: takt\n";
        add("    ", "brokers", made_.brokers == 2 ? "[mqtt://one, mqtt://two]" : "[mqtt://one]");
        constexpr std::array<std::string_view, 4> kWindows{"1", "4", "16", "64"};
        add("    ", "in_flight", std::string(kWindows[random_.below(kWindows.size())]));
        add("    ", "version", chance(70) ? "auto" : chance(50) ? "5" : "3.1.1");
        if (chance(90)) add("    ", "commands", R"(["*set", "*order", "D*on", Mode, Go])");
        add("    ", "command_expiry", std::to_string(between(2, 10)) + "s");
        add("    ", "variables", R"(["*"])");
        const bool several = chance(40);
        if (several) made_.text += "    select:\n";
        if (several) add_selection("tags: [energy], ", true);
        if (several) add_selection(R"(variables: ["*v1", Mode], )", true);
        if (several) add_selection("", true);
        if (!several) add_selection("", false);
        // The last draw: a project without it has the other keys of before.
        if (chance(40)) add("    ", "backlog", "array");
    }

    void add_selection(const std::string& what, bool entry) {
        std::string keys = what + "bad_quality: " + (chance(80) ? "publish" : "skip");
        const auto more = [&](const std::string& key) { keys += ", " + key; };
        if (chance(30))
            more("period: " + std::to_string(between(1, 5)) +
                 "s, on_change: " + (chance(50) ? "true" : "false"));
        if (chance(40)) more("heartbeat: " + std::to_string(between(2, 20)) + "s");
        if (chance(30)) more("dead_band: 3");
        const auto scope = random_.below(4);
        if (scope == 2) more("message: device");
        if (scope == 3) more("message: request");
        if (chance(20)) more(std::string("retain: ") + (chance(50) ? "true" : "false"));
        if (entry) {
            made_.text += "      - {" + keys + "}\n";
            return;
        }
        for (std::size_t begin = 0; begin < keys.size();) {
            const auto end = std::min(keys.find(", ", begin), keys.size());
            made_.text += "    " + keys.substr(begin, end - begin) + "\n";
            begin = end + 2;
        }
    }

    sim::Random random_;
    DrawnProject made_;
    std::string locals_;
    int devices_ = 0;
    bool tcp_ = false;
};

}  // namespace

DrawnProject draw_project(sim::Random random) {
    return ProjectDrawer(random).draw();
}

}  // namespace takt::gatewaysim
