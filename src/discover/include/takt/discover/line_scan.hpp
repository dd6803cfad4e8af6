// Which units of a line answer, and what they say they are: the engine behind `takt scan`.
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

namespace takt::discover {

struct ScanConfig {
    bus::LineConfig line;
    std::vector<UnitId> units;  ///< asked in this order; without broadcast on serial lines, each once
    Duration wait = std::chrono::milliseconds(100);  ///< for the first byte of an answer
    /// For units whose answer seems to have come too late: they are asked once more at the end, with this
    /// wait.
    Duration patience = std::chrono::milliseconds(500);
    bool identify = true;   ///< ask what they are: 43/14, else 17
    bool thorough = false;  ///< ask silent units by other functions too: 4, 1, 43/14
};

/// What a unit says it is; all empty where it does not say.
struct UnitIdentity {
    struct Object {
        std::uint8_t id =
            0;             ///< 0 vendor, 1 product code, 2 revision, 3 URL, 4 product, 5 model, 6 application
        std::string text;  ///< as received, any bytes
    };
    static constexpr std::size_t kMaxObjects = 128;

    std::vector<Object> objects;          ///< of 43/14, basic and regular
    std::vector<std::uint8_t> server_id;  ///< data of the answer to 17

    /// The text of an object; nullptr: not told.
    [[nodiscard]] const std::string* find(std::uint8_t id) const;
};

struct FoundUnit {
    UnitId unit{1};
    std::uint8_t function = 0;   ///< of the question it answered first
    std::uint8_t exception = 0;  ///< it answered with that exception, which proves it too; 0: with values
    Duration response_time{};  ///< of that answer: end of the request to its last byte; 0 on a pty, which is
                               ///< faster
    bool late = false;         ///< only answered when it was given more time
    bool garbled = false;      ///< some of its answers did not check
    bool doubled = false;      ///< a second answer came behind one
    UnitIdentity identity;
};

enum class ScanEnd : std::uint8_t {
    complete,
    line_busy,  ///< others do not leave the line a silence to ask in
};

/// Asks each unit for holding register 0, which everything that speaks Modbus answers with a value or an
/// exception; exceptions 10 and 11 are a gateway's word for a unit that is not there. Whoever answered is
/// asked what it is, and only a second frame that checks proves it: noise is no device. Between the two the
/// line is listened to for a moment, in which the answer of another device with the same address may come.
///
/// A unit whose answers do not check three times in a row is listed as garbled: two devices at one address,
/// other line settings, a bad line. After a time-out the line may still bring the answer; then the unit is
/// asked again at the end, with more patience, so that a short `wait` loses nobody; after the last unit the
/// line is listened to for as long as `patience`.
///
/// After a link that was lost the question is asked once more. Reads only. One owner, one thread.
class LineScan final : public Engine, private wire::TrafficObserver {
public:
    /// @param observer  told of every frame; may be nullptr; must outlive the scan
    explicit LineScan(const ScanConfig& config, wire::TrafficObserver* observer = nullptr);
    LineScan(const LineScan&) = delete;
    LineScan& operator=(const LineScan&) = delete;

    void on_link(Instant t, bool up) override;
    void on_bytes(Instant t, Bytes bytes) override;
    void on_tick(Instant t) override;
    [[nodiscard]] Bytes transmit(Instant t) override;
    [[nodiscard]] Instant next_wakeup() const override;
    [[nodiscard]] bool must_reconnect() const { return engine_.must_reconnect(); }

    [[nodiscard]] bool finished() const { return finished_; }
    [[nodiscard]] ScanEnd end() const { return end_; }

    /// In the order they were found; grows while the scan runs.
    [[nodiscard]] const std::vector<FoundUnit>& found() const { return found_; }
    /// Units that answered, but never with a frame that checks.
    [[nodiscard]] const std::vector<UnitId>& garbled() const { return garbled_; }
    /// A gateway answered for a unit that is not there (exceptions 10, 11).
    [[nodiscard]] bool gateway() const { return gateway_; }
    /// Frames of units that were not asked: the line has another master, or other users.
    [[nodiscard]] std::uint64_t strangers() const { return strangers_; }

    [[nodiscard]] std::size_t visited() const { return visited_; }
    [[nodiscard]] std::size_t total() const { return config_.units.size() + second_.size(); }
    [[nodiscard]] std::uint64_t requests() const { return engine_.counters().sent; }

private:
    enum class Step : std::uint8_t { ask, basic, regular, server_id, again };
    /// What is known of the unit that is being asked.
    struct Visit {
        Step step = Step::ask;
        std::size_t question = 0;  // of those that find a unit
        int tries = 0;             // of this step that did not check, or found no link
        int pages = 0;             // of 43/14
        std::uint8_t object = 0;   // of 43/14: where to go on
        bool proven = false;
        bool answered = false;
        bool timed_out = false;  // its answer may still come
        FoundUnit found;
    };

    void on_frame(Instant t, wire::Direction direction, UnitId unit, Bytes pdu, Bytes raw) override;
    void on_fault(Instant t, wire::FrameFault fault) override;

    void work(Instant t);
    void submit(Instant t);
    [[nodiscard]] wire::Request request() const;
    void judge(Instant t, const bus::Outcome& outcome);
    void repeat(Instant t, bool garbled);
    void answered(Instant t, const bus::Outcome& outcome);
    void first_answer(Instant t, const bus::Outcome& outcome);
    void take_device_id(Instant t, const bus::Outcome& outcome);
    void unanswered(Instant t);
    void next_step(Step step);
    void leave(Instant t);
    void revisit(UnitId unit);
    [[nodiscard]] UnitId unit() const;
    [[nodiscard]] bool second_visit() const { return visited_ >= config_.units.size(); }
    [[nodiscard]] std::uint64_t unasked() const;

    enum class State : std::uint8_t { unknown, asked, silent, again };
    ScanConfig config_;
    wire::TrafficObserver* observer_;
    bus::TransactionEngine engine_;
    std::array<State, 256> states_{};
    std::vector<UnitId> second_;  // asked again at the end
    std::vector<FoundUnit> found_;
    std::vector<UnitId> garbled_;
    std::optional<UnitId> before_;  // the unit asked last, when its answer may still come
    Visit visit_;
    std::size_t visited_ = 0;
    std::uint64_t strangers_ = 0;
    std::uint64_t unasked_before_ = 0;
    int busy_ = 0;
    Instant not_before_ = Instant::min();
    bool gateway_ = false;
    bool finished_ = false;
    ScanEnd end_ = ScanEnd::complete;
};

}  // namespace takt::discover
