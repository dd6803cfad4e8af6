#include "devices/search_api.hpp"

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "devices/line_bridge.hpp"
#include "devices/search_json.hpp"
#include "live/state_api.hpp"
#include "takt/bus/number_list.hpp"
#include "takt/file/json_members.hpp"
#include "takt/line/target.hpp"
#include "takt/model/target_url.hpp"
#include "takt/os/connections.hpp"

namespace takt::web {
namespace {

constexpr Duration kLeastTimeout = std::chrono::milliseconds(10);
constexpr Duration kLongestTimeout = std::chrono::seconds(10);
constexpr std::int64_t kMostProbeRequests = 4096;                 // for each area
constexpr Duration kSerialWait = std::chrono::milliseconds(200);  // for a unit of a polled line
constexpr Duration kTcpWait = std::chrono::milliseconds(500);
constexpr Duration kLongestScanWait = std::chrono::seconds(10);  // for a polled line to have time
constexpr Duration kLongestProbeWait = std::chrono::seconds(2);

ApiResponse unusable(const ApiRequest& request, const Error& error) {
    return ApiResponse::error(422, name(error.code), request.texts.describe(error));
}

Result<std::optional<Duration>> timeout_of(const file::Json& body) {
    const auto ms = whole_member(body, "timeout_ms");
    if (!ms) return std::nullopt;
    const auto wanted = std::chrono::milliseconds(std::clamp<std::int64_t>(*ms, 0, 3'600'000));
    if (wanted >= kLeastTimeout && wanted <= kLongestTimeout) return wanted;
    return fail(Code::out_of_range, "timeout_ms", *ms, kLeastTimeout / std::chrono::milliseconds(1),
                kLongestTimeout / std::chrono::milliseconds(1));
}

/// Device files that are serial ports by their name: others must not be opened to find out.
bool is_port_name(std::string_view path) {
    const bool named =
        path.starts_with("/dev/tty") || path.starts_with("/dev/serial/") || path.starts_with("/dev/pts/");
    return named && path.find("..") == std::string_view::npos;
}

/// The answer to targets that may not be opened; nothing: all may.
std::optional<ApiResponse> line_refusal(const ApiRequest& request, const model::Project& project,
                                        const model::Line& line) {
    if (line.transport == model::Transport::serial && !is_port_name(line.port))
        return ApiResponse::error(422, "port", request.texts("web.search.port", {{"port", line.port}}));
    if (const auto* const user = line_with_endpoint(project, line))
        return ApiResponse::error(
            409, "in_use",
            request.texts("web.search.in_use", {{"target", model::url_of(line)}, {"line", user->name}}));
    return std::nullopt;
}

Result<bus::SerialChoices> choices_of(const file::Json& body) {
    bus::SerialChoices choices;
    if (const auto bauds = string_member(body, "bauds"); !bauds.empty()) {
        TAKT_TRY(choices.bauds, bus::parse_numbers(bauds, 50, 4'000'000));
    }
    if (const auto parities = string_member(body, "parities"); !parities.empty()) {
        TAKT_TRY(choices.parities, bus::parse_parities(parities));
    }
    if (const auto stop_bits = string_member(body, "stop_bits"); !stop_bits.empty()) {
        TAKT_TRY(choices.stop_bits, bus::parse_numbers(stop_bits, 1, 2));
    }
    return choices;
}

Result<ScanOrder> scan_order(const file::Json& body) {
    bus::ScanRequest request{.identify = flag_member(body, "identify", true),
                             .thorough = flag_member(body, "thorough", false)};
    TAKT_TRY(request.wait, timeout_of(body));
    if (const auto units = string_member(body, "units"); !units.empty()) {
        TAKT_TRY(request.units, bus::parse_numbers(units, 0, 255));
    }
    TAKT_TRY(const auto choices, choices_of(body));
    TAKT_TRY(auto targets, client::scan_targets(strings_member(body, "targets"), choices));
    ScanOrder order;
    for (auto& target : targets) {
        TAKT_TRY(auto config, bus::scan_config(request, target));
        order.targets.push_back({std::move(target), std::move(config)});
    }
    return order;
}

std::size_t visits_of(const ScanOrder& order) {
    std::size_t visits = 0;
    for (const auto& [target, config] : order.targets) visits += target.settings.size() * config.units.size();
    return visits;
}

ApiResponse state_response(const DeviceSearch& search, const HostAccess& host, const ApiRequest& request) {
    return ApiResponse::json(search_json(request.texts, search.state(), *host.configuration()));
}

ApiResponse started(const Result<std::uint64_t>& id, const DeviceSearch& search, const HostAccess& host,
                    const ApiRequest& request) {
    if (!id) return ApiResponse::error(409, "busy", request.texts("web.search.busy"));
    return state_response(search, host, request);
}

/// What a scan can begin with on this computer, as targets.
ApiResponse targets_response(const ApiRequest&) {
    auto targets = file::Json::array();
    for (const auto& port : os::serial_ports()) targets.push_back("rtu://" + port);
    for (const auto& hosts : os::host_ranges()) targets.push_back("tcp://" + hosts);
    auto object = file::Json::object();
    object.set("targets", std::move(targets));
    return ApiResponse::json(object);
}

/// A line of the project that a search goes through.
struct PolledLine {
    model::Line line;  ///< bridged_line()
    client::OpenLine open;
};

/// @returns the session's errors, not_found (the line)
Result<PolledLine> polled_line(const HostAccess& host, const std::string& name,
                               std::optional<Duration> timeout, bool spare, bool scan) {
    TAKT_TRY(auto opened, host.open_session({.events = false}));
    const std::shared_ptr<host::Session> session = std::move(opened);
    const auto& lines = session->configuration()->project().lines;
    const auto found = std::ranges::find(lines, name, &model::Line::name);
    if (found == lines.end()) return fail(Code::not_found, name);
    const auto index = static_cast<std::size_t>(found - lines.begin());
    const auto wait = timeout.value_or(found->is_serial() ? kSerialWait : kTcpWait);
    return PolledLine{bridged_line(*found),
                      bridge_to(session, index,
                                {.wait = wait,
                                 .spare = spare,
                                 .longest_wait = scan ? kLongestScanWait : kLongestProbeWait,
                                 .report_absent = scan})};
}

/// The name behind "line:"; nothing: another target.
std::optional<std::string> line_name(std::string_view target) {
    if (!target.starts_with(kLineTarget)) return std::nullopt;
    return std::string(target.substr(kLineTarget.size()));
}

ApiResponse no_line(const ApiRequest& request, const Error& error, const std::string& name) {
    if (error.code != Code::not_found) return host_error(request, error);
    return ApiResponse::error(404, "line", request.texts("web.search.line", {{"line", name}}));
}

/// The units of a serial line, asked in any order; the bridge answers for those that do not.
Result<ScanOrder> line_scan_order(const file::Json& body, PolledLine polled, const std::string& name) {
    bus::ScanRequest request{.wait = kLongestScanWait + kLongestTimeout,
                             .identify = flag_member(body, "identify", true),
                             .thorough = flag_member(body, "thorough", false)};
    const auto units = string_member(body, "units");
    TAKT_TRY(request.units, bus::parse_numbers(units.empty() ? "1-247" : units, 1, 247));
    bus::ScanTarget target{.settings = {std::move(polled.line)}};
    TAKT_TRY(auto config, bus::scan_config(request, target));
    config.adaptive = false;
    config.retry_wait = config.wait;
    ScanOrder order{.open = std::move(polled.open), .project_line = name};
    order.targets.push_back({std::move(target), std::move(config)});
    return order;
}

ApiResponse line_scan_response(DeviceSearch& search, const HostAccess& host, const ApiRequest& request,
                               const file::Json& body, const std::string& name) {
    const auto timeout = timeout_of(body);
    if (!timeout) return unusable(request, timeout.error());
    auto polled = polled_line(host, name, *timeout, flag_member(body, "spare", false), true);
    if (!polled) return no_line(request, polled.error(), name);
    auto order = line_scan_order(body, *std::move(polled), name);
    if (!order) return unusable(request, order.error());
    return started(search.start(*std::move(order)), search, host, request);
}

ApiResponse scan_response(DeviceSearch& search, const HostAccess& host, const ApiRequest& request) {
    const auto body = file::Json::parse(request.body, kMostCommandBody);
    if (!body || strings_member(*body, "targets").empty()) return malformed_body(request);
    if (const auto name = line_name(strings_member(*body, "targets").front()))
        return line_scan_response(search, host, request, *body, *name);
    auto order = scan_order(*body);
    if (!order) return unusable(request, order.error());
    if (const auto visits = visits_of(*order); visits > kMostVisits)
        return ApiResponse::error(
            422, "too_large",
            request.texts("web.search.too_large",
                          {{"count", std::to_string(visits)}, {"limit", std::to_string(kMostVisits)}}));
    const auto configuration = host.configuration();
    for (const auto& [target, config] : order->targets)
        if (auto answer = line_refusal(request, configuration->project(), target.settings.front()))
            return *std::move(answer);
    return started(search.start(*std::move(order)), search, host, request);
}

/// A number within its range. @returns out_of_range (the key)
Result<std::int64_t> number_within(const file::Json& body, std::string_view key, std::int64_t otherwise,
                                   std::int64_t least, std::int64_t greatest) {
    const auto number = whole_member(body, key).value_or(otherwise);
    if (number < least || number > greatest) return fail(Code::out_of_range, key, number, least, greatest);
    return number;
}

Result<bus::DeviceProbeConfig> probe_config(const file::Json& body) {
    bus::DeviceProbeConfig config;
    constexpr std::int64_t kLastItem = 65535;
    TAKT_TRY(const auto first, number_within(body, "from", 0, 0, kLastItem));
    TAKT_TRY(const auto last, number_within(body, "to", kLastItem, first, kLastItem));
    TAKT_TRY(const auto most,
             number_within(body, "max_requests", kMostProbeRequests, 16, kMostProbeRequests));
    config.first = static_cast<std::uint16_t>(first);
    config.last = static_cast<std::uint16_t>(last);
    config.max_requests = static_cast<std::size_t>(most);
    return config;
}

ApiResponse search_probe_response(DeviceSearch& search, const HostAccess& host, const ApiRequest& request) {
    const auto body = file::Json::parse(request.body, kMostCommandBody);
    const auto unit = body ? whole_member(*body, "unit") : std::nullopt;
    if (!unit) return malformed_body(request);
    if (*unit < 0 || *unit > 255)
        return unusable(request, fail(Code::out_of_range, "unit", *unit, 0, 255).error());
    const auto timeout = timeout_of(*body);
    if (!timeout) return unusable(request, timeout.error());
    const auto config = probe_config(*body);
    if (!config) return unusable(request, config.error());
    if (const auto name = line_name(string_member(*body, "target"))) {
        auto polled = polled_line(host, *name, *timeout, flag_member(*body, "spare", false), false);
        if (!polled) return no_line(request, polled.error(), *name);
        return started(search.start(ProbeOrder{.line = std::move(polled->line),
                                               .unit = UnitId{static_cast<std::uint8_t>(*unit)},
                                               .config = *config,
                                               .timeout = kLongestProbeWait + timeout->value_or(kTcpWait),
                                               .open = std::move(polled->open),
                                               .project_line = *name,
                                               .name = *name}),
                       search, host, request);
    }
    const auto target = line::parse_target(string_member(*body, "target"));
    if (!target) return unusable(request, target.error());
    ProbeOrder order{.line = target->as_line(), .unit = UnitId{static_cast<std::uint8_t>(*unit)}};
    order.config = *config;
    order.timeout = timeout->value_or(order.timeout);
    if (auto answer = line_refusal(request, host.configuration()->project(), order.line))
        return *std::move(answer);
    return started(search.start(std::move(order)), search, host, request);
}

}  // namespace

std::vector<ApiRoute> search_routes(DeviceSearch& search, const HostAccess& host) {
    using enum Method;
    return {
        {get, "/search", false,
         [&](const ApiRequest& request) { return state_response(search, host, request); }},
        {get, "/search/targets", false, targets_response},
        {post, "/search/scan", true,
         [&](const ApiRequest& request) { return scan_response(search, host, request); }},
        {post, "/search/probe", true,
         [&](const ApiRequest& request) { return search_probe_response(search, host, request); }},
        {post, "/search/cancel", true,
         [&](const ApiRequest& request) {
             search.cancel();
             return state_response(search, host, request);
         }},
    };
}

}  // namespace takt::web
