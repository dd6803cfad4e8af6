// latency.
#include <limits>
#include <sstream>

#include "commands/latency_command.hpp"
#include "options/add_commands.hpp"
#include "options/shared_options.hpp"

namespace takt::app {
namespace {

constexpr const char* kParts = "client,server,unit,function; none";

void add_grouping(Command& command, capture::Grouping& grouping) {
    command
        .text(
            "--by",
            [&grouping](const std::string& text) {
                grouping = {false, false, false, false};
                if (text == "none") return;
                if (text.empty()) reject_word("--by", text, kParts);
                std::istringstream parts(text);
                for (std::string part; std::getline(parts, part, ',');) {
                    bool* const flag = part == "client"     ? &grouping.client
                                       : part == "server"   ? &grouping.server
                                       : part == "unit"     ? &grouping.unit
                                       : part == "function" ? &grouping.function
                                                            : nullptr;
                    if (flag == nullptr) reject_word("--by", text, kParts);
                    *flag = true;
                }
            },
            "help.latency.by")
        .value_name("PARTS")
        .default_text("client,server,unit,function");
}

void add_ports(Command& command, std::vector<std::uint16_t>& ports) {
    command
        .texts(
            "--port",
            [&ports](const std::vector<std::string>& texts) {
                for (const auto& text : texts) {
                    unsigned long number = 0;
                    const bool digits = !text.empty() && text.size() <= 5 &&
                                        text.find_first_not_of("0123456789") == std::string::npos;
                    if (digits) number = std::stoul(text);
                    if (number < 1 || number > std::numeric_limits<std::uint16_t>::max())
                        reject(
                            {"app.option.range",
                             {{"option", "--port"}, {"value", text}, {"least", "1"}, {"greatest", "65535"}}});
                    ports.push_back(static_cast<std::uint16_t>(number));
                }
            },
            "help.latency.port")
        .value_name("N")
        .repeatable()
        .default_text("502");
}

}  // namespace

void add_latency(CommandLine& line, const CommonOptions& common) {
    auto& options = line.keep<LatencyOptions>();
    auto latency =
        line.root().command("latency", "help.latency", [&] { return app::latency(common, options); });
    auto file = latency.value("CAPTURE", options.capture, "help.latency.capture");
    latency.value("--interface", options.interface, "help.latency.interface").value_name("IF").excludes(file);
    latency.check([&options] {
        if (options.capture.empty() && options.interface.empty())
            reject({"app.option.nothing_to_measure", {}});
    });
    add_ports(latency, options.ports);
    static const std::map<std::string, wire::Framing> kFramings{
        {"tcp", wire::Framing::tcp}, {"rtu", wire::Framing::rtu}, {"ascii", wire::Framing::ascii}};
    add_word(latency, "--framing", options.framing, kFramings, "help.latency.framing")
        .value_name("FRAMING")
        .default_text("tcp");
    add_wait(
        latency, "--timeout", [&options](Duration time) { options.timeout = time; }, "help.latency.timeout")
        .default_text("1s");
    add_duration(
        latency, "--limit", [&options](Duration time) { options.limit = time; }, "help.latency.limit");
    add_grouping(latency, options.grouping);
    auto json = latency.flag("--json", options.json, "help.json");
    auto csv = latency.flag("--csv", options.csv, "help.latency.csv").excludes(json);
    latency.value("--histogram", options.histogram, "help.latency.histogram")
        .range(1, 1'000'000)
        .excludes(json)
        .excludes(csv);
    latency.value("--svg", options.svg, "help.latency.svg").value_name("FILE.svg");
}

}  // namespace takt::app
