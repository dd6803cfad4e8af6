#include <initializer_list>
#include <utility>

#include "devices/addressing.hpp"
#include "servers/interpretation.hpp"

namespace takt::model {
namespace {

constexpr std::size_t kBytesInARegister = 2;

void read_variable_type(Reader& reader, Variable& variable, std::optional<DataType>& type) {
    if (const auto word = reader.word("type")) type = data_type(*word);
    const auto length = reader.integer("length");
    if (type) variable.type = *type;
    if (type && type != DataType::string && reader.given("length"))
        reader.report(Rule::variable_length_type, "length", {}, {{"type", std::string(name(*type))}});
    if (type == DataType::string && !reader.given("length"))
        reader.report(Rule::variable_length_missing, "length", reader.allowed_text("length"));
    variable.registers =
        static_cast<std::uint16_t>(register_count(variable.type, static_cast<int>(length.value_or(1))));
}

/// A value is not split over two requests. Only `optimal` splits, where the user's limit requires it.
void check_share(Reader& reader, const Device& device, const Variable& variable) {
    const bool optimal = device.strategy == Strategy::optimal;
    if (device.strategy == Strategy::single || (optimal && !device.registers_per_request_set) ||
        variable.registers <= device.registers_per_request)
        return;
    reader.report(optimal ? Rule::variable_read_in_parts : Rule::variable_larger_than_request,
                  variable.type == DataType::string ? "length" : "type", {},
                  {{"registers", std::to_string(variable.registers)},
                   {"limit", std::to_string(device.registers_per_request)}});
}

/// Items that a function can carry in one request.
void check_size(Reader& reader, const Context& context, const Device& device, const Variable& variable) {
    if (variable.write == wire::Function::write_single_register && variable.registers > 1)
        reader.report(Rule::variable_single_register, "write", "none, 0x10",
                      {{"registers", std::to_string(variable.registers)}});
    if (variable.type == DataType::string && variable.write == wire::Function::write_multiple_registers) {
        const auto most = wire::max_items(context.framing, *variable.write, limits_of(context.profile));
        if (variable.registers > most)
            reader.report(Rule::field_out_of_range, "length", "1.." + std::to_string(most));
    }
    if (device.write_single == WriteSingle::only && variable.registers > 1 &&
        variable.write == wire::Function::write_multiple_registers)
        reader.report(Rule::variable_write_single_only, "write", "none",
                      {{"registers", std::to_string(variable.registers)}});
    check_share(reader, device, variable);
}

/// A write of one bit rewrites the other bits of its register. It is allowed only if the device supports
/// single bits or the user accepts that concurrent changes can be lost.
void drop_bit_write(Reader& reader, const Device& device, Variable& variable) {
    if (variable.type != DataType::boolean || variable.area != wire::Area::holding_register ||
        !variable.write || device.fc22 || device.read_modify_write)
        return;
    reader.report(Rule::variable_bit_write, "write", "none");
    variable.write.reset();
}

void read_triggers(Interpretation& state, Reader& reader, Variable& variable) {
    variable.write_on_change = reader.boolean("write_on_change").value_or(false);
    variable.read_trigger = read_local(state, reader, "read_trigger");
    variable.write_trigger = read_local(state, reader, "write_trigger");
    variable.status = read_local(state, reader, "status");
    variable.verify = reader.boolean("verify").value_or(false);
    variable.admission = read_admission(reader);
    variable.safe_to_repeat = reader.boolean("safe_to_repeat").value_or(false);
}

bool is_none(const Reader& reader, std::string_view function) {
    const Node* const node = reader.value(function);
    return node != nullptr && node->text == "none";
}

/// Reports keys that need a write or read function that the variable does not have.
void check_wishes(Reader& reader, std::string_view function, Rule rule,
                  std::initializer_list<std::pair<std::string_view, bool>> wishes) {
    if (reader.given(function) && !is_none(reader, function)) return;
    for (const auto& [key, wished] : wishes)
        if (wished) reader.report(rule, key, {}, {{"key", std::string(key)}});
}

void check_traffic(Reader& reader, const Variable& variable) {
    if (variable.write_on_change && (!reader.given("write") || is_none(reader, "write")))
        reader.report_without_effect("write_on_change", "write: none");
    check_wishes(reader, "write", Rule::variable_needs_write,
                 {{"write_trigger", reader.given("write_trigger")},
                  {"min_interval", reader.given("min_interval")},
                  {"write_range", reader.given("write_range")},
                  {"verify", variable.verify},
                  {"safe_to_repeat", variable.safe_to_repeat}});
    if (!variable.read)
        check_wishes(reader, "read", Rule::variable_needs_read,
                     {{"read_trigger", reader.given("read_trigger")}});
    const auto none_or_missing = [&](std::string_view key) {
        return is_none(reader, key) || !reader.given(key);
    };
    const bool none = is_none(reader, "read") || is_none(reader, "write");
    if (variable.used && none && none_or_missing("read") && none_or_missing("write"))
        reader.report(Rule::variable_no_traffic, is_none(reader, "read") ? "read" : "write");
}

void read_period(const Interpretation& state, Reader& reader, const Device& device, Variable& variable) {
    variable.period = reader.duration("period").value_or(device.poll_period);
    variable.deadline = reader.duration("deadline");
    if (variable.deadline && variable.period == Duration::zero())
        reader.report(Rule::variable_deadline_without_period, "deadline");
    if (!reader.given("deadline") && variable.period > Duration::zero()) variable.deadline = state.deadline;
}

void read_scale(Reader& reader, Variable& variable, std::optional<DataType> type) {
    variable.scale = reader.number("scale").value_or(1);
    variable.offset = reader.number("offset").value_or(0);
    variable.dead_band = reader.number("dead_band").value_or(0);
    if (variable.scale == 0) {
        reader.report(Rule::variable_scale_zero, "scale");
        variable.scale = 1;
    }
    if (variable.dead_band < 0) reader.report(Rule::field_out_of_range, "dead_band", ">= 0");
    if (type != DataType::boolean && type != DataType::string) return;
    for (const std::string_view key : {"scale", "offset", "dead_band", "write_range"})
        if (reader.given(key))
            reader.report(Rule::variable_scale_type, key, {},
                          {{"key", std::string(key)}, {"type", std::string(name(*type))}});
}

void read_presentation(Reader& reader, const Device& device, Variable& variable,
                       std::optional<DataType> type) {
    variable.order = read_byte_order(reader, device.order, type);
    if (type == DataType::boolean && wire::is_bit_area(variable.area))
        for (const std::string_view key : {"high_byte_first", "high_register_first", "byte_order"})
            if (reader.given(key)) reader.report_without_effect(key, "area: " + area_name(variable.area));
    read_scale(reader, variable, type);
    if (type) {
        const ConstantShape shape{.type = *type,
                                  .most_bytes = variable.registers * kBytesInARegister,
                                  .scale = variable.scale,
                                  .offset = variable.offset};
        variable.default_value = read_constant(reader, "default", shape);
        if (*type != DataType::boolean && *type != DataType::string)
            variable.write_range = read_write_range(reader, shape);
    }
    if (variable.write_range && reader.given("enumeration"))
        reader.report_without_effect("write_range", "enumeration");
    variable.hold_last = reader.boolean("hold_last").value_or(false);
    variable.retain = reader.boolean("retain").value_or(false);
    variable.unit = reader.text("unit").value_or("");
    variable.comment = reader.text("comment").value_or("");
}

Variable read_variable(Interpretation& state, const Device& device, Reader& reader) {
    Variable variable;
    variable.location = reader.node().location;
    variable.name = read_name(state, reader, state.names);
    variable.used = reader.boolean("used").value_or(true);
    std::optional<DataType> type;
    read_variable_type(reader, variable, type);
    variable.read = reader.function("read").value_or(FunctionChoice{}).function;
    variable.write = reader.function("write").value_or(FunctionChoice{}).function;
    settle_address(reader, variable, type);
    note_like_reference(state, reader, variable);
    if (type) {
        check_size(reader, state.context, device, variable);
        drop_bit_write(reader, device, variable);
    }
    read_triggers(state, reader, variable);
    const bool answered = device.address != kBroadcast || state.context.framing == wire::Framing::tcp;
    if (!answered && std::exchange(variable.verify, false))
        reader.report_without_effect("verify", "address: 0");
    check_traffic(reader, variable);
    read_period(state, reader, device, variable);
    read_presentation(reader, device, variable, type);
    read_value_words(state, reader, variable, type);
    return variable;
}

}  // namespace

Variable interpret_variable(Interpretation& state, const Device& device, const Node& node,
                            const std::string& path) {
    Reader reader(state.findings, node, path, Object::variable, state.context);
    auto variable = read_variable(state, device, reader);
    variable.max_age = reader.duration("max_age");
    variable.tags = read_tags(state, reader);
    if (variable.max_age && !variable.read) reader.report_without_effect("max_age", "read: none");
    return variable;
}

Variable interpret_served_variable(Interpretation& state, const Device& shape, const Node& node,
                                   const std::string& path,
                                   const std::function<void(Reader&, const Variable&)>& more) {
    Reader reader(state.findings, node, path, Object::served_variable, state.context);
    auto variable = read_variable(state, shape, reader);
    more(reader, variable);
    if (reader.given("tags")) reader.report_without_effect("tags", "servers");
    return variable;
}

}  // namespace takt::model
