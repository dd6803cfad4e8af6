// Runs the poller of a project and the executor of its request table on simulated lines, and compares them.
#pragma once

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include <variant>

#include "support.hpp"
#include "takt/poll/master.hpp"
#include "takt/sim/simulated_line.hpp"
#include "takt/table/build.hpp"
#include "takt/table/executor.hpp"
#include "takt/value/codec.hpp"

namespace takt::sim {
namespace table_test {

using namespace std::chrono_literals;
using wire::Area;
using wire::Function;

/// Events on a running line from outside.
struct Set {
    std::string name;
    value::Value value;
};
struct Behave {
    std::size_t device;
    bool dead = false;
    std::optional<wire::ExceptionCode> refuses;
};
struct Link {
    bool up;
};
struct Happening {
    Duration at;
    std::variant<Set, Behave, Link> what;
};
using Script = std::vector<Happening>;

/// A side: a line with its master of any kind.
class Side {
public:
    virtual ~Side() = default;
    virtual Engine& engine() = 0;
    virtual void set(Instant t, const Set& set) = 0;
};

class PolledSide final : public Side {
public:
    // Only planned requests are in a table.
    PolledSide(const model::Project& project, const plan::Plan& plan)
        : master_(project, plan, {.distinct_reads = false}) {}
    Engine& engine() override { return master_.line(0); }
    void set(Instant t, const Set& set) override {
        EXPECT_TRUE(master_.set(t, *master_.store().find(set.name), set.value)) << set.name;
    }
    [[nodiscard]] std::int64_t number(const std::string& name) const {
        return std::get<std::int64_t>(master_.store()[*master_.store().find(name)].value);
    }

private:
    poll::Master master_;
};

class TableSide final : public Side {
public:
    explicit TableSide(table::Image image)
        : image_(std::move(image)),
          view_(table::View::open(image_).value()),
          values_(view_.header().value_words),
          read_(view_.header().write_words),
          wanted_(view_.header().write_words),
          items_(view_.item_count()),
          entries_(view_.entry_count()),
          devices_(view_.device_count()) {
        table::initialise(view_, memory());
        executor_.emplace(view_, 0, memory(), table::Workspace{entries_, devices_});
    }
    static std::unique_ptr<TableSide> of_project(const model::Project& project, table::Image image) {
        auto side = std::make_unique<TableSide>(std::move(image));
        for (const auto& local : project.locals) side->names_.push_back(local.name);
        for (const auto& device : project.lines[0].devices)
            for (const auto& variable : device.variables) side->names_.push_back(variable.name);
        return side;
    }
    // A table of a controller has neither names nor defaults of locals, and its own order of variables.
    static std::unique_ptr<TableSide> of_controller(const model::Project& project, table::Image image) {
        auto side = std::make_unique<TableSide>(std::move(image));
        for (const auto& local : project.locals) side->names_.push_back(local.name);
        for (auto i = static_cast<std::uint32_t>(project.locals.size()); i < side->view_.item_count(); ++i)
            for (const auto& device : project.lines[0].devices)
                for (const auto& variable : device.variables)
                    if (is_at(side->view_, i, device, variable)) side->names_.push_back(variable.name);
        for (std::uint32_t i = 0; i < project.locals.size(); ++i)
            if (project.locals[i].default_value) side->values_[side->view_.item(i).place] = 1;
        side->executor_.emplace(side->view_, 0, side->memory(),
                                table::Workspace{side->entries_, side->devices_});
        return side;
    }

    Engine& engine() override { return *executor_; }
    [[nodiscard]] table::Executor& executor() { return *executor_; }

    void set(Instant t, const Set& set) override {
        const auto index =
            static_cast<std::uint32_t>(std::find(names_.begin(), names_.end(), set.name) - names_.begin());
        const auto item = view_.item(index);
        const value::Layout layout{.type = table::type_of(item), .registers = item.registers};
        const auto words = value::encode(layout, set.value).value().registers;
        if (item.device != table::kNone) {
            EXPECT_TRUE(executor_->set(index, words.span())) << set.name;
            return;
        }
        const bool before = values_[item.place] != 0;
        std::copy(words.begin(), words.end(), values_.begin() + item.place);
        executor_->on_local(t, index, before, values_[item.place] != 0);
    }

    [[nodiscard]] std::uint16_t word(const std::string& name) const {
        const auto index = std::find(names_.begin(), names_.end(), name) - names_.begin();
        return values_[view_.item(static_cast<std::uint32_t>(index)).place];
    }

private:
    static bool is_at(const table::View& view, std::uint32_t index, const model::Device& device,
                      const model::Variable& variable) {
        const auto item = view.item(index);
        return view.device(item.device).unit == device.address.value && item.start == variable.start() &&
               item.area == static_cast<std::uint8_t>(variable.area);
    }

    table::Memory memory() { return {values_, read_, wanted_, items_}; }

