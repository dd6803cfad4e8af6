// Writes of strategy optimal.
//
// Written variables fall into classes that never share a request: coils, registers, and each register with
// bits; within a class, variables with equal causes. Inside a class a request is a chain of variables, each
// of which begins where the previous one ends. A sweep by address appends to every open chain a variable that
// begins at its end, as long as the limit allows.
// Invariant: without overlaps no solution has fewer chains. Closing a chain early costs one request and saves
// at most one later. The total number of bytes does not depend on the grouping.
#include "requests/write_pass.hpp"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <tuple>
#include <utility>

#include "timing/admission.hpp"

namespace takt::plan {
namespace {

using model::Variable;
using model::WriteSingle;
using wire::Function;

enum class WriteKind : std::uint8_t { coil, whole, bit };  // whole: registers

Function single_function(WriteKind kind) {
    return wire::write_function(kind == WriteKind::coil, true);
}

Function multiple_function(WriteKind kind) {
    return wire::write_function(kind == WriteKind::coil, false);
}

bool is_single(Function function) {
    return wire::properties(function).writes_single();
}

WriteKind kind_of(const Variable& v) {
    if (wire::counts_bits(*v.write)) return WriteKind::coil;
    return v.type == DataType::boolean ? WriteKind::bit : WriteKind::whole;
}

bool is_due(const Variable& v) {
    return v.used && v.write && (v.write_on_change || v.write_trigger);
}

/// The cause of a write. Only variables with equal causes may share a request.
using WriteCause = std::tuple<std::optional<model::LocalIndex>, bool, Duration, std::uint16_t>;

WriteCause cause_of(const model::Project& project, const Variable& v) {
    const auto admission = write_admission(project, v);
    return {v.write_trigger, v.write_on_change, admission ? admission->min_interval : Duration::zero(),
            admission ? admission->burst : std::uint16_t{0}};
}

struct WriteItem {
    std::size_t index = 0;
    WriteKind kind = WriteKind::whole;
    std::uint32_t start = 0;  // of bits: register and bit
    std::uint32_t end = 0;
    WriteCause due;
    bool alone = false;

    [[nodiscard]] std::uint32_t size() const { return end - start; }
};

/// The limits of a function for one request, and which of them is the tightest.
struct WriteLimit {
    std::uint32_t items = 0;
    const char* code = nullptr;
};

WriteLimit limit_of(const model::Project& project, const model::Line& line, const model::Device& device,
                    Function function) {
    const wire::FrameLimits limits = project.frame_limits();
    const auto protocol = static_cast<std::uint32_t>(wire::max_items(line.framing, function));
    const auto frame =
        static_cast<std::uint32_t>(wire::max_items(line.framing, function, {limits.frame_buffer, 0}));
    const auto profile = static_cast<std::uint32_t>(wire::max_items(line.framing, function, limits));
    if (device.registers_per_request_set && device.registers_per_request <= profile)
        return {device.registers_per_request, "plan.limit_setting"};
    return {profile, profile < frame    ? "plan.limit_profile"
                     : frame < protocol ? "plan.limit_frame"
                                        : "plan.limit_protocol"};
}

class WritePlanner {
public:
    WritePlanner(const model::Project& project, const model::Line& line, const model::Device& device)
        : project_(project), line_(line), device_(device) {}

    std::vector<Request> requests();

private:
    using Chain = std::vector<std::size_t>;  // indices into items_

    [[nodiscard]] bool stands_alone(const Variable& v, WriteKind kind) const;
    void collect();
    void group(std::size_t first, std::size_t last);
    void chain(const Chain& members);
    void share_register(const Chain& members);
    [[nodiscard]] Request request(const Chain& chain) const;
    [[nodiscard]] Function function_of(const Chain& chain) const;
    [[nodiscard]] Reason why(const Chain& chain, Function function) const;
    [[nodiscard]] Reason between(const Chain& chain, const WriteItem& next) const;
    [[nodiscard]] const Variable& variable(const WriteItem& item) const {
        return device_.variables[item.index];
    }

