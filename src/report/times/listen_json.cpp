// The objects of takt listen --json (docs/commands/listen.md).
#include <string_view>

#include "takt/model/fields.hpp"
#include "takt/report/drawing/formatting.hpp"
#include "takt/report/times/listen_report.hpp"
#include "takt/wire/frame_words.hpp"

namespace takt::report {
namespace {

using capture::Outcome;
using file::Json;

std::string_view outcome_word(Outcome outcome) {
    switch (outcome) {
        case Outcome::answered: return "answered";
        case Outcome::exception: return "exception";
        case Outcome::unanswered: return "unanswered";
        case Outcome::broadcast: return "broadcast";
        case Outcome::open: break;
    }
    return "open";
}

Json event(std::string_view kind, const std::string& time) {
    auto object = Json::object();
    object.set("event", kind);
    object.set("time", time);
    return object;
}

void set_poll(Json& object, const capture::PollKey& key) {
    object.set("function", key.function);
    object.set("start", key.quantity > 0 ? Json(key.start) : Json());
    object.set("quantity", key.quantity > 0 ? Json(key.quantity) : Json());
}

void set_period(Json& object, std::string_view key, const capture::Poll::Period& period) {
    const bool known = period.median > Duration::zero();
    const std::string name(key);
    object.set(name + "_ms", known ? Json(milliseconds(period.median)) : Json());
    object.set(name + "_min_ms", known ? Json(milliseconds(period.least)) : Json());
    object.set(name + "_max_ms", known ? Json(milliseconds(period.greatest)) : Json());
}

Json polls_json(const capture::HeardDevice& device) {
    auto polls = Json::array();
    for (const auto& poll : device.polls) {
        auto object = Json::object();
        set_poll(object, poll.key);
        set_period(object, "period", poll.period());
        object.set("requests", poll.requests);
        object.set("normal", poll.normal);
        object.set("exceptions", poll.exceptions);
        object.set("unanswered", poll.unanswered);
        object.set("repeats", poll.repeats);
        polls.push_back(std::move(object));
    }
    return polls;
}

Json heard_device_json(const ListenRun& run, std::uint8_t unit, const capture::HeardDevice& device) {
    const auto* const known = run.names.device(unit);
    auto object = Json::object();
    object.set("unit", unit);
    object.set("device", known != nullptr ? Json(known->name) : Json());
    object.set("requests", device.requests);
    object.set("answered", device.answered);
    auto exceptions = Json::object();
    for (const auto& [code, count] : device.exceptions) exceptions.set(std::to_string(code), count);
    object.set("exceptions", std::move(exceptions));
    object.set("unanswered", device.unanswered);
    object.set("strays", device.strays);
    object.set("silent", device.silent());
    const auto& times = device.times;
    const auto set_time = [&](std::string_view key, Duration time) {
        object.set(key, times.count() > 0 ? Json(milliseconds(time)) : Json());
    };
    set_time("min_ms", times.min());
    set_time("mean_ms", times.mean());
    set_time("p50_ms", times.percentile(50));
    set_time("p99_ms", times.percentile(99));
    set_time("max_ms", times.max());
    object.set("polls", polls_json(device));
    object.set("other_requests", device.other_polls);
    return object;
}

Json masters_json(const capture::LineStatistics& statistics) {
    auto masters = Json::array();
    for (const auto& master : statistics.masters()) {
        auto object = Json::object();
        set_period(object, "cycle", master.cycle);
        object.set("requests", master.requests);
        auto polls = Json::array();
        for (const auto& member : master.polls) {
            auto poll = Json::object();
            poll.set("unit", member.unit);
            set_poll(poll, statistics.devices().at(member.unit).polls[member.poll].key);
            polls.push_back(std::move(poll));
        }
        object.set("polls", std::move(polls));
        masters.push_back(std::move(object));
    }
    return masters;
}

}  // namespace

Json exchange_json(const HeardNames& names, const std::string& time, const capture::Exchange& exchange) {
    const auto& request = exchange.request;
    const bool refused = exchange.outcome == Outcome::exception;
    auto object = event("exchange", time);
    object.set("unit", request.unit);
    const auto* const device = names.device(request.unit);
    object.set("device", device != nullptr ? Json(device->name) : Json());
    set_poll(object, capture::poll_key(request.pdu.span()));
    object.set("outcome", outcome_word(exchange.outcome));
    object.set("exception", refused ? Json(exchange.response[1]) : Json());
    object.set("response_ms",
               exchange.response.empty() ? Json() : Json(milliseconds(exchange.response_time)));
    object.set("overlaps", request.overlaps);
    object.set("repeats", request.repeats);
    object.set("request", wire::hex(request.pdu.span()));
    object.set("response", exchange.response.empty() ? Json() : Json(wire::hex(exchange.response)));
    auto values = Json::object();
    for (const auto& value : names.values(exchange)) values.set(value.variable->name, value.text);
    object.set("values", std::move(values));
    return object;
}

Json stray_json(const std::string& time, const capture::LineFrame& frame) {
    auto object = event("stray", time);
    object.set("unit", frame.unit);
    object.set("response", wire::hex(frame.pdu));
    return object;
}

Json damaged_json(const std::string& time, const capture::DamagedBytes& damaged) {
    auto object = event("damaged", time);
    object.set("bytes", wire::hex(damaged.bytes));
    return object;
}

Json listen_json(const ListenRun& run) {
    const auto& counts = run.statistics.counts();
    const auto& format = run.connection.format;
    const auto setting = [&](const Json& value) { return run.has_settings ? value : Json(); };
    auto object = Json::object();
    object.set("event", "summary");
    object.set("port", run.port);
    if (!run.line.empty()) object.set("line", run.line);
    object.set("framing", std::string(wire::name(run.connection.framing)));
    object.set("baud", setting(format.baud));
    object.set("parity", setting(model::kParities[static_cast<std::size_t>(format.parity)]));
    object.set("data_bits", setting(format.data_bits));
    object.set("stop_bits", setting(format.stop_bits));
    object.set("duration_ms", milliseconds(counts.last - counts.first));
    object.set("busy_ms", setting(milliseconds(counts.busy)));
    object.set("requests", counts.requests);
    object.set("answered", counts.responses);
    object.set("unanswered", counts.unanswered);
    object.set("broadcasts", counts.broadcasts);
    object.set("open", counts.open);
    object.set("damaged", counts.damaged);
    object.set("damaged_bytes", counts.damaged_bytes);
    object.set("strays", counts.strays);
    object.set("overlaps", counts.overlaps);
    object.set("faulty_characters", run.faulty_characters);
    auto devices = Json::array();
    for (const auto& [unit, device] : run.statistics.devices())
        devices.push_back(heard_device_json(run, unit, device));
    object.set("devices", std::move(devices));
    object.set("masters", masters_json(run.statistics));
    return object;
}

}  // namespace takt::report
