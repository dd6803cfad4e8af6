// Finds the units of a line and identifies them: the engine behind `takt scan`.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "takt/base/engine.hpp"
#include "takt/bus/transaction_engine.hpp"
#include "takt/wire/traffic.hpp"

namespace takt::bus {

struct ScanConfig {
    bus::LineConfig line;
    std::vector<UnitId> units;  ///< in the order of the requests, each once; no broadcast on serial lines
    Duration wait = std::chrono::milliseconds(100);  ///< for the first byte of a response
    /// The same for the second request to a unit whose response seems to have come too late.
    Duration retry_wait = std::chrono::milliseconds(500);
    /// After the first unit was found, silent units get expected_wait() of the responses so far instead of
    /// `wait`. Not for serial lines.
    bool adaptive = false;
    bool identify = true;   ///< read the identification: function 43/14, else 17
    bool thorough = false;  ///< also send functions 4, 1 and 43/14 to a silent unit
};

/// The identification of a unit; empty where it has none.
struct UnitIdentity {
    struct Object {
        /// 0 vendor, 1 product code, 2 revision, 3 URL, 4 product, 5 model, 6 application.
        std::uint8_t id = 0;
        std::string text;  ///< as received, any bytes
        friend bool operator==(const Object&, const Object&) = default;
    };
    static constexpr std::size_t kMaxObjects = 128;

    std::vector<Object> objects;          ///< of 43/14, basic and regular
    std::vector<std::uint8_t> server_id;  ///< data of the response to function 17

    /// The text of an object; nullptr: the unit does not have it.
    [[nodiscard]] const std::string* find(std::uint8_t id) const;
    friend bool operator==(const UnitIdentity&, const UnitIdentity&) = default;
};

struct FoundUnit {
    UnitId unit{1};
    std::uint8_t function = 0;   ///< of its first response
    std::uint8_t exception = 0;  ///< of its first response; 0: a normal one
    /// From the end of the first request to the last byte of its response. 0 on a pseudo-terminal, where the
    /// response arrives before the request would have been sent.
    Duration response_time{};
    bool late = false;     ///< it responded within `retry_wait` only
    bool garbled = false;  ///< some of its responses had a wrong checksum or form
    bool doubled = false;  ///< a second frame followed a response: two devices at one address
    UnitIdentity identity;
};

/// Its responses do not check.
struct GarbledUnit {
    UnitId unit;
    std::optional<Mismatch> cut_short;  ///< the last one
    friend bool operator==(const GarbledUnit&, const GarbledUnit&) = default;
};

enum class ScanEnd : std::uint8_t {
    complete,
    line_busy,  ///< other traffic left no silence for a request
};

/// Reads holding register 0 of each unit. Every Modbus device responds to that with a value or an exception.
/// Exceptions 10 and 11 are a gateway's report that the unit is absent.
///
/// A unit counts as found when two of its frames check, so that noise is no device. After the first frame the
/// scan listens for 30 ms: the response of a second device with the same address may follow.
///
/// A unit whose responses do not check three times in a row is listed in garbled(): two devices with one
/// address, other line settings, a bad line, or responses that are cut short. After a time-out the response
/// may still arrive, during the request to the next unit. The unit is then asked again at the end, with
/// `retry_wait`. After the last unit the scan listens for that long.
///
/// With `adaptive` each time-out that is shorter than `wait` is followed by a request to a unit that was
/// found. A server that does not answer it in time may be a gateway that works on the request to the absent
/// unit: the next requests would queue behind that one. Then the unit is asked again at the end. After that,
/// and after a response that came too late, the waits are four times as long, up to `wait`.
///
/// After a lost link the request is repeated once. The scan only reads. One owner, one thread.
class LineScan final : public Engine, private wire::TrafficObserver {
public:
    /// @param observer  receives every frame; may be nullptr; must outlive the scan
    explicit LineScan(const ScanConfig& config, wire::TrafficObserver* observer = nullptr);
    LineScan(const LineScan&) = delete;
    LineScan& operator=(const LineScan&) = delete;

