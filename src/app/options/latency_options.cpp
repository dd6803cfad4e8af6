// latency and selftest.
#include <sys/stat.h>
#include <sys/sysmacros.h>

#include <limits>
#include <optional>
#include <sstream>

#include "commands.hpp"
#include "offline/latency_command.hpp"
#include "options/add_commands.hpp"
#include "options/shared_options.hpp"

namespace takt::app {
namespace {

constexpr const char* kParts = "client,server,unit,function; none";

void add_grouping(Command& command, std::optional<capture::Grouping>& given) {
    command
        .text(
            "--by",
            [&given](const std::string& text) {
                auto& grouping = given.emplace(false, false, false, false);
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

/// "1000/s", "30/min"
std::optional<client::Rate> rate_of(const std::string& text) {
    constexpr std::size_t kMostDigits = 7;
    constexpr std::uint64_t kMost = 1'000'000;
    const auto slash = text.find('/');
    const auto digits = text.substr(0, slash);
    if (slash == std::string::npos || digits.empty() || digits.size() > kMostDigits ||
        digits.find_first_not_of("0123456789") != std::string::npos)
        return std::nullopt;
    const auto unit = text.substr(slash + 1);
    const std::uint64_t requests = std::stoull(digits);
    if (requests < 1 || requests > kMost || (unit != "s" && unit != "min")) return std::nullopt;
    return client::Rate{requests, unit == "s" ? Duration(std::chrono::seconds(1)) : std::chrono::minutes(1)};
}

void add_area(Command& command, std::optional<wire::Area>& target) {
    command.text(
        "AREA",
        [&target](const std::string& text) {
            const auto found = kAreas.find(text);
            if (found == kAreas.end()) reject_word("AREA", text, "coils, discrete, holding, input");
            target = found->second;
        },
        "help.latency.area");
}

void add_load(Command& command, LatencyLoad& load) {
    add_area(command, load.area);
    command.value("START", load.start, "help.latency.start").range(0, 65535);
    command.value("COUNT", load.quantity, "help.latency.count").range(1, 2000);
    command.value("--unit", load.unit, "help.latency.unit").range(0, 255);
    command.value("--connections", load.connections, "help.latency.connections")
        .range(1, static_cast<int>(client::kMostLoadConnections));
    command.value("--in-flight", load.in_flight, "help.latency.in_flight")
        .range(1, static_cast<int>(bus::kMaxInFlight));
    command
        .text(
            "--rate",
            [&load](const std::string& text) {
                load.rate = rate_of(text);
                if (!load.rate) reject({"app.option.rate", {{"option", "--rate"}, {"value", text}}});
            },
            "help.latency.rate")
        .value_name("N/s");
    add_wait(command, "--for", [&load](Duration time) { load.run_for = time; }, "help.latency.for");
    command.value("--requests", load.requests, "help.latency.requests").range(1, 2'000'000'000);
    command.flag("--same-content", load.same_content, "help.latency.same");
    add_realtime(command, load.realtime);
}

/// A serial port without its scheme. The devices with major number 1 (null, zero) have no line.
bool is_port(const std::string& path) {
    struct stat status{};
    return ::stat(path.c_str(), &status) == 0 && S_ISCHR(status.st_mode) && major(status.st_rdev) != 1;
}

/// A picture on standard output is the only output there.
void check_picture(const LatencyOptions& options) {
    if (options.svg != "-") return;
    for (const auto& [name, given] : {std::pair{"--json", options.json}, std::pair{"--csv", options.csv},
                                      std::pair{"--histogram", options.histogram > 0}})
        if (given) reject({"app.option.excludes", {{"option", name}, {"other", "--svg -"}}});
}

/// The options of the one kind of source are rejected with the other kind.
void check_source(const LatencyOptions& options) {
    if (options.source.empty() && options.interface.empty()) reject({"app.option.nothing_to_measure", {}});
    const auto& load = options.load;
    if (is_target(options.source) || is_port(options.source)) {
        check_target("SOURCE", options.source);
        for (const auto& [name, given] : {std::pair{"--port", !options.ports.empty()},
                                          std::pair{"--framing", options.framing.has_value()},
                                          std::pair{"--by", options.grouping.has_value()}})
            if (given) reject({"app.option.for_capture", {{"option", name}, {"target", options.source}}});
        return;
    }
    const auto& realtime = load.realtime;
    for (const auto& [name, given] :
         {std::pair{"AREA", load.area.has_value()}, std::pair{"--unit", load.unit.has_value()},
          std::pair{"--connections", load.connections.has_value()},
          std::pair{"--in-flight", load.in_flight.has_value()}, std::pair{"--rate", load.rate.has_value()},
          std::pair{"--for", load.run_for.has_value()}, std::pair{"--requests", load.requests.has_value()},
          std::pair{"--same-content", load.same_content}, std::pair{"--realtime", realtime.priority > 0},
          std::pair{"--cpu", realtime.cpu.has_value()},
          std::pair{"--spin", realtime.spin > Duration::zero()}})
        if (given) reject({"app.option.for_target", {{"option", name}}});
}

}  // namespace

void add_latency(CommandLine& line, const CommonOptions& common) {
    auto& options = line.keep<LatencyOptions>();
    auto latency =
        line.root().command("latency", "help.latency", [&] { return app::latency(common, options); });
    auto source = latency.value("SOURCE", options.source, "help.latency.source");
    latency.value("--interface", options.interface, "help.latency.interface")
        .value_name("IF")
        .excludes(source);
    add_load(latency, options.load);
    latency.check([&options] {
        check_source(options);
        check_picture(options);
    });
    add_ports(latency, options.ports);
    static const std::map<std::string, std::optional<wire::Framing>> kFramings{
        {"auto", std::nullopt},
        {"tcp", wire::Framing::tcp},
        {"rtu", wire::Framing::rtu},
        {"ascii", wire::Framing::ascii}};
    add_word(latency, "--framing", options.framing, kFramings, "help.latency.framing")
        .value_name("FRAMING")
        .default_text("auto");
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

void add_selftest(CommandLine& line, const CommonOptions& common) {
    auto& options = line.keep<SelftestOptions>();
    auto selftest =
        line.root().command("selftest", "help.selftest", [&] { return app::selftest(common, options); });
    add_wait(
        selftest, "--for", [&](Duration time) { options.time = time; }, "help.selftest.for")
        .default_text("5s");
    selftest.flag("--json", options.json, "help.json");
    add_realtime(selftest, options.realtime);
}

}  // namespace takt::app
