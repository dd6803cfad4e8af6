// What the audit of an endpoint records, and who takes the records.
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
    enum class Event : std::uint8_t { write, refused };

    std::chrono::system_clock::time_point time;
    Event event = Event::write;
    InplaceString<64> peer;
    std::uint8_t unit = 0;
    bool broadcast = false;
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
    wire::Pdu request;           ///< where there are no values
    std::string_view why;        ///< of a refusal: "rule", "read_only", "rate", "exception"; a constant
    std::uint8_t exception = 0;  ///< of a refusal; 0: a broadcast, which is not answered
};

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
