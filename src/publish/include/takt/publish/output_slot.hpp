// The slots of what an output concerns.
#pragma once

#include <variant>

#include "takt/model/output.hpp"
#include "takt/value/project_slots.hpp"

namespace takt::publish {

/// The slot of a value that an output selects or a command may write.
[[nodiscard]] inline value::SlotId slot_of(const value::ProjectSlots& slots,
                                           const model::OutputSubject& subject) {
    if (const auto* const local = std::get_if<model::LocalIndex>(&subject)) return slots.local(*local);
    const auto& polled = std::get<model::PolledIndex>(subject);
    return slots.variable({polled.line, polled.device, polled.variable});
}

}  // namespace takt::publish
