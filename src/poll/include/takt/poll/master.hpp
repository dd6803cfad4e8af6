// All lines of a project and their values.
#pragma once

#include <cstddef>
#include <deque>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <vector>

#include "takt/base/result.hpp"
#include "takt/model/project.hpp"
#include "takt/plan/plan.hpp"
#include "takt/poll/line_poller.hpp"
#include "takt/value/command.hpp"
#include "takt/value/project_slots.hpp"
#include "takt/value/store.hpp"

namespace takt::poll {

/// The initial value of a slot, kept from the last run of the project.
struct Restored {
    value::SlotId slot;
    value::Value value;   ///< of the slot's type; std::monostate: none
    value::Value wanted;  ///< what it was last set to; std::monostate: nothing
};

/// The slots of a project and a LinePoller for each of its lines.
///
/// After set() and write() the driver must call transmit() and next_wakeup() of the lines in concerned(). The
/// cost of a call does not depend on the number of lines. One owner, one thread; project and plan must
/// outlive it.
class Master {
public:
    struct Options {
        wire::TrafficObserver* traffic = nullptr;  ///< of every line; see also `line_traffic`
        PollObserver* observer = nullptr;
        std::vector<wire::TrafficObserver*> line_traffic;  ///< by line, before `traffic`; may be shorter
        std::vector<std::optional<bus::LineConfig>>
            line_bus;  ///< by line, instead of line_config(); may be shorter
        /// Locals start with these values; variables too, with quality uncertain until they are read. A
        /// restored wanted value causes no write: a restart is not a change. Values that do not fit are
        /// ignored.
        std::vector<Restored> restored;
        Instant restored_at;              ///< when that is
        bool learn = true;                ///< LinePoller::Options
        bool distinct_reads = true;       ///< likewise
        PlanMaker* plan_maker = nullptr;  ///< likewise
    };

    Master(const model::Project& project, const plan::Plan& plan, const Options& options);
    Master(const model::Project& project, const plan::Plan& plan);

    [[nodiscard]] std::size_t line_count() const { return lines_.size(); }
    [[nodiscard]] LinePoller& line(std::size_t index) { return *lines_[index]; }
    [[nodiscard]] const LinePoller& line(std::size_t index) const { return *lines_[index]; }
    [[nodiscard]] value::Store& store() { return store_; }
    [[nodiscard]] const value::Store& store() const { return store_; }
    [[nodiscard]] const value::ProjectSlots& slots() const { return slots_; }

    /// Sets a local, or the wanted value of a variable (LinePoller::set). @returns whether it was rounded
    [[nodiscard]] Result<bool> set(Instant t, value::SlotId slot, const value::Value& value);

    /// Writes a variable to its device now (LinePoller::write). A local is set; it has an outcome too.
    [[nodiscard]] Result<bool> write(Instant t, const value::WriteCommand& command);

    /// The lines that a change of that slot affects, ascending: the line of a variable, or the lines whose
    /// triggers and enables use a local.
    [[nodiscard]] std::span<const std::size_t> concerned(value::SlotId slot) const;

    /// Takes over the values of all slots that `old` has too, by name, type and scaling. First step of
    /// applying another project; then each line that continues a line of `old` takes it over
    /// (LinePoller::take_over()). A restored value stays where `old` has the slot, but it was neither read
    /// well nor set there.
    /// @returns the slots whose restored value stays
    std::set<value::SlotId> take_over_values(const Master& old);

    /// The next outcome of any line.
    [[nodiscard]] std::optional<value::CommandOutcome> take_outcome();

private:
    void restore(const model::Project& project, const Options& options);
    Result<bool> set_local(Instant t, model::LocalIndex local, const value::Value& value);
    void note_locals(const model::Project& project);

    /// A line with outcomes outstanding.
    struct Awaited {
        std::size_t line = 0;
        std::size_t commands = 0;
    };

    value::ProjectSlots slots_;
    value::Store store_;
    std::vector<std::unique_ptr<LinePoller>> lines_;
    std::vector<std::size_t> every_line_;             // 0, 1, …: concerned() points into it
    std::vector<std::vector<std::size_t>> of_local_;  // by local: the lines it concerns
    std::set<value::SlotId> restored_;                // until values are taken over
    std::deque<value::CommandOutcome> local_outcomes_;
    std::vector<Awaited> awaited_;
};

}  // namespace takt::poll