    table::Image image_;
    table::View view_;
    std::vector<std::uint16_t> values_, read_, wanted_;
    std::vector<table::ItemState> items_;
    std::vector<table::EntryState> entries_;
    std::vector<table::DeviceState> devices_;
    std::vector<std::string> names_;
    std::optional<table::Executor> executor_;
};

inline std::vector<Record::Entry> frames(const model::Project& project, Side& side, const Script& script,
                                         Duration end) {
    Record record;
    SimulatedLine line(project.lines[0], side.engine());
    line.set_observer(&record);
    line.start(Instant{});
    for (const auto& [when, what] : script) {
        line.advance(at(when));
        if (const auto* set = std::get_if<Set>(&what)) side.set(at(when), *set);
        if (const auto* link = std::get_if<Link>(&what)) {
            if (link->up)
                line.start(at(when));
            else
                line.stop(at(when));
        }
        if (const auto* behave = std::get_if<Behave>(&what)) {
            auto& behaviour = line.devices()[behave->device].behaviour;
            behaviour.dead = behave->dead;
            behaviour.refuses_all = behave->refuses;
        }
        line.advance(at(when));
    }
    line.advance(at(end));
    return record.entries;
}

inline std::unique_ptr<TableSide> table_side(const model::Project& project, const plan::Plan& plan) {
    table::BuildOptions options;
    for (const auto& line : project.lines) options.lines.push_back(poll::line_config(project, line));
    return TableSide::of_project(project, table::build(project, plan, options).value());
}

inline std::string text_of(const Record::Entry& entry) {
    return fmt::format("{} at {} ns: {:02X}", entry.sender, entry.start.time_since_epoch().count(),
                       fmt::join(entry.bytes, " "));
}

/// What differs first; empty: nothing. Properties shrink by it, so it is no expectation.
struct Compared {
    std::size_t sent = 0;  ///< frames of the master
    std::string difference;
};

/// Runs both.
inline Compared compare(const model::Project& project, const plan::Plan& plan, TableSide& from_table,
                        const Script& script, Duration end) {
    PolledSide polled(project, plan);
    const auto a = frames(project, polled, script, end);
    const auto b = frames(project, from_table, script, end);
    Compared result;
    for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
        result.sent += a[i].sender == 0 ? 1U : 0U;
        if (a[i] == b[i]) continue;
        result.difference = fmt::format("frame {}: {}; table: {}", i, text_of(a[i]), text_of(b[i]));
        return result;
    }
    if (a.size() != b.size()) result.difference = fmt::format("{} frames; table: {}", a.size(), b.size());
    for (const char* status : {"state", "status"})
        if (polled.number(status) != from_table.word(status))
            result.difference +=
                fmt::format(" {}: {}; table: {}", status, polled.number(status), from_table.word(status));
    return result;
}

inline Compared compare(const model::Project& project, const Script& script, Duration end) {
    const auto plan = plan::make_plan(project);
    return compare(project, plan, *table_side(project, plan), script, end);
}

/// How many frames the master sent; there must be no difference.
inline std::size_t sent_by_both(const model::Project& project, const Script& script, Duration end) {
    const auto compared = compare(project, script, end);
    EXPECT_EQ(compared.difference, "");
    return compared.sent;
}

inline model::Variable variable(std::string name, DataType type, std::uint16_t number, Duration period,
                                Function read = Function::read_holding_registers) {
    model::Variable result;
    result.name = std::move(name);
    result.type = type;
    result.register_number = number;
    result.registers = static_cast<std::uint16_t>(register_count(type));
    result.read = read;
    if (read == Function::read_input_registers) result.area = Area::input_register;
    if (read == Function::read_coils) result.area = Area::coil;
    if (type == DataType::boolean) result.bit = number % 16;
    if (type == DataType::boolean) result.register_number = number / 16;
    result.period = period;
    return result;
}

inline model::Device device(std::string name, std::uint8_t address) {
    model::Device result;
    result.name = std::move(name);
    result.address = UnitId{address};
    result.strategy = model::Strategy::classic;
    result.group_requests = true;
    return result;
}

inline model::Project project(std::vector<model::Device> devices,
                              model::PollOrder order = model::PollOrder::deadline) {
    model::Line line;
    line.name = "line";
    line.transport = model::Transport::simulated;
    line.format = {115200, 8, wire::Parity::none, 1};
    line.order = order;
    line.devices = std::move(devices);
    model::Project result;
    result.lines.push_back(std::move(line));
    for (const char* name : {"go", "read", "on"}) {
        auto& local = result.locals.emplace_back();
        local.name = name;
    }
    result.locals[2].default_value = model::Constant{.number = 1, .integer = 1};
    auto& state = result.locals.emplace_back();
    state.name = "state";
    state.type = DataType::int16;
    result.locals.push_back(state);
    result.locals.back().name = "status";
    return result;
}

}  // namespace table_test
}  // namespace takt::sim
