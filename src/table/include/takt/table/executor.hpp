// Runs one line of a request table without a heap, as a controller polls its devices.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "takt/base/engine.hpp"
#include "takt/base/result.hpp"
#include "takt/base/status_code.hpp"
#include "takt/bus/arbiter.hpp"
#include "takt/bus/health.hpp"
#include "takt/bus/outcome_status.hpp"
#include "takt/bus/release.hpp"
#include "takt/bus/transaction_engine.hpp"
#include "takt/bus/unit_times.hpp"
#include "takt/table/view.hpp"

namespace takt::table {

/// How good a value in the buffer is.
enum class Quality : std::uint8_t { never_read, good, uncertain, bad };

/// The state of one item. A default-constructed one is the initial state.
struct ItemState {
    std::uint16_t status = 0;       ///< docs/specification.md, section 7: 0, exception 1..11, 100..105
    std::uint16_t last_result = 0;  ///< status of its last read or write that was sent
    Quality quality = Quality::never_read;
    bool read : 1 = false;     ///< `read` of the memory has its words: as last read, else its default
    bool wanted : 1 = false;   ///< `wanted` of the memory has its words
    bool away : 1 = false;     ///< the status shown is that of its device
    bool pending : 1 = false;  ///< a bit of a register: set since the last write on change
    bool sending : 1 = false;  ///< likewise: part of the last write of its entry
};

/// The value buffer, shared by the executors of all lines of a table. The caller owns it; the words of
/// `values` may be read at any time between calls, those of locals and variables are changed by Executor::set
/// and set_local only.
struct Memory {
    std::span<std::uint16_t> values;  ///< Header::value_words
    std::span<std::uint16_t>
        read;  ///< Header::write_words: as last read, else the default, of what can be written
    std::span<std::uint16_t> wanted;  ///< Header::write_words: as last set
    std::span<ItemState> items;       ///< as many as items
};

/// The state of one entry. A default-constructed one is the initial state.
struct EntryState {
    bus::PeriodicRelease release{Duration::zero()};
    bus::Health health{1};
    bus::Backoff read_busy = bus::busy_backoff();
    bus::Backoff write_busy = bus::busy_backoff();
    Instant read_not_before = Instant::min();
    Instant write_not_before = Instant::min();
    Instant last_start = Instant::min();
    std::optional<Instant> retry;  // when a failed polled read came back into the queue
    std::uint64_t read_order = 0;  // of arrival, among triggers
    std::uint64_t write_order = 0;
    std::uint16_t write_failures = 0;
    StatusCode status = StatusCode::ok;
    bool link_lost = false;  // before its last response
    bool read_triggered = false;
    bool by_trigger = false;  // of the transaction in flight
    bool asked = false;       // by set(), or by a retry
    bool write_triggered = false;
    bool read_admitted = false;   // the triggered read has taken its token of the line
    bool write_admitted = false;  // so has the write
};

/// The state of one device.
struct DeviceState {
    bus::Health health{1};
    bus::UnitTimes times;
    bool enabled = true;
    bool in_flight = false;
    bool has_reads = false;
    bool away = false;          ///< its variables show why it is not asked
    bool probed_early = false;  ///< the probe in flight was sent before its back-off had passed
};

/// Memory for the state of one line: as many elements as it has entries and devices.
struct Workspace {
    std::span<EntryState> entries;
    std::span<DeviceState> devices;
};

/// The settings of the bus of a line of a table.
[[nodiscard]] bus::LineConfig line_config(const LineRecord& line);

/// Writes the defaults of all items into the memory: their values, and what is written until they are read.
/// Call it once, before the executors are made.
void initialise(const View& view, const Memory& memory);

/// Chooses requests with the arbiter of poll::LinePoller (bus::Arbiter), and sends them through
/// bus::TransactionEngine, with the same time-outs, retries and back-offs. So the same frames are sent in the
/// same order. Triggers and writes go in the order of arrival. There are two differences. While a late
/// response could be mistaken for that to a read, the poller may send another read; the executor waits, and
/// repeats the read if its response is in doubt (LinePoller::Options::distinct_reads). And the poller holds
/// back what it reads after time-outs until that is confirmed.
///
/// Not supported: 0x17, rate limits of single entries, and more than one transaction at a time.
///
/// Never allocates. One owner, one thread; view, memory and workspace must outlive it.
class Executor final : public Engine {
public:
    /// @returns not_found (line) for a line the view does not have; too_short (there, needed) for a memory or
    ///          workspace that is too small; unsupported (subject "entry", its index) for an entry it does
    ///          not run
    [[nodiscard]] static Result<void> can_run(const View& view, std::uint32_t line, const Memory& memory,
                                              const Workspace& workspace);

