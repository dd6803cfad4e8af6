#include "takt/bus/transaction.hpp"

#include <algorithm>

#include "takt/wire/silence.hpp"

namespace takt::bus {

Duration LineConfig::characters_time(std::size_t characters) const {
    return is_serial() ? wire::transmission_time(format, characters) : Duration::zero();
}

Duration LineConfig::silence_before_request() const {
    return std::max(wire::frame_silence(framing, format), frame_gap);
}

std::string_view name(Status status) {
    switch (status) {
        case Status::ok: return "ok";
        case Status::exception: return "exception";
        case Status::timeout: return "timeout";
        case Status::bad_checksum: return "bad_checksum";
        case Status::unexpected_reply: return "unexpected_reply";
        case Status::ambiguous: return "ambiguous";
        case Status::link_lost: return "link_lost";
        case Status::closed: return "closed";
        case Status::line_busy: return "line_busy";
        case Status::cancelled: return "cancelled";
    }
    return "unknown";
}

}  // namespace takt::bus
