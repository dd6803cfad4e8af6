// Exchanges on a line: a request and its response, or the lack of one.
#pragma once

#include <cstdint>
#include <span>

#include "takt/base/engine.hpp"
#include "takt/base/time.hpp"
#include "takt/capture/frame_finder.hpp"
#include "takt/wire/pdu.hpp"

namespace takt::capture {

/// A request as it was seen.
struct SeenRequest {
    Instant begin;
    Instant end;
    std::uint8_t unit = 0;
    wire::Pdu pdu;
    bool overlaps = false;  ///< sent while the response to another one was due
    bool repeats = false;   ///< the request before it, with the same bytes, got no response
};

enum class Outcome : std::uint8_t {
    answered,
    exception,
    unanswered,
    broadcast,
    open,  ///< the end came before the response
};

struct Exchange {
    const SeenRequest& request;
    Outcome outcome = Outcome::answered;
    Bytes response;            ///< PDU; empty without a response
    Duration response_time{};  ///< from the end of the request to the begin of the response
};

/// References are valid during the call.
class ListenObserver {
public:
    virtual void on_exchange(const Exchange& exchange) = 0;
    /// A response without a request.
    virtual void on_stray(const LineFrame& frame) = 0;
    virtual void on_damaged(const DamagedBytes& damaged) = 0;

protected:
    ~ListenObserver() = default;
};

}  // namespace takt::capture