    void on_link(Instant t, bool up) override;
    void on_bytes(Instant t, Bytes bytes) override;
    void on_tick(Instant t) override;
    [[nodiscard]] Bytes transmit(Instant t) override;
    [[nodiscard]] Instant next_wakeup() const override;
    [[nodiscard]] std::optional<Error> rejection() const override { return engine_.rejection(); }
    [[nodiscard]] bool must_reconnect() const { return engine_.must_reconnect(); }

    [[nodiscard]] bool finished() const { return finished_; }
    [[nodiscard]] ScanEnd end() const { return end_; }

    /// In the order of discovery; grows during the scan.
    [[nodiscard]] const std::vector<FoundUnit>& found() const { return found_; }
    /// Units that responded, but never with a frame that checks.
    [[nodiscard]] const std::vector<GarbledUnit>& garbled() const { return garbled_; }
    /// A gateway reported an absent unit (exceptions 10, 11).
    [[nodiscard]] bool gateway() const { return gateway_; }
    /// Frames of units that are not in the list: the line has another master.
    [[nodiscard]] std::uint64_t foreign_frames() const { return foreign_frames_; }

    [[nodiscard]] std::size_t visited() const { return visited_; }
    [[nodiscard]] std::size_t total() const { return config_.units.size() + second_.size(); }
    [[nodiscard]] std::uint64_t requests() const { return engine_.counters().sent; }

private:
    enum class Step : std::uint8_t { ask, basic, regular, server_id, again, check };
    /// The state of the current unit.
    struct Visit {
        Step step = Step::ask;
        std::size_t question = 0;  // index into questions()
        int tries = 0;             // failed attempts of this step
        int pages = 0;             // responses to 43/14
        std::uint8_t object = 0;   // first object of the next request 43/14
        bool proven = false;
        bool answered = false;
        bool timed_out = false;  // its response may still arrive
        bool blocking = false;   // the server did not answer another unit meanwhile
        FoundUnit found;
    };

    void on_frame(Instant t, wire::Direction direction, UnitId unit, Bytes pdu, Bytes raw) override;
    void on_fault(Instant t, wire::FrameFault fault, Bytes raw) override;

    void work(Instant t);
    void submit(Instant t);
    [[nodiscard]] wire::Request request() const;
    void on_outcome(Instant t, const bus::Outcome& outcome);
    void repeat(Instant t, const bus::Outcome& outcome, bool garbled);
    void answered(Instant t, const bus::Outcome& outcome);
    void first_answer(Instant t, const bus::Outcome& outcome);
    void take_device_id(Instant t, const bus::Outcome& outcome);
    void unanswered(Instant t);
    void checked(Instant t, const bus::Outcome& outcome);
    void learn(const bus::Outcome& outcome);
    void learn_late();
    [[nodiscard]] Duration wait() const;
    [[nodiscard]] bool adapted() const;
    void next_step(Step step);
    void leave(Instant t);
    void revisit(UnitId unit);
    [[nodiscard]] UnitId unit() const;
    [[nodiscard]] bool second_visit() const { return visited_ >= config_.units.size(); }
    /// Frames and bytes that belong to no request.
    struct Unsolicited {
        std::uint64_t frames = 0;
        std::uint64_t bytes = 0;
    };
    [[nodiscard]] Unsolicited unsolicited() const;
    [[nodiscard]] bool responded_twice() const;

    enum class State : std::uint8_t { unknown, asked, silent, again };
    ScanConfig config_;
    wire::TrafficObserver* observer_;
    bus::TransactionEngine engine_;
    std::array<State, 256> states_{};
    std::vector<UnitId> second_;  // visited again at the end
    std::vector<FoundUnit> found_;
    std::vector<GarbledUnit> garbled_;
    std::optional<UnitId> before_;  // the last unit, while its response may still arrive
    Visit visit_;
    std::size_t visited_ = 0;
    std::uint64_t foreign_frames_ = 0;
    Unsolicited unsolicited_before_;  // of the unit that is asked
    int busy_ = 0;
    Instant not_before_ = Instant::min();
    Duration slowest_{};  // of the responses so far
    bool gateway_ = false;
    bool finished_ = false;
    ScanEnd end_ = ScanEnd::complete;
};

}  // namespace takt::bus
