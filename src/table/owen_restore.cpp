// An entry has no names, and a table of owen-kc1 no bus times.
#include <string>
#include <vector>

#include "takt/plan/priced.hpp"
#include "takt/table/restore.hpp"

namespace takt::table {

Result<Restored> restored(const OwenView& table) {
    const std::size_t size = expanded_size(table);
    std::vector<std::uint8_t> bytes(size > kMaxImage ? 0 : size);  // expand() refuses the other ones
    TAKT_TRY(const Bytes image, expand(table, bytes));
    TAKT_TRY(const View view, View::open(image));
    Restored made{.project = project_of(view), .plan = {}};
    made.project.host = {};
    for (std::size_t i = 0; i < made.project.locals.size(); ++i)
        made.project.locals[i].name = "local" + std::to_string(i + 1);
    std::size_t place = made.project.locals.size();
    for (auto& line : made.project.lines)
        for (auto& device : line.devices)
            for (auto& variable : device.variables) variable.name = "value" + std::to_string(++place);
    auto plan = plan_of(view);
    for (std::size_t i = 0; i < plan.lines.size(); ++i)
        made.plan.lines.push_back(plan::priced(made.project, i, std::move(plan.lines[i].requests)));
    return made;
}

}  // namespace takt::table
