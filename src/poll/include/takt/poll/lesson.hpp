// What trying a device's gaps has shown (gaps: learn).
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "takt/model/project.hpp"

namespace takt::poll {

/// Something that was learnt: a piece of news.
struct Lesson {
    enum class Kind : std::uint8_t {
        confirmed,  ///< the items were read together
        refused,    ///< the device refuses the items: they are given up
        too_long,   ///< a read of all the items is refused, though each part of it is read
        doubted,    ///< the items were confirmed, and are refused now: tried anew
    };
    Kind kind = Kind::confirmed;
    std::size_t device = 0;  ///< index in its line
    wire::Function read = wire::Function::read_holding_registers;
    model::ItemRange items;
    std::uint8_t exception = 0;  ///< the device's code; 0: none
};
std::string_view name(Lesson::Kind kind);

/// Makes the plans of lines that learn, elsewhere, so that planning never delays a line.
class PlanMaker {
public:
    /// A plan is wanted (plan::learning_plan()), to be given to LinePoller::replace_plan() later, not from
    /// inside this call. Not called again before that. On the poller's thread; must not block.
    virtual void want_plan(std::size_t line, std::vector<model::Learnt> learnt) = 0;

protected:
    ~PlanMaker() = default;
};

}  // namespace takt::poll
