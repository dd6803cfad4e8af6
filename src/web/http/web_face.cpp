#include "takt/web/web_face.hpp"

#include <algorithm>
#include <atomic>
#include <charconv>
#include <cstdint>
#include <iterator>
#include <utility>

#include "devices/command_api.hpp"
#include "devices/device_search.hpp"
#include "devices/search_api.hpp"
#include "http/openapi.hpp"
#include "live/event_log.hpp"
#include "live/live_hub.hpp"
#include "live/mark_writer.hpp"
#include "live/marks.hpp"
#include "live/state_api.hpp"
#include "live/traffic_hub.hpp"
#include "live/wall_time.hpp"
#include "takt/web/history_api.hpp"

namespace takt::web {
namespace {

ApiResponse capture_response(TrafficHub& traffic, const ApiRequest& request) {
    auto bytes = traffic.capture();
    if (!bytes) return host_error(request, bytes.error());
    if (bytes->empty()) return ApiResponse::error(503, "recording", request.texts("web.error.recording"));
    return {.content_type = "application/x-pcapng", .body = *std::move(bytes), .file_name = "takt.pcapng"};
}

/// @param ms  since 1970; stays without the parameter @returns false: it is no number
bool take_milliseconds(std::string_view text, std::int64_t& ms) {
    if (text.empty()) return true;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), ms);
    return error == std::errc() && end == text.data() + text.size() && ms >= 0;
}

ApiResponse events_response(const Marks& marks, const ApiRequest& request) {
    std::int64_t from = 0;
    std::int64_t to = INT64_MAX;
    for (const auto& [name, ms] : {std::pair<std::string_view, std::int64_t&>{"from", from}, {"to", to}})
        if (!take_milliseconds(request.parameter(name), ms))
            return ApiResponse::wrong_parameter(request, name, request.texts("web.error.milliseconds"));
    return ApiResponse::json(marks.json(request.texts.language(), from, to));
}

/// The registers of a variable as its last response had them.
file::Json registers_of(const WireRegisters& known, const host::Configuration& configuration,
                        const std::string& name, const WallTime& clock) {
    auto object = file::Json::object();
    object.set("variable", name);
    const auto slot = configuration.find(name);
    const auto* const variable = slot ? configuration.variable_of(*slot) : nullptr;
    const auto found =
        variable ? known.find(configuration.line_of(*slot)->name, configuration.device_of(*slot)->address,
                              variable->area, variable->start(), variable->items())
                 : std::nullopt;
    auto items = file::Json::array();
    if (found)
        for (const auto item : found->items) items.push_back(item);
    object.set("items", found ? std::move(items) : file::Json());
    object.set("bits", variable && wire::is_bit_area(variable->area));
    if (!found) return object;
    object.set("function", found->function);
    object.set("start", found->start);
    object.set("quantity", found->quantity);
    object.set("received_at", clock.ms(found->t));
    return object;
}

ApiResponse registers_response(TrafficHub& traffic, const HostAccess& host, const ApiRequest& request) {
    const auto [first, last] = request.query.equal_range("variable");
    const auto configuration = host.configuration();
    for (auto its = first; its != last; ++its)
        if (!configuration->find(its->second))
            return ApiResponse::error(404, "variable",
                                      request.texts("web.error.variable", {{"name", its->second}}));
    auto list = file::Json::array();
    const WallTime clock;
    traffic.registers([&](const WireRegisters& known) {
        for (auto its = first; its != last; ++its)
            list.push_back(registers_of(known, *configuration, its->second, clock));
    });
    auto object = file::Json::object();
    object.set("registers", std::move(list));
    return ApiResponse::json(object);
}

ApiResponse openapi_response() {
    return {.body = std::string(openapi_text())};
}

}  // namespace

struct WebFace::Impl {
    explicit Impl(WebFaceOptions options)
        : host(std::move(options.host)),
          info{.project = std::move(options.project),
               .version = std::move(options.version),
               .demo = options.demo,
               .allow_write = options.server.allow_write,
               .editable = options.editable,
               .history = options.history},
          marks_file(std::move(options.marks_file)),
          further(std::move(options.routes)),
          serving(std::move(options.server)) {}

    HostAccess host;
    ProgramInfo info;
    std::string marks_file;
    std::vector<ApiRoute> further;
    WebServerOptions serving;
    std::atomic<bool> stopping = false;
    std::atomic<WebServer*> target = nullptr;  // of the hubs
    Marks marks{WallTime().ms(host.started)};
    std::unique_ptr<MarkWriter> writer;
    std::unique_ptr<EventLog> log;
    std::unique_ptr<LiveHub> live;
    std::unique_ptr<TrafficHub> traffic;
    DeviceSearch search;
    std::unique_ptr<WebServer> server;

    Result<void> begin() {
        const auto poke = [this] {
            if (auto* const running = target.load()) running->poke();
        };
        log = std::make_unique<EventLog>(host, marks);
        live = std::make_unique<LiveHub>(host, poke);
        traffic = std::make_unique<TrafficHub>(host, poke);
        TAKT_TRY(server, WebServer::start(serving, routes(), streams()));
        target = server.get();
        if (marks_file.empty()) return {};
        const auto wanted = [this] { return has_history(host.configuration()->project()); };
        writer = std::make_unique<MarkWriter>(marks, MarkWriterOptions{marks_file, wanted, serving.log});
        return {};
    }

    std::vector<ApiRoute> routes() {
        auto all = state_routes(host, info);
        const auto append = [&all](std::vector<ApiRoute> more) {
            std::ranges::move(more, std::back_inserter(all));
        };
        append(command_routes(host, *log, stopping));
        append(search_routes(search, host));
        append(std::move(further));
        all.push_back({Method::get, "/events", false,
                       [this](const ApiRequest& request) { return events_response(marks, request); }});
        all.push_back({Method::get, "/traffic/capture", false,
                       [this](const ApiRequest& request) { return capture_response(*traffic, request); }});
        all.push_back({Method::get, "/registers", false, [this](const ApiRequest& request) {
                           return registers_response(*traffic, host, request);
                       }});
        all.push_back(
            {Method::get, "/openapi.json", false, [](const ApiRequest&) { return openapi_response(); }});
        return all;
    }

    std::vector<StreamRoute> streams() {
        return {
            {"/stream", [this](const ApiRequest& request) { return live->open(request.texts.language()); }},
            {"/traffic",
             [this](const ApiRequest& request) { return traffic->open(request.texts.language()); }}};
    }

    // The hubs poke the server, and the server's threads use the hubs: their threads end before anything is
    // destroyed.
    bool stop() {
        stopping = true;
        if (log) log->end();
        if (live) live->end();
        if (traffic) traffic->end();
        const bool ended = !server || server->stop();
        search.end();
        if (writer) writer->end();  // with the marks of the last commands
        return ended;
    }
};

WebFace::WebFace(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
WebFace::~WebFace() {
    static_cast<void>(impl_->stop());
}

Result<std::unique_ptr<WebFace>> WebFace::start(WebFaceOptions options) {
    std::unique_ptr<WebFace> face(new WebFace(std::make_unique<Impl>(std::move(options))));
    TAKT_CHECK(face->impl_->begin());
    return face;
}

bool WebFace::stop() {
    return impl_->stop();
}

std::string WebFace::url() const {
    return impl_->server->url();
}

}  // namespace takt::web
