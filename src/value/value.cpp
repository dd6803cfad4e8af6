#include "takt/value/value.hpp"

#include <cmath>

#include "takt/value/command.hpp"

namespace takt::value {

bool same(const Value& a, const Value& b) {
    const auto* x = std::get_if<double>(&a);
    const auto* y = std::get_if<double>(&b);
    if (!x || !y) return a == b;
    if (std::isnan(*x) || std::isnan(*y)) return std::isnan(*x) && std::isnan(*y);
    return *x == *y && std::signbit(*x) == std::signbit(*y);
}

std::string_view name(Quality quality) {
    switch (quality) {
        case Quality::never_read: return "never_read";
        case Quality::good: return "good";
        case Quality::uncertain: return "uncertain";
        case Quality::bad: return "bad";
    }
    return "unknown";
}

std::string_view name(Reason reason) {
    if (is_exception(reason)) return "exception";
    switch (reason) {
        case Reason::ok: return "ok";
        case Reason::timeout: return "timeout";
        case Reason::bad_checksum: return "bad_checksum";
        case Reason::unexpected_reply: return "unexpected_reply";
        case Reason::link_lost: return "link_lost";
        case Reason::switched_off: return "switched_off";
        case Reason::not_answering: return "not_answering";
        case Reason::differs: return "differs";
        case Reason::superseded: return "superseded";
        case Reason::stale: return "stale";
        case Reason::never_connected: return "never_connected";
        case Reason::ambiguous: return "ambiguous";
        case Reason::closed: return "closed";
    }
    return "unknown";
}

std::string_view name(CommandResult result) {
    switch (result) {
        case CommandResult::done: return "done";
        case CommandResult::refused: return "refused";
        case CommandResult::unknown: return "unknown";
        case CommandResult::expired: return "expired";
        case CommandResult::queue_full: return "queue_full";
    }
    return "unknown";
}

}  // namespace takt::value