    /// can_run() must have succeeded.
    /// @param bus       instead of line_config()
    /// @param observer  notified of every frame; may be nullptr
    Executor(const View& view, std::uint32_t line, const Memory& memory, const Workspace& workspace,
             const std::optional<bus::LineConfig>& bus = {}, wire::TrafficObserver* observer = nullptr);
    Executor(const Executor&) = delete;
    Executor& operator=(const Executor&) = delete;

    void on_link(Instant t, bool up) override;
    void on_bytes(Instant t, Bytes bytes) override;
    void on_tick(Instant t) override;
    [[nodiscard]] Bytes transmit(Instant t) override;
    [[nodiscard]] Instant next_wakeup() const override;
    [[nodiscard]] std::optional<Error> rejection() const override { return engine_.rejection(); }
    [[nodiscard]] bool must_reconnect() const { return engine_.must_reconnect(); }

    /// Sets the wanted value of a variable of this line: words_of() words in the order of the value buffer.
    /// If it is written on change, its entry is written as soon as each member was set or read or has a
    /// default; else by its trigger.
    /// @returns not_writable (item)
    [[nodiscard]] Result<void> set(std::uint32_t item, std::span<const std::uint16_t> words);

    /// A local bool has changed from `before` to `after`, and the caller has written it into the values:
    /// evaluates triggers and enables. Call it on the executor of every line.
    void on_local(Instant t, std::uint32_t item, bool before, bool after);

    /// No request is chosen any more; the transaction in flight ends. Then it is idle.
    void stop() { stopped_ = true; }
    /// No transaction is in flight.
    [[nodiscard]] bool idle() const { return engine_.idle(); }

    [[nodiscard]] bool answering(std::uint32_t device) const { return devices_[device].health.answering(); }
    [[nodiscard]] const bus::LineCounters& counters() const { return engine_.counters(); }

private:
    /// A read-modify-write. Nothing is sent between its steps, so that it is atomic on the line.
    struct Modify {
        enum class Step : std::uint8_t { none, reading, writing };  // writing: the write is to be sent
        Step step = Step::none;
        std::uint16_t old = 0;  // the register as read
        std::uint32_t entry = 0;
    };

    // executor.cpp
    /// Of a transaction, or of a job of the arbiter.
    [[nodiscard]] static std::uint32_t entry_of(bus::TransactionId id) {
        return static_cast<std::uint32_t>(id >> 1);
    }
    [[nodiscard]] static bool is_write(bus::TransactionId id) { return (id & 1) != 0; }
    [[nodiscard]] static bool is_polled(const EntryRecord& entry) {
        return (entry.flags & EntryRecord::kPolled) != 0;
    }
    [[nodiscard]] static bool is_read(const EntryRecord& entry) {
        return entry.read != 0 && (is_polled(entry) || entry.read_trigger != kNone);
    }
    [[nodiscard]] EntryRecord entry(std::uint32_t index) const {
        return view_.entry(line_.first_entry + index);
    }
    [[nodiscard]] DeviceRecord device(std::uint32_t index) const {
        return view_.device(line_.first_device + index);
    }
    [[nodiscard]] std::uint32_t device_of(const EntryRecord& entry) const {
        return entry.device - line_.first_device;
    }
    [[nodiscard]] bool reachable(const DeviceState& device) const;
    void set_up();
    void restart_device(Instant t, std::uint32_t device, bool at_once);
    void switch_device(Instant t, std::uint32_t device, bool on);
    void release_at_once(Instant t, const DeviceRecord& device);
    void resume_device(std::uint32_t device);
    [[nodiscard]] bool brings_news(const EntryRecord& entry, std::uint32_t index,
                                   const DeviceRecord& device) const;
    [[nodiscard]] bool has_member(const EntryRecord& entry, std::uint32_t item) const;
    [[nodiscard]] bool in_pieces(std::uint32_t item, const DeviceRecord& device) const;
    void drop_triggers(std::uint32_t device);
    void take_outcomes();