    const model::Project& project_;
    const model::Line& line_;
    const model::Device& device_;
    std::vector<WriteItem> items_;  // by kind and address
    std::vector<Chain> chains_;
};

bool WritePlanner::stands_alone(const Variable& v, WriteKind kind) const {
    if (kind == WriteKind::bit) return false;
    if (device_.write_single == WriteSingle::only) return true;
    return device_.write_single == WriteSingle::as_declared && is_single(*v.write);
}

void WritePlanner::collect() {
    for (std::size_t i = 0; i < device_.variables.size(); ++i) {
        const Variable& v = device_.variables[i];
        if (!is_due(v)) continue;
        WriteItem item{.index = i, .kind = kind_of(v)};
        if (item.kind == WriteKind::bit && !device_.fc22 && !device_.read_modify_write) continue;
        item.start = item.kind == WriteKind::bit ? v.register_number * 16U + v.bit.value_or(0) : v.start();
        item.end = item.start + (item.kind == WriteKind::bit ? 1U : v.items());
        item.due = cause_of(project_, v);
        item.alone = stands_alone(v, item.kind);
        items_.push_back(std::move(item));
    }
    std::sort(items_.begin(), items_.end(), [this](const WriteItem& a, const WriteItem& b) {
        const auto key = [this](const WriteItem& item) {
            return std::tie(item.kind, item.start, item.end, item.due, item.alone, variable(item).name,
                            item.index);
        };
        return key(a) < key(b);
    });
}

std::vector<Request> WritePlanner::requests() {
    collect();
    std::map<std::tuple<WriteKind, std::uint32_t, WriteCause>, Chain> classes;
    for (std::size_t i = 0; i < items_.size(); ++i) {
        const WriteItem& item = items_[i];
        const std::uint32_t register_number = item.kind == WriteKind::bit ? item.start / 16 : 0;
        if (item.alone)
            chains_.push_back({i});
        else
            classes[{item.kind, register_number, item.due}].push_back(i);
    }
    for (const auto& [key, members] : classes)
        std::get<WriteKind>(key) == WriteKind::bit ? share_register(members) : chain(members);
    std::vector<Request> made;
    made.reserve(chains_.size());
    for (const Chain& chain : chains_) made.push_back(request(chain));
    std::sort(made.begin(), made.end(), [this](const Request& a, const Request& b) {
        const auto key = [this](const Request& r) {
            return std::tie(*r.write, r.start, r.quantity, device_.variables[r.variables.front()].name);
        };
        return key(a) < key(b);
    });
    return made;
}

// Longer values first: a chain that fits a longer value also fits a shorter one, but not the reverse.
void WritePlanner::chain(const Chain& members) {
    const std::uint32_t most =
        limit_of(project_, line_, device_, multiple_function(items_[members[0]].kind)).items;
    using Open = std::set<std::pair<std::uint32_t, std::size_t>>;  // size, chain
    std::map<std::uint32_t, Open> open;                            // by the end
    for (std::size_t first = 0; first < members.size();) {
        const std::uint32_t start = items_[members[first]].start;
        std::size_t last = first;
        while (last < members.size() && items_[members[last]].start == start) ++last;
        open.erase(open.begin(), open.lower_bound(start));
        Open here = open.contains(start) ? std::move(open[start]) : Open{};
        for (std::size_t i = last; i-- > first;) {
            const WriteItem& item = items_[members[i]];
            auto fits = here.end();
            if (item.size() < most) {
                fits = here.lower_bound({most - item.size() + 1, 0});
                fits = fits == here.begin() ? here.end() : std::prev(fits);
            }
            std::pair<std::uint32_t, std::size_t> grown{item.size(), chains_.size()};
            if (fits == here.end()) {
                chains_.emplace_back();
            } else {
                grown = {fits->first + item.size(), fits->second};
                here.erase(fits);
            }
            chains_[grown.second].push_back(members[i]);
            open[item.end].insert(grown);
        }
        first = last;
    }
}

// Two variables of the same bit need two requests.
void WritePlanner::share_register(const Chain& members) {
    const std::size_t own = chains_.size();
    std::uint32_t bit = std::numeric_limits<std::uint32_t>::max();
    std::size_t round = 0;
    for (const std::size_t member : members) {
        round = items_[member].start == bit ? round + 1 : 0;
        bit = items_[member].start;
        if (own + round == chains_.size()) chains_.emplace_back();
        chains_[own + round].push_back(member);
    }
}

Request WritePlanner::request(const Chain& chain) const {
    const WriteItem& first = items_[chain.front()];
    const Variable& v = variable(first);
    Request made;
    for (const std::size_t member : chain) made.variables.push_back(items_[member].index);
    made.write = function_of(chain);
    made.start = static_cast<std::uint16_t>(first.kind == WriteKind::bit ? v.register_number : first.start);
    made.quantity = static_cast<std::uint16_t>(
        first.kind == WriteKind::bit ? 1U : items_[chain.back()].end - first.start);
    made.write_trigger = v.write_trigger;
    made.write_on_change = v.write_on_change;
    made.admission = write_admission(project_, v);
    made.status = v.status;
    for (const std::size_t member : chain)
        if (variable(items_[member]).status != made.status) made.status.reset();
    settle_bit_write(made, device_);
    made.why = why(chain, *made.write);
    return made;
}

Function WritePlanner::function_of(const Chain& chain) const {
    const WriteItem& first = items_[chain.front()];
    const Function declared = *variable(first).write;
    if (first.kind == WriteKind::bit) return declared;
    const bool one_item = chain.size() == 1 && first.size() == 1;
    switch (device_.write_single) {
        case WriteSingle::as_declared: return declared;
        case WriteSingle::never: return multiple_function(first.kind);
        case WriteSingle::only:
        case WriteSingle::allowed: break;
    }
    return one_item ? single_function(first.kind) : multiple_function(first.kind);
}

Reason WritePlanner::why(const Chain& chain, Function function) const {
    const WriteItem& last = items_[chain.back()];
    if (last.alone && is_single(function))
        return {"plan.single_function",
                {{"function", function == Function::write_single_coil ? "0x05" : "0x06"}}};
    const std::size_t next = chain.back() + 1;
    if (next == items_.size() || items_[next].kind != last.kind)
        return {"plan.last", {{"variable", variable(last).name}}};
    return between(chain, items_[next]);
}

Reason WritePlanner::between(const Chain& chain, const WriteItem& next) const {
    const WriteItem& last = items_[chain.back()];
    std::vector<std::pair<std::string, std::string>> names{{"previous", variable(last).name},
                                                           {"next", variable(next).name}};
    if (next.start < last.end) return {"plan.overlap", std::move(names)};
    if (last.kind == WriteKind::bit && next.start / 16 != last.start / 16)
        return {"plan.other_register", std::move(names)};
    if (next.start > last.end && last.kind != WriteKind::bit) {
        names.emplace_back("size", std::to_string(next.start - last.end));
        return {last.kind == WriteKind::coil ? "plan.gap_bits" : "plan.gap", std::move(names)};
    }
    if (std::get<0>(next.due) != std::get<0>(last.due)) return {"plan.other_trigger", std::move(names)};
    if (std::get<1>(next.due) != std::get<1>(last.due)) return {"plan.other_write", std::move(names)};
    if (next.due != last.due) return {"plan.other_admission", std::move(names)};
    if (next.alone)
        return {"plan.single_function", {{"function", last.kind == WriteKind::coil ? "0x05" : "0x06"}}};
    const WriteLimit limit = limit_of(project_, line_, device_, multiple_function(last.kind));
    const std::uint32_t size = next.end - items_[chain.front()].start;
    if (size <= limit.items)
        return {"plan.overlap", std::move(names)};  // overlapping variables took the earlier chains
    return {limit.code,
            {{"next", variable(next).name},
             {"size", std::to_string(size)},
             {"limit", std::to_string(limit.items)}}};
}

}  // namespace

std::vector<Request> write_requests(const model::Project& project, const model::Line& line,
                                    const model::Device& device) {
    return WritePlanner(project, line, device).requests();
}

std::vector<Request> bit_write_requests(const model::Project& project, const model::Device& device) {
    std::vector<Request> made;
    if (!device.fc22 && !device.read_modify_write) return made;
    for (std::size_t i = 0; i < device.variables.size(); ++i) {
        const Variable& v = device.variables[i];
        if (!is_due(v) || kind_of(v) != WriteKind::bit) continue;
        Request& request = made.emplace_back();
        request.variables.push_back(i);
        request.write = v.write;
        request.start = v.start();
        request.quantity = 1;
        request.write_trigger = v.write_trigger;
        request.write_on_change = v.write_on_change;
        request.admission = write_admission(project, v);
        request.status = v.status;
        request.why = {"plan.bit_alone", {{"variable", v.name}}};
        settle_bit_write(request, device);
    }
    return made;
}

void settle_bit_write(Request& request, const model::Device& device) {
    if (!request.write || request.variables.empty()) return;
    const auto is_bit = [&](std::size_t index) {
        const Variable& v = device.variables[index];
        return v.write && kind_of(v) == WriteKind::bit;
    };
    if (!std::all_of(request.variables.begin(), request.variables.end(), is_bit)) return;
    if (device.fc22) {
        request.write = Function::mask_write_register;
        return;
    }
    if (!device.read_modify_write) return;
    request.read_modify_write = true;
    const auto declared_multiple = [&](std::size_t index) {
        return device.variables[index].write == Function::write_multiple_registers;
    };
    const bool multiple =
        device.write_single == WriteSingle::never ||
        (device.write_single == WriteSingle::as_declared &&
         std::all_of(request.variables.begin(), request.variables.end(), declared_multiple));
    request.write = wire::write_function(false, !multiple);
}

}  // namespace takt::plan
