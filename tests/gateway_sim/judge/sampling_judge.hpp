// Whether the samples are what the values did.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "../clock.hpp"
#include "../complaints.hpp"
#include "../scenario.hpp"
#include "account.hpp"
#include "takt/host/event.hpp"

namespace takt::gatewaysim {

/// Follows the changes of the values with a session of its own, which loses none, and compares the samples
/// with them by the settings of the output.
class SamplingJudge {
public:
    SamplingJudge(const Clock& clock, const Scenario& scenario, Complaints& complaints);

    void on_run_begin();
    void on_event(const host::Event& event);
    /// The sampler begins a step, with this wall clock, and has ended it.
    void before_sampling() { offsets_.insert(clock_.wall_offset_ns); }
    void after_sampling();
    void on_unit(const Unit& unit);

private:
    /// A change of a value that no sample has passed yet.
    struct Change {
        Instant t;
        host::ValueChanged what;
    };
    struct Loss {
        std::int64_t first_wall_ns = 0;
        std::int64_t last_wall_ns = 0;
    };
    struct Selected {
        model::SamplingPolicy policy;
        std::deque<Change> changes;
        std::optional<host::ValueChanged> state;      // after the changes that were passed
        std::optional<host::ValueChanged> delivered;  // that of the last sample
        std::deque<Loss> losses;                      // since the last sample
        Instant last_sample{};                        // when it entered the output
        Instant last_period{};                        // likewise, of those with this cause
    };

    void on_sample(const publish::Series& series, const publish::Sample& sample);
    [[nodiscard]] std::size_t first_match(const Selected& selected, const publish::Sample& sample) const;
    [[nodiscard]] std::size_t last_match(const Selected& selected, const publish::Sample& sample) const;
    [[nodiscard]] static bool shows_state(const Selected& selected, const publish::Series& series,
                                          const publish::Sample& sample);
    [[nodiscard]] bool is_at(const Change& change, const publish::Sample& sample) const;
    void pass(Selected& selected, const std::string& variable, std::size_t changes);
    [[nodiscard]] bool needs_sample(const Selected& selected, const host::ValueChanged& change) const;
    [[nodiscard]] bool is_lost(const Selected& selected, Instant t) const;
    [[nodiscard]] bool is_wall_time(Instant t, std::int64_t wall_ns) const;

    const Clock& clock_;
    Complaints& complaints_;
    std::map<std::string, Selected> selected_;    // by variable
    std::map<std::uint32_t, std::string> names_;  // of selected slots
    std::set<std::int64_t> offsets_;              // that the clock had in this run
};

}  // namespace takt::gatewaysim
