#include "takt/bus/outcome_status.hpp"

namespace takt::bus {

OutcomeStatus status_of(const Outcome& outcome) {
    using wire::ExceptionCode;
    switch (outcome.status) {
        case Status::ok: return {StatusCode::ok, true};
        case Status::exception: {
            const auto code = ExceptionCode{outcome.exception};
            const bool gateway = code == ExceptionCode::gateway_path_unavailable ||
                                 code == ExceptionCode::gateway_target_failed_to_respond;
            const bool busy = code == ExceptionCode::acknowledge || code == ExceptionCode::server_device_busy;
            return {exception_status(outcome.exception), !gateway, busy};
        }
        case Status::bad_checksum: return {StatusCode::bad_checksum};
        case Status::unexpected_reply: return {StatusCode::unexpected_reply};
        case Status::ambiguous: return {StatusCode::ambiguous, true};
        case Status::link_lost:
        case Status::closed:
        case Status::cancelled: return {StatusCode::link_lost};
        case Status::timeout:
        case Status::line_busy: break;
    }
    return {StatusCode::timeout};
}

bool attempts_left(StatusCode status, std::uint16_t attempts, std::uint16_t& failures) {
    constexpr int kAmbiguousOnes = 2;
    if (status == StatusCode::link_lost) return true;
    ++failures;
    return failures < attempts + (status == StatusCode::ambiguous ? kAmbiguousOnes : 0);
}

}  // namespace takt::bus
