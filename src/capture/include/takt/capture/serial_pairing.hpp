// Which frames of a serial line are requests, and which response belongs to which request.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "takt/base/inplace_vector.hpp"
#include "takt/base/time.hpp"
#include "takt/capture/serial_packet.hpp"
#include "takt/capture/usual_times.hpp"
#include "takt/wire/prepared_request.hpp"

namespace takt::capture {

/// Frames of a serial line have no direction. Three facts decide:
///
/// - Order: a frame that answers a waiting request is its response.
/// - Shape: a frame that can only be a response, and answers none, is stray. Every other frame is a request.
/// - Time: a repeated write has the same bytes as its response. It counts as a request if it comes later than
///   the responses of this unit so far let expect, or without any later than the time-out. An identical frame
///   that cannot be the response is a repetition.
///
/// Several masters may send requests before the response to another one has come. So a request waits until
/// its response or its repetition comes, until it is older than its unit lets expect, or until more than
/// kMostWaiting wait.
///
/// Times are nanoseconds since any start. Never allocates. One owner, one thread.
class SerialPairing {
public:
    static constexpr std::size_t kMostWaiting = 4;
    using Slot = std::size_t;
    using Slots = InplaceVector<Slot, kMostWaiting>;

    enum class Role : std::uint8_t {
        request,
        broadcast,  ///< a request without a response
        response,
        stray,  ///< a response without a request
    };

    struct Outcome {
        Role role = Role::request;
        /// Role::request: where it waits. Role::response: where its request waited.
        Slot slot = 0;
        /// Role::request, Role::broadcast: it was sent while a response was due.
        bool overlaps = false;
        /// Role::request: the one before it, which was given up, has the same bytes.
        bool repeats = false;
        /// Requests that have no response.
        Slots given_up;
    };

    explicit SerialPairing(Duration timeout);

    /// @param time_ns  when its last byte arrived
    /// @param pdu      1..253 bytes
    /// @param sender   where it is known, shape and time do not decide
    [[nodiscard]] Outcome on_frame(std::int64_t time_ns, std::uint8_t unit, Bytes pdu,
                                   Sender sender = Sender::unknown);

    /// Gives up the requests that have waited for the time-out.
    [[nodiscard]] Slots expire(std::int64_t time_ns);
    /// Gives up all requests.
    [[nodiscard]] Slots end();
    [[nodiscard]] bool waits() const { return !order_.empty(); }

    /// A request that waits, or left its slot in the last call of a member above.
    [[nodiscard]] const wire::PreparedRequest& request(Slot slot) const { return slots_[slot].bytes; }
    [[nodiscard]] std::uint8_t unit(Slot slot) const { return slots_[slot].unit; }

    static constexpr std::size_t kSlots = kMostWaiting + 1;

private:
    struct Waiting {
        std::uint8_t unit = 0;
        std::int64_t time_ns = 0;
        wire::PreparedRequest bytes;
    };
    [[nodiscard]] bool answers(const Waiting& waiting, std::int64_t time_ns, std::uint8_t unit, Bytes pdu,
                               Sender sender) const;
    struct Answered {
        std::size_t index = 0;  ///< in order_
        bool only = true;       ///< no other request could be answered
    };
    [[nodiscard]] std::optional<Answered> answered_by(std::int64_t time_ns, std::uint8_t unit, Bytes pdu,
                                                      Sender sender) const;
    [[nodiscard]] std::int64_t longest_wait(std::uint8_t unit) const;
    [[nodiscard]] bool is_due(const Waiting& waiting, std::int64_t time_ns) const;
    void learn(const Waiting& waiting, std::int64_t time_ns, Bytes pdu);
    void give_up(std::size_t index, Outcome& outcome);
    void give_up_before(std::int64_t time_ns, std::uint8_t unit, Bytes pdu, Outcome& outcome);
    [[nodiscard]] Slot free_slot(const Outcome& outcome) const;

    std::int64_t timeout_;
    std::array<Waiting, kSlots> slots_;
    Slots order_;  // those that wait, the oldest first
    UsualTimes usual_;
};

}  // namespace takt::capture
