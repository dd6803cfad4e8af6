// Items of a device that are read again and again, in the requests that the planner makes of them.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "takt/base/result.hpp"
#include "takt/client/client.hpp"
#include "takt/client/options.hpp"
#include "takt/model/project.hpp"
#include "takt/plan/plan.hpp"
#include "takt/value/codec.hpp"

namespace takt::client {

/// Values of one area.
struct WatchedRange {
    wire::Area area = wire::Area::holding_register;
    std::uint16_t start = 0;
    std::uint32_t count = 1;
    /// Of registers; nothing: as the layout of the watch.
    std::optional<DataType> type = {};
    std::optional<ByteOrder> order = {};
};

struct WatchSpec {
    std::vector<WatchedRange> ranges;
    value::Layout layout{.type = DataType::uint16};  ///< of the values in areas of registers
    Duration period = std::chrono::seconds(1);
    /// Names a value by its first item. A range with a type of its own has it behind the name.
    std::function<std::string(wire::Area area, std::uint32_t address)> name;
};

/// Values that one watch may have.
inline constexpr std::size_t kMaxWatched = 4096;

/// A project of that one device; its variables in the order of the ranges, each item once in each type and
/// order.
/// @returns out_of_range, too_long; the errors of line::parse_target()
[[nodiscard]] Result<model::Project> watch_project(const Options& options, const WatchSpec& spec);

/// Sends one request of the plan of such a project.
/// @param variables  of its device
/// @returns the values of request.variables, in their order; what Client::ask() and value::decode() return
[[nodiscard]] Result<std::vector<value::Value>> read_variables(Client& client, const plan::Request& request,
                                                               std::span<const model::Variable> variables);

}  // namespace takt::client