    // choice.cpp
    void choose(Instant t);
    void consider(Instant t, UnitId unit, const bus::AnswerShape& shape, Instant due,
                  const bus::Candidate& candidate);
    [[nodiscard]] static Instant polling_due(const EntryState& state);
    void consider_read(Instant t, std::uint32_t index, const EntryRecord& entry, UnitId unit);
    void consider_write(Instant t, std::uint32_t index, const EntryRecord& entry, UnitId unit);
    void consider_probe(Instant t, std::uint32_t device);
    void consider_early_probes(Instant t);
    [[nodiscard]] std::optional<std::uint32_t> probe_of(std::uint32_t device) const;
    void offer_probe(Instant t, std::uint32_t index, Instant since);
    [[nodiscard]] Instant last_read(std::uint32_t device) const;
    [[nodiscard]] bus::PolledRead polled_read(std::uint32_t index, const EntryRecord& entry) const;
    void start_read(Instant t, std::uint32_t index, bool by_trigger);
    void start_write(Instant t, std::uint32_t index);
    void continue_modify(Instant t);
    void end_write(std::uint32_t index);
    void submit(Instant t, const EntryRecord& entry, bus::TransactionId id,
                const wire::PreparedRequest& request);

    // answers.cpp
    bus::OutcomeStatus note_outcome(const bus::Outcome& outcome, std::uint32_t device);
    void on_read(const bus::Outcome& outcome, std::uint32_t index);
    void on_written(const bus::Outcome& outcome, std::uint32_t index);
    void write_again(std::uint32_t index, const EntryRecord& entry);
    void note_delay(const bus::Outcome& outcome, DeviceState& state) const;
    void note_late(const bus::LateResponse& late);
    void note_surplus(const bus::SurplusFrame& frame);
    void degrade_shifted(std::uint32_t device, const bus::AnswerShape& shape, Instant since);
    void read_again(Instant t, EntryState& state, const EntryRecord& entry, StatusCode status);
    void fail_read(Instant t, std::uint32_t index, const EntryRecord& entry, StatusCode status);
    void take_values(const EntryRecord& entry, const wire::ResponseView& response);
    void degrade(const EntryRecord& entry, Quality quality, StatusCode status, bool to_default);
    void degrade_item(std::uint32_t item, Quality quality, StatusCode status, bool to_default);
    void degrade_device(std::uint32_t device, StatusCode status, bool to_default);
    /// Of a read, and of a request that was refused: of all members. Of a write: of those that were sent.
    enum class Of : std::uint8_t { all, sent };
    [[nodiscard]] bool concerns(const EntryRecord& entry, std::uint32_t item, Of of) const;
    void set_status(std::uint32_t index, const EntryRecord& entry, StatusCode status, Of of = Of::all);
    void note_result(const EntryRecord& entry, StatusCode status, Of of);
    void put_statuses(const EntryRecord& entry, StatusCode status, Of of = Of::all);
    void put_statuses_of_device(std::uint32_t device, StatusCode status);
    void restore_statuses(std::uint32_t device);
    void set_device_status(std::uint32_t device);
    void put_status(std::uint32_t item, StatusCode status);

    // modify.cpp
    [[nodiscard]] static bool modifies(const EntryRecord& entry) {
        return (entry.flags & EntryRecord::kReadModifyWrite) != 0;
    }
    [[nodiscard]] static bool writes_bits(const EntryRecord& entry);
    [[nodiscard]] bool any_wanted(const EntryRecord& entry) const;
    [[nodiscard]] bool is_chosen(const EntryState& state, const EntryRecord& entry, std::uint32_t item) const;
    [[nodiscard]] bool any_chosen(const EntryState& state, const EntryRecord& entry) const;
    void choose_bits(const EntryState& state, const EntryRecord& entry);
    [[nodiscard]] Result<wire::PreparedRequest> bits_request(const EntryRecord& entry) const;
    [[nodiscard]] Result<wire::PreparedRequest> first_request(const EntryRecord& entry) const;
    [[nodiscard]] bool take_register(const bus::Outcome& outcome, bool ok);

    // item_words.cpp
    [[nodiscard]] std::span<const std::uint16_t> value_to_write(const ItemRecord& item,
                                                                std::uint32_t index) const;
    [[nodiscard]] bool group_ready(const EntryState& state, const EntryRecord& entry) const;
    [[nodiscard]] Result<wire::PreparedRequest> write_request(const EntryRecord& entry) const;
    void ask(std::uint32_t index);

    const View& view_;
    LineRecord line_;
    Memory memory_;
    std::span<EntryState> entries_;
    std::span<DeviceState> devices_;
    bus::TransactionEngineOf<1> engine_;
    bus::Arbiter arbiter_;
    Modify modify_;
    std::uint64_t last_order_ = 0;
    Instant epoch_;  // origin of the release grid: the first link
    bool up_ = false;
    bool was_up_ = false;
    bool stopped_ = false;
};

}  // namespace takt::table
