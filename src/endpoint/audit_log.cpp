// A record is a JSON object on a line of its own: time, event (write, refused, left_out), peer, unit,
// function, the items with their old and new values, the request in hexadecimal, and why it was refused
// (docs/servers.md).
#include "takt/endpoint/audit_log.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "takt/base/assert.hpp"
#include "takt/base/iso_time.hpp"
#include "takt/file/json.hpp"
#include "takt/os/rotating_file.hpp"

namespace takt::endpoint {
namespace {

using file::Json;

constexpr std::uint32_t kFewPerSecond = 16;

Json numbers(const wire::Pdu& values, const AuditRecord::Items& items) {
    Json::Array list;
    for (std::size_t i = 0; i < items.count; ++i) {
        const unsigned byte = values[wire::is_bit_area(items.area) ? i / 8 : 2 * i];
        list.emplace_back(wire::is_bit_area(items.area) ? byte >> (i % 8) & 1U
                                                        : byte << 8 | values[2 * i + 1]);
    }
    return Json(std::move(list));
}

Json event(std::string_view name, std::chrono::system_clock::time_point time) {
    auto object = Json::object();
    object.set("time", utc_time_text(nanoseconds_of(time)));
    object.set("event", name);
    return object;
}

std::string left_out_line(std::uint64_t count) {
    auto object = event("left_out", std::chrono::system_clock::now());
    object.set("count", count);
    return object.dump() + '\n';
}

/// So many a second, after twice as many at once.
TokenBucket bucket(std::uint32_t rate) {
    const auto made = TokenBucket::create(2 * rate, Duration(std::chrono::seconds(1)) / rate);
    TAKT_ASSERT(made);
    return *made;
}

}  // namespace

std::string_view name(AuditRecord::Outcome outcome) {
    switch (outcome) {
        case AuditRecord::Outcome::none: break;
        case AuditRecord::Outcome::done: return "done";
        case AuditRecord::Outcome::sent: return "sent";
        case AuditRecord::Outcome::refused: return "refused";
        case AuditRecord::Outcome::unknown: return "unknown";
        case AuditRecord::Outcome::not_sent: return "not_sent";
    }
    return {};
}

std::string audit_line(const AuditRecord& record) {
    const bool refused = record.event == AuditRecord::Event::refused;
    auto object = event(refused ? "refused" : "write", record.time);
    object.set("peer", record.peer.view());
    if (!record.role.empty()) object.set("role", record.role.view());
    object.set("unit", record.unit);
    object.set("function", record.function);
    if (record.broadcast) object.set("broadcast", true);
    if (record.own_unit) object.set("own_unit", *record.own_unit);
    if (record.relayed_to) object.set("relayed_to", *record.relayed_to);
    if (const auto& items = record.items) {
        object.set("area", wire::name(items->area));
        object.set("start", items->start);
        object.set("count", items->count);
        if (!record.new_values.empty()) {
            object.set("old", numbers(record.old_values, *items));
            object.set("new", numbers(record.new_values, *items));
        }
    }
    if (!record.request.empty())
        object.set("request", fmt::format("{:02x}", fmt::join(record.request.span(), "")));
    if (refused) {
        object.set("why", record.why);
        object.set("exception", record.exception);
    }
    if (record.outcome != AuditRecord::Outcome::none) object.set("outcome", name(record.outcome));
    return object.dump() + '\n';
}

AuditLog::AuditLog(std::unique_ptr<os::Sink> file, const Options& options)
    : options_(options),
      writer_(std::move(file),
              {.limit = options.queue * sizeof(AuditRecord),
               .gap_line = left_out_line,
               .gap_interval = std::chrono::seconds(1)},
              [](const AuditRecord& record, std::string& text) { text += audit_line(record); }) {}

Result<std::unique_ptr<AuditLog>> AuditLog::open(const std::string& path, const Options& options) {
    TAKT_TRY(auto file, os::RotatingFile::open(
                            path, {.file_bytes = options.file_bytes, .old_files = options.old_files}));
    return std::unique_ptr<AuditLog>(new AuditLog(std::move(file), options));
}

void AuditLog::put(Instant t, const AuditRecord& record) {
    Budget& budget = budget_of(t, record.peer.view());
    auto& limit = record.event == AuditRecord::Event::write ? budget.writes : budget.refusals;
    const bool few = budget.few.admit(t);
    if (limit.admit(t) && (few || !writer_.full(options_.queue / 4 * sizeof(AuditRecord))))
        writer_.put(record);
    else
        writer_.drop();
}

// The peer's own budget; else a new one, which replaces that of the peer that was silent longest.
AuditLog::Budget& AuditLog::budget_of(Instant t, std::string_view peer) {
    const auto address = parse_peer(peer);
    const IpAddress network = rate_owner(address.value_or(IpAddress{}));
    const std::string_view port = address ? std::string_view() : peer;
    auto found = std::ranges::find_if(budgets_, [&](const Budget& budget) {
        return budget.network == network && budget.port.view() == port;
    });
    if (found == budgets_.end()) {
        const Budget fresh{network,
                           port,
                           t,
                           bucket(options_.writes_per_second),
                           bucket(options_.refusals_per_second),
                           bucket(kFewPerSecond)};
        if (budgets_.size() < options_.peers)
            found = budgets_.insert(found, fresh);
        else
            *(found = std::ranges::min_element(budgets_, {}, &Budget::seen)) = fresh;
    }
    found->seen = t;
    return *found;
}

std::uint64_t AuditLog::finish() {
    writer_.finish();
    return writer_.failures();
}

}  // namespace takt::endpoint
