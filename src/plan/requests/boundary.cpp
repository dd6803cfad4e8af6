#include "requests/boundary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include "takt/plan/learning.hpp"

namespace takt::plan {
namespace {

using model::Variable;
using wire::Function;

using Arguments = std::vector<std::pair<std::string, std::string>>;

Reason reason(const char* code, const Neighbours& at, Arguments more = {}) {
    Arguments arguments{{"previous", at.previous.name}, {"next", at.next.name}};
    std::move(more.begin(), more.end(), std::back_inserter(arguments));
    return {code, std::move(arguments)};
}

std::string hexadecimal(Function function) {
    return fmt::format("0x{:02X}", static_cast<unsigned>(function));
}

std::string milliseconds(Duration period) {
    return fmt::format("{}", std::chrono::duration<double, std::milli>(period).count());
}

std::optional<Reason> function_boundary(Pass pass, const Neighbours& at) {
    const Function previous = *function_in(pass, at.previous);
    const Function next = *function_in(pass, at.next);
    if (previous != next)
        return reason("plan.other_function", at,
                      {{"previous_function", hexadecimal(previous)}, {"next_function", hexadecimal(next)}});
    if (wire::properties(next).writes_single())
        return Reason{"plan.single_function", {{"function", hexadecimal(next)}}};
    return std::nullopt;
}

// Rule 4: the sign of an integer is only a reading of it, and 2-register integers and floats are one kind.
DataType kind(DataType type) {
    switch (type) {
        case DataType::uint16: return DataType::int16;
        case DataType::uint32:
        case DataType::float32: return DataType::int32;
        case DataType::uint64: return DataType::int64;
        default: return type;
    }
}

std::optional<Reason> type_boundary(const Neighbours& at) {
    const auto& [previous, next, numbers_adjoin] = at;
    if (kind(previous.type) != kind(next.type))
        return reason("plan.other_type", at,
                      {{"previous_type", std::string(name(previous.type))},
                       {"next_type", std::string(name(next.type))}});
    if (previous.registers != next.registers)
        return reason("plan.other_length", at,
                      {{"previous_registers", std::to_string(previous.registers)},
                       {"next_registers", std::to_string(next.registers)}});
    return std::nullopt;
}

std::optional<Reason> address_boundary(const Neighbours& at) {
    const auto& [previous, next, numbers_adjoin] = at;
    const bool bits = next.type == DataType::boolean;
    if (bits && previous.register_number != next.register_number) return reason("plan.other_register", at);
    const int end = bits ? previous.bit.value_or(0) + 1 : previous.register_number + previous.registers;
    const int start = bits ? int{next.bit.value_or(0)} : int{next.register_number};
    if (start > end)
        return reason(bits ? "plan.gap_bits" : "plan.gap", at, {{"size", std::to_string(start - end)}});
    if (start < end) return reason("plan.overlap", at);
    return std::nullopt;
}

std::optional<Reason> settings_boundary(Pass pass, const Neighbours& at) {
    const auto& [previous, next, numbers_adjoin] = at;
    if (previous.period != next.period)
        return reason(
            "plan.other_period", at,
            {{"previous_ms", milliseconds(previous.period)}, {"next_ms", milliseconds(next.period)}});
    if (previous.status != next.status) return reason("plan.other_status", at);
    const bool same_trigger = pass == Pass::read ? previous.read_trigger == next.read_trigger
                                                 : previous.write_trigger == next.write_trigger;
    if (!same_trigger) return reason("plan.other_trigger", at);
    if (pass == Pass::write && previous.write_on_change != next.write_on_change)
        return reason("plan.other_write", at);
    return std::nullopt;
}

// Returns 0 if longer reads were not refused. A value longer than the limit is still read in one request.
std::size_t learnt_limit(const model::Device& device, Function function) {
    if (!wire::properties(function).only_reads_items()) return 0;
    std::size_t limit = device.learnt.most_items[static_cast<std::size_t>(area_of(function))];
    if (limit == 0) return 0;
    for (const Variable& v : device.variables)
        if (v.used && v.read == function) limit = std::max<std::size_t>(limit, v.items());
    return limit;
}

}  // namespace

const std::optional<Function>& function_in(Pass pass, const Variable& variable) {
    return pass == Pass::read ? variable.read : variable.write;
}

// The checks follow the order in which a user would remove the obstacles.
std::optional<Reason> boundary(Pass pass, const Neighbours& neighbours) {
    if (auto found = function_boundary(pass, neighbours)) return found;
    if (auto found = type_boundary(neighbours)) return found;
    if (auto found = address_boundary(neighbours)) return found;
    if (auto found = settings_boundary(pass, neighbours)) return found;
    if (!neighbours.numbers_adjoin) return reason("plan.order_conflict", neighbours);
    return std::nullopt;
}

ItemLimit::ItemLimit(const model::Project& project, const model::Line& line, const model::Device& device,
                     Function function, model::Strategy strategy) {
    const wire::FrameLimits limits = project.frame_limits();
    const std::size_t protocol = wire::max_items(line.framing, function);
    const std::size_t frame = wire::max_items(line.framing, function, {limits.frame_buffer, 0});
    const std::size_t profile = wire::max_items(line.framing, function, limits);
    const bool setting = strategy != model::Strategy::optimal || device.registers_per_request_set;
    items_ = setting ? std::min<std::size_t>(profile, device.registers_per_request) : profile;
    code_ = setting && items_ == device.registers_per_request ? "plan.limit_setting"
            : profile < frame                                 ? "plan.limit_profile"
            : frame < protocol                                ? "plan.limit_frame"
                                                              : "plan.limit_protocol";
    if (strategy != model::Strategy::optimal || device.gaps != model::Gaps::learn) return;
    const std::size_t learnt = learnt_limit(device, function);
    if (learnt == 0 || learnt >= items_) return;
    items_ = learnt;
    code_ = "plan.limit_learnt";
}

Reason ItemLimit::reason(std::size_t size, const Variable& next) const {
    return {code_, {{"next", next.name}, {"size", std::to_string(size)}, {"limit", std::to_string(items_)}}};
}

}  // namespace takt::plan
