// The records of an endpoint's audit, and the interface that takes them.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "takt/base/inplace_string.hpp"
#include "takt/base/time.hpp"
#include "takt/wire/function.hpp"
#include "takt/wire/pdu.hpp"

namespace takt::endpoint {

/// One write, or one request that was refused.
struct AuditRecord {
    enum class Event : std::uint8_t {
        write,    ///< it was executed, or may have been
        refused,  ///< it was not executed
    };
    /// The outcome of a relayed write.
    enum class Outcome : std::uint8_t {
        none,      ///< not a relayed write
        done,      ///< the device confirmed it
        sent,      ///< a broadcast, which no device confirms
        refused,   ///< the device answered with an exception
        unknown,   ///< it was sent, and no valid response came
        not_sent,  ///< it never reached the line
    };

    std::chrono::system_clock::time_point time;
    Event event = Event::write;
    InplaceString<64> peer;
    InplaceString<64> role;                  ///< of its certificate; empty: none
    std::uint8_t unit = 0;                   ///< as in the request
    std::optional<std::uint8_t> own_unit;    ///< the own unit that handled the request, if it is another one
    bool broadcast = false;                  ///< to all units, of a serial line behind the server too
    std::optional<std::uint8_t> relayed_to;  ///< of a relayed request: the unit on the line
    std::uint8_t function = 0;
    /// Of a request that touches items.
    struct Items {
        wire::Area area = wire::Area::holding_register;
        std::uint16_t start = 0;
        std::uint16_t count = 0;
    };
    std::optional<Items> items;
    /// Of a write to items, as on the wire: bits from the lowest of the first byte on, registers high byte
    /// first. Empty for other requests.
    wire::Pdu old_values;
    wire::Pdu new_values;
    wire::Pdu request;  ///< where there are no values
    /// Of a refusal: "rule", "read_only", "rate", "exception", "disconnected"; a constant.
    std::string_view why;
    /// Of a refusal; of a broadcast the exception that is not sent. 0: none (a rule refused a broadcast, or
    /// the client is gone).
    std::uint8_t exception = 0;
    Outcome outcome = Outcome::none;
};

/// "done", "sent", "refused", "unknown", "not_sent"; empty for none.
[[nodiscard]] std::string_view name(AuditRecord::Outcome outcome);

/// The record as one line, with its end.
[[nodiscard]] std::string audit_line(const AuditRecord& record);

/// Takes the records.
class AuditSink {
public:
    virtual ~AuditSink() = default;
    /// Must not block. @param t  the engines' time: the rate limits go by it
    virtual void put(Instant t, const AuditRecord& record) = 0;
};

/// Observes records on the I/O thread. Must not block.
using AuditObserver = std::function<void(Instant t, const AuditRecord& record)>;

/// Passes each record on to an observer and to another sink.
class ObservedAudit final : public AuditSink {
public:
    ObservedAudit(std::shared_ptr<AuditSink> sink, AuditObserver observer)
        : sink_(std::move(sink)), observer_(std::move(observer)) {}

    void put(Instant t, const AuditRecord& record) override {
        observer_(t, record);
        sink_->put(t, record);
    }

private:
    std::shared_ptr<AuditSink> sink_;
    AuditObserver observer_;
};

}  // namespace takt::endpoint
