// Scripted users: they set, write, pull triggers and switch devices, by a seed.
#pragma once

#include <optional>
#include <vector>

#include "takt/model/project.hpp"
#include "takt/sim/random.hpp"
#include "takt/value/command.hpp"
#include "takt/value/project_slots.hpp"

namespace takt::simtest {

/// The actions of a user at one moment.
struct Action {
    enum class Kind : std::uint8_t { set, command, local };
    Kind kind = Kind::set;
    value::SlotId slot;
    value::Value value;
    Instant expires = kNever;
};

class Users {
public:
    /// @param quiet_from  from then on they only put everything right
    Users(std::uint64_t seed, const model::Project& project, const value::ProjectSlots& slots,
          Instant quiet_from);

    [[nodiscard]] Instant next() const { return next_; }
    /// Their actions at next(). next() is later afterwards.
    [[nodiscard]] std::vector<Action> act();

private:
    struct Writable {
        value::SlotId slot;
        const model::Variable* model = nullptr;
    };
    struct Switch {
        value::SlotId slot;
        bool on = false;
        bool enables = false;  // a poll-enable variable, else a trigger
    };
    void plan_next(Instant t);
    void toggle(std::vector<Action>& actions, std::size_t index, bool on);
    [[nodiscard]] value::Value draw_value(const model::Variable& variable);
    [[nodiscard]] Action draw_write(Instant t);

    sim::Random random_;
    Instant quiet_from_;
    std::vector<Writable> writables_;
    std::vector<Switch> switches_;
    Duration mean_;
    bool bursts_ = false;
    bool never_pause_ = false;
    Instant next_;
    bool put_right_ = false;
};

}  // namespace takt::simtest
