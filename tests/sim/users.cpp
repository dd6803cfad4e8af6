#include "users.hpp"

#include <bit>

namespace takt::simtest {
namespace {

using namespace std::chrono_literals;

bool is_trigger(const model::Project& project, model::LocalIndex local) {
    for (const auto& line : project.lines)
        for (const auto& device : line.devices)
            for (const auto& variable : device.variables)
                if (variable.read_trigger == local || variable.write_trigger == local) return true;
    return false;
}

bool is_enable(const model::Project& project, model::LocalIndex local) {
    for (const auto& line : project.lines)
        for (const auto& device : line.devices)
            if (device.poll_enable == local) return true;
    return false;
}

}  // namespace

Users::Users(std::uint64_t seed, const model::Project& project, const value::ProjectSlots& slots,
             Instant quiet_from)
    : random_(sim::Random(seed).fork(0x55)), quiet_from_(quiet_from) {
    for (std::size_t l = 0; l < project.lines.size(); ++l)
        for (std::size_t d = 0; d < project.lines[l].devices.size(); ++d) {
            const auto& variables = project.lines[l].devices[d].variables;
            for (std::size_t v = 0; v < variables.size(); ++v)
                if (variables[v].write && variables[v].used)
                    writables_.push_back({slots.variable({l, d, v}), &variables[v]});
        }
    for (std::size_t i = 0; i < project.locals.size(); ++i) {
        const bool enables = is_enable(project, i);
        if (!enables && !is_trigger(project, i)) continue;
        const auto& initial = project.locals[i].default_value;
        switches_.push_back({slots.local(i), initial && initial->integer != 0, enables});
    }
    constexpr std::array kMeans{300ms, 1000ms, 3000ms, 10000ms};
    mean_ = kMeans[random_.below(kMeans.size())];
    bursts_ = random_.below(10) == 0;
    never_pause_ = sim::Random(seed).fork(0xF100D).below(8) == 0;
    next_ = writables_.empty() && switches_.empty() ? kNever : Instant{} + random_.between(0ms, 2 * mean_);
}

void Users::plan_next(Instant t) {
    next_ = t + (never_pause_ ? 25ms : random_.between(1ms, 2 * mean_));
    if (next_ < quiet_from_) return;
    next_ = put_right_ ? kNever : quiet_from_;
}

value::Value Users::draw_value(const model::Variable& variable) {
    const std::uint64_t bits = random_.next();
    const auto registers = static_cast<unsigned>(variable.registers);
    switch (variable.type) {
        case DataType::boolean: return (bits & 1U) != 0;
        case DataType::string: {
            std::string text;
            for (unsigned i = 0; i < 2 * registers; ++i)
                text += static_cast<char>('a' + (bits >> (5 * i)) % 26);
            return text;
        }
        case DataType::float32: {
            const double number =
                static_cast<double>(static_cast<float>(static_cast<std::int32_t>(bits)) / 64);
            return variable.scaled() ? number * variable.scale + variable.offset : number;
        }
        case DataType::float64: return static_cast<double>(static_cast<std::int64_t>(bits)) / 1024;
        default: break;
    }
    const bool is_signed = variable.type == DataType::int16 || variable.type == DataType::int32 ||
                           variable.type == DataType::int64;
    const unsigned unused = 64 - 16 * registers;
    const auto raw = static_cast<std::int64_t>(bits << unused) >> unused;
    const std::uint64_t natural = bits << unused >> unused;
    if (variable.scaled()) {
        // Within the precision of a double.
        const auto small = is_signed ? static_cast<double>(raw % (std::int64_t{1} << 40))
                                     : static_cast<double>(natural % (std::uint64_t{1} << 40));
        return small * variable.scale + variable.offset;
    }
    return is_signed ? value::Value(raw) : value::Value(natural);
}

Action Users::draw_write(Instant t) {
    const auto& chosen = writables_[random_.below(static_cast<std::uint32_t>(writables_.size()))];
    const bool sets = (chosen.model->write_on_change || chosen.model->write_trigger) && random_.below(2) == 0;
    Action action{sets ? Action::Kind::set : Action::Kind::command, chosen.slot, draw_value(*chosen.model)};
    if (random_.below(3) == 0) action.expires = t + random_.between(0ms, 5s);
    return action;
}

void Users::toggle(std::vector<Action>& actions, std::size_t index, bool on) {
    auto& chosen = switches_[index];
    chosen.on = on;
    actions.push_back({Action::Kind::local, chosen.slot, on});
}

std::vector<Action> Users::act() {
    const Instant t = next_;
    std::vector<Action> actions;
    if (t >= quiet_from_) {
        for (std::size_t i = 0; i < switches_.size(); ++i)
            if (switches_[i].enables && !switches_[i].on) toggle(actions, i, true);
        put_right_ = true;
        next_ = kNever;
        return actions;
    }
    const auto kind = random_.below(10);
    if (!switches_.empty() && (writables_.empty() || kind < 4)) {
        const auto index = random_.below(static_cast<std::uint32_t>(switches_.size()));
        const bool on = switches_[index].on;
        // Switches are mostly on.
        if (!switches_[index].enables || !on || random_.below(4) == 0) toggle(actions, index, !on);
    } else if (!writables_.empty()) {
        auto count = 1 + (random_.below(4) == 0 ? random_.below(6) : 0);
        if (bursts_ && random_.below(20) == 0) count = 300;
        for (std::uint32_t i = 0; i < count; ++i) actions.push_back(draw_write(t));
    }
    plan_next(t);
    return actions;
}

}  // namespace takt::simtest
