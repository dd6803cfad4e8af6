// Learning of a line's gaps by bisection (gaps: learn).
//
// A read across unconfirmed gaps is tried as a whole. If it is refused, it is split in halves, down to single
// gaps. A gap is marked as refused when a read of it alone was refused kRefusals times, and the values beside
// it were read in between: a device that refuses now and then loses no gap. If both halves of a refused read
// are accepted, the whole is tried again; after as many refusals the device does not accept reads of that
// length. Time-outs, bad responses and "busy" prove nothing: such a gap is tried again after a growing
// back-off.
//
// Number of trial reads for n gaps, b of them bad, on a device that refuses nothing else: at most
// 1 + b * (2 * ceil(log2 n) + kRefusals).
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "takt/bus/health.hpp"
#include "takt/model/item_ranges.hpp"
#include "takt/plan/learning.hpp"
#include "takt/poll/gap_event.hpp"

namespace takt::poll {

/// The number of items, 0 for all 65536.
[[nodiscard]] constexpr std::uint16_t length_of(const model::ItemRange& items) {
    return static_cast<std::uint16_t>(items.last - items.first + 1);
}

/// Whether the values in a range of a device were read recently.
enum class Freshness : std::uint8_t {
    good,     // all were read
    not_yet,  // one was not, or not recently enough
    refused,  // the device refuses one of them by itself
};

class FreshnessProbe {
public:
    /// @param since  polled values must have been read after it
    [[nodiscard]] virtual Freshness freshness(std::size_t device, wire::Function read,
                                              const model::ItemRange& items, Instant since) const = 0;

protected:
    ~FreshnessProbe() = default;
};

class Learning {
public:
    static constexpr unsigned kRefusals = 3;
    static constexpr unsigned kSilences = 3;
    static constexpr Duration kFirstRecheck = std::chrono::hours(1);
    static constexpr Duration kLastRecheck = std::chrono::hours(24);

    explicit Learning(const model::Line& line);

    /// Sets the trials that a new plan leaves. Trials that were begun continue.
    void set_trials(Instant t, std::vector<plan::Trial> trials);

    /// A read that tests gaps.
    struct TrialRead {
        std::size_t device = 0;
        wire::ReadRequest read;
    };
    /// The next trial read; nothing: try again at wakeup(), or when a value was read.
    [[nodiscard]] std::optional<TrialRead> next(Instant t, const FreshnessProbe& probe);
    /// The read of the last next() is sent: one of the functions below will be called.
    void asked() { waiting_ = true; }
    [[nodiscard]] bool waiting() const { return waiting_; }

    /// The outcome of the read. @param code  of an exception
    void on_taken(Instant t);
    void on_refused(Instant t, std::uint8_t code);
    /// No proof. @param silent  it counts against the gap; else (busy, link lost) it does not
    void on_nothing(Instant t, bool silent);

    /// A polled read was refused several times: its gaps are unconfirmed from now on.
    void doubt(std::size_t device, wire::Function read, const model::ItemRange& items);
    /// A device answers again: it may have been replaced. Refused gaps are tested again soon.
    void on_return(Instant t, std::size_t device);

    /// The knowledge has changed, and no result is expected soon: a new plan should be made.
    [[nodiscard]] bool wants_plan(Instant t) const;
    void plan_is_made() { changed_ = urgent_ = false; }

    /// When to call next() again, later than `t`, if nothing happens before.
    [[nodiscard]] Instant wakeup(Instant t) const;
    [[nodiscard]] std::optional<GapEvent> take_event();
    /// Of each device of the line, with the times as of `t`.
    [[nodiscard]] std::vector<model::Learnt> learnt(Instant t) const;
    /// The same into memory of the caller, one element for each device, without allocating.
    /// @returns false where a list has less capacity than it needs; `into` is then incomplete
    [[nodiscard]] bool copy_learnt(Instant t, std::span<model::Learnt> into) const;

private:
    /// Some gaps of a trial that are read together.
    struct Node {
        std::size_t first = 0;
        std::size_t last = 0;
        std::size_t parent = 0;  // below it in the stack; of the lowest: itself
        unsigned refused = 0;
        unsigned silent = 0;
        bool faulty = false;  // it was refused, or its parent was and the other half was not
        bool split = false;
        bool part_failed = false;  // one of its parts was not accepted
    };
    struct Run {
        plan::Trial trial;
        std::vector<Node> stack;
        Instant not_before = Instant::min();
        Instant since = Instant::min();  // the values beside it are to be read after this
        bus::Backoff silence_backoff;
        std::optional<Duration> postponed;  // it was postponed for so long
        std::optional<Instant> blocked;     // since when a value beside it is refused
    };
    /// A single gap that was refused fewer than kRefusals times.
    struct Suspicion {
        std::size_t device = 0;
        wire::Function read{};
        model::ItemRange items;
        unsigned refused = 0;
        Instant first;
    };
    struct Refused {
        model::ItemRange items;
        std::uint8_t exception = 0;
        Instant since;
        Instant checked;
    };
    struct Area {
        model::ItemRanges confirmed;
        std::vector<Refused> refused;
        std::uint16_t most_items = 0;
        std::uint16_t longest_taken = 0;
    };
    struct Device {
        std::array<Area, 4> areas;
    };

    void start(Instant t);
    [[nodiscard]] Run make_run(Instant t, plan::Trial trial);
    void add_run(Instant t, plan::Trial trial, std::vector<Run>& known);
    [[nodiscard]] static model::ItemRange range_of(const Run& run, const Node& node);
    [[nodiscard]] Area& area(const plan::Trial& trial);
    [[nodiscard]] bool ready(Instant t, Run& run, const FreshnessProbe& probe);
    void go_round(Instant t, Run& run);
    [[nodiscard]] static bool active(const Run& run);
    static void split(Run& run, std::size_t node);
    static void close(Run& run, bool taken);
    void postpone(Instant t, Run& run);
    void confirm(const plan::Trial& trial, const model::ItemRange& items);
    void on_gap_refused(Instant t, Run& run, std::uint8_t code);
    void give_up(Instant t, const plan::Trial& trial, std::uint8_t code, const Suspicion& suspicion);
    void on_whole_refused(Run& run, std::uint8_t code);
    void drop_finished();
    Suspicion& suspicion_of(Instant t, const plan::Trial& trial, const model::ItemRange& items);
    void add_event(GapEvent::Kind kind, const plan::Trial& trial, const model::ItemRange& items,
                   std::uint8_t code);
    [[nodiscard]] Instant recheck_at(const Refused& refused) const;

    std::vector<Device> devices_;
    std::vector<Run> runs_;
    std::vector<Suspicion> suspicions_;
    std::vector<GapEvent> events_;
    std::size_t cursor_ = 0;  // the run of the current trial read
    bool waiting_ = false;
    bool changed_ = false;
    bool urgent_ = false;
    bool started_ = false;  // the times of what was refused count from the start
    Instant last_answer_ = Instant::min();
};

}  // namespace takt::poll
