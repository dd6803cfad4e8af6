#include "takt/endpoint/local_values.hpp"

#include "takt/line/loop.hpp"
#include "takt/value/project_slots.hpp"

namespace takt::endpoint {

LocalValues::LocalValues(const model::Project& project) : store_(value::slot_infos(project)) {}

Result<bool> LocalValues::set(value::SlotId local, const value::Value& value) {
    const value::Update update{local, value, value::Quality::good, value::Reason::ok};
    store_.apply(line::now(), {&update, 1});
    return false;
}

Result<bool> LocalValues::write(value::SlotId variable, const value::Value&,
                                std::function<void(const value::CommandOutcome&)>) {
    return fail(Code::timed_out, store_.info(variable).name);
}

}  // namespace takt::endpoint
