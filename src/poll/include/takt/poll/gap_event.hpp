// Results of learning which gaps of a device may be read (gaps: learn).
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "takt/model/project.hpp"

namespace takt::poll {

/// A change of what is known about a range of items.
struct GapEvent {
    enum class Kind : std::uint8_t {
        confirmed,  ///< the items were read together
        refused,    ///< the device refuses the items: they are not read any more
        too_long,   ///< the device refuses a read of all the items, but not of its parts
        doubted,    ///< confirmed items are refused now: they are unconfirmed again
    };
    Kind kind = Kind::confirmed;
    std::size_t device = 0;  ///< index in its line
    wire::Function read = wire::Function::read_holding_registers;
    model::ItemRange items;
    std::uint8_t exception = 0;  ///< the device's code; 0: none
};
std::string_view name(GapEvent::Kind kind);

/// Makes new plans for lines that learn, on another thread: planning must not delay a line.
class PlanMaker {
public:
    /// Requests a plan (plan::learning_plan()), to be passed to LinePoller::replace_plan() after this call
    /// has returned. Not called again before that. On the poller's thread; must not block.
    virtual void want_plan(std::size_t line, std::vector<model::Learnt> learnt) = 0;

protected:
    ~PlanMaker() = default;
};

}  // namespace takt::poll
