// What is tried of a line's unconfirmed gaps, in which order, and what the answers show (gaps: learn).
//
// A read that bridges unconfirmed gaps is tried whole. Where it is refused it is halved, down to single gaps;
// a gap is given up when it alone was refused kRefusals times, the values beside it having been read in
// between. So a device that refuses now and then loses nothing. Where both halves of what was refused are
// taken, it is tried again; refused as often, the device takes no reads as long as that. Silence, nonsense
// and "busy" prove nothing: such a gap is asked for again, less and less often.
//
// Tries for n gaps of which b are bad: at most 1 + b * (2 * ceil(log2 n) + kRefusals) where the device
// refuses nothing else.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "takt/bus/health.hpp"
#include "takt/model/item_ranges.hpp"
#include "takt/plan/learning.hpp"
#include "takt/poll/lesson.hpp"

namespace takt::poll {

/// What is known of the values in a range of a device at this moment.
enum class Fresh : std::uint8_t {
    good,     // all were read
    not_yet,  // one was not, or not since
    refused,  // the device refuses one of them by itself
};

class Witness {
public:
    /// @param since  those that are polled were read after it
    [[nodiscard]] virtual Fresh look(std::size_t device, wire::Function read, const model::ItemRange& items,
                                     Instant since) const = 0;

protected:
    ~Witness() = default;
};

class Learning {
public:
    static constexpr unsigned kRefusals = 3;
    static constexpr unsigned kSilences = 3;
    static constexpr Duration kFirstRecheck = std::chrono::hours(1);
    static constexpr Duration kLastRecheck = std::chrono::hours(24);

    explicit Learning(const model::Line& line);

    /// What a new plan leaves to be tried. Goes on with what was begun.
    void set_trials(Instant t, std::vector<plan::Trial> trials);

    /// One read that tries something.
    struct Question {
        std::size_t device = 0;
        wire::ReadRequest read;
    };
    /// What may be asked now; nothing: see wakeup(), or when a value was read.
    [[nodiscard]] std::optional<Question> next(Instant t, const Witness& witness);
    /// The question of the last next() is asked: an answer will come.
    void asked() { waiting_ = true; }
    [[nodiscard]] bool waiting() const { return waiting_; }

    /// How it was answered. @param code  of an exception
    void on_taken(Instant t);
    void on_refused(Instant t, std::uint8_t code);
    /// @param silent  it counts against the gap; else (busy, link lost) not
    void on_nothing(Instant t, bool silent);

    /// A polled read was refused several times over: what it bridges is unconfirmed from now on.
    void doubt(std::size_t device, wire::Function read, const model::ItemRange& items);
    /// A device answers again: it may be another one. What it refused is asked for soon.
    void on_return(Instant t, std::size_t device);

    /// A new plan would be another one, and this is a good moment to make it.
    [[nodiscard]] bool wants_plan(Instant t) const;
    void plan_is_made() { changed_ = urgent_ = false; }

    /// When to come again, later than `t`, if nothing happens before.
    [[nodiscard]] Instant wakeup(Instant t) const;
    [[nodiscard]] std::optional<Lesson> take_lesson();
    /// Of each device of the line, with the times as of `t`.
    [[nodiscard]] std::vector<model::Learnt> learnt(Instant t) const;

private:
    /// Some gaps of a trial that are read together.
    struct Node {
        std::size_t first = 0;
        std::size_t last = 0;
        std::size_t parent = 0;  // below it in the stack; of the lowest: itself
        unsigned refused = 0;
        unsigned silent = 0;
        bool faulty = false;  // it was refused, or what it is a part of, and not the other part
        bool split = false;
        bool marred = false;  // a part of it was not taken
    };
    struct Run {
        plan::Trial trial;
        std::vector<Node> stack;
        Instant not_before = Instant::min();
        Instant since = Instant::min();  // the values beside it are to be read after this
        bus::Backoff patience;
        std::optional<Duration> aside;   // it was put off for so long
        std::optional<Instant> blocked;  // since then a value beside it is refused; stays when it was long
    };
    /// A single gap that was refused, and not often enough yet.
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
    static Run taken(Run& run);
    void add_run(Instant t, plan::Trial trial, std::vector<Run>& known);
    [[nodiscard]] static model::ItemRange range_of(const Run& run, const Node& node);
    [[nodiscard]] Area& area(const plan::Trial& trial);
    [[nodiscard]] bool ready(Instant t, Run& run, const Witness& witness);
    void go_round(Instant t, Run& run);
    [[nodiscard]] static bool active(const Run& run);
    static void split(Run& run, std::size_t node);
    static void close(Run& run, bool taken);
    void put_aside(Instant t, Run& run);
    void confirm(const plan::Trial& trial, const model::ItemRange& items);
    void on_gap_refused(Instant t, Run& run, std::uint8_t code);
    void give_up(Instant t, const plan::Trial& trial, std::uint8_t code, const Suspicion& suspicion);
    void on_whole_refused(Run& run, std::uint8_t code);
    void drop_finished();
    Suspicion& suspicion_of(Instant t, const plan::Trial& trial, const model::ItemRange& items);
    void tell(Lesson::Kind kind, const plan::Trial& trial, const model::ItemRange& items, std::uint8_t code);
    [[nodiscard]] Instant recheck_at(const Refused& refused) const;

    std::vector<Device> devices_;
    std::vector<Run> runs_;
    std::vector<Suspicion> suspicions_;
    std::vector<Lesson> lessons_;
    std::size_t cursor_ = 0;  // the run of the question
    bool waiting_ = false;
    bool changed_ = false;
    bool urgent_ = false;
    bool started_ = false;  // the times of what was refused count from the start
    Instant last_answer_ = Instant::min();
};

}  // namespace takt::poll
