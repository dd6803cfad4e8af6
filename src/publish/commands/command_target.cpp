#include "takt/publish/command_target.hpp"

#include <algorithm>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "takt/model/nearest.hpp"
#include "takt/publish/output_slot.hpp"
#include "takt/value/text.hpp"

namespace takt::publish {
namespace {

using Target = std::expected<host::Command, CommandRefused>;

std::unexpected<CommandRefused> refuse(CommandRefusal why, std::string detail) {
    return std::unexpected(CommandRefused{why, std::move(detail)});
}

std::string with_nearest(const std::string& detail, const std::string& given,
                         const std::vector<std::string_view>& names) {
    const auto nearest = model::nearest(given, names);
    return nearest.empty() ? detail : detail + "; nearest: " + std::string(nearest);
}

// Only names that a command may concern are shown.
std::unexpected<CommandRefused> unknown(const CommandRequest& request, const CommandRights& rights) {
    std::vector<std::string_view> names;
    for (const auto* slots : {&rights.commandable, &rights.readable})
        for (const auto slot : *slots) names.push_back(rights.configuration->info(slot).name);
    return refuse(CommandRefusal::unknown_variable,
                  with_nearest("variable: " + request.subject, request.subject, names));
}

std::unexpected<CommandRefused> not_listed(std::string_view key, std::string_view subject) {
    return refuse(CommandRefusal::not_listed, std::string(key) + ": " + std::string(subject) +
                                                  "; allowed: what the output lists for commands");
}

Target switched(const CommandRequest& request, const CommandRights& rights) {
    std::vector<std::string_view> names;
    for (const auto& line : rights.configuration->project().lines)
        for (const auto& device : line.devices) {
            names.push_back(device.name);
            if (device.name != request.subject) continue;
            if (!device.poll_enable)
                return refuse(CommandRefusal::no_poll_enable, "device: " + request.subject);
            const auto slot = rights.configuration->slots().local(*device.poll_enable);
            if (!rights.commandable.contains(slot))
                return not_listed(
                    "device", request.subject + " with its local " + rights.configuration->info(slot).name);
            return host::Command{
                .kind = host::Command::Kind::set, .slot = slot, .value = request.verb == CommandVerb::enable};
        }
    return refuse(CommandRefusal::unknown_variable,
                  with_nearest("device: " + request.subject, request.subject, names));
}

bool is_local(const host::Configuration& configuration, value::SlotId slot) {
    return std::holds_alternative<model::LocalIndex>(configuration.slots().owner(slot));
}

std::expected<value::Value, CommandRefused> value_of(const CommandRequest& request,
                                                     const value::SlotInfo& info) {
    const auto wrong = [&](std::string_view text) {
        return refuse(CommandRefusal::malformed, "value: " + std::string(text));
    };
    const bool text = info.type == DataType::string;
    if (!request.value) return wrong("missing");
    using Form = CommandRequest::ValueForm;
    if (request.form == Form::other && text) return wrong(value::beside_allowed(*request.value, "a string"));
    if (request.form == Form::string && !text)
        return wrong(value::beside_allowed('"' + *request.value + '"',
                                           info.type == DataType::boolean ? "true, false" : "a number"));
    auto value = value::parse(info.type, info.scaled, *request.value);
    if (!value) return wrong(value.error().subject.view());
    return *std::move(value);
}

Target with_value(const CommandRequest& request, const host::Configuration& configuration,
                  value::SlotId slot) {
    auto value = value_of(request, configuration.info(slot));
    if (!value) return std::unexpected(std::move(value).error());
    const auto* const variable = configuration.variable_of(slot);
    const bool now = request.verb == CommandVerb::write || (variable != nullptr && variable->write_on_change);
    return host::Command{.kind = now ? host::Command::Kind::write : host::Command::Kind::set,
                         .slot = slot,
                         .value = *std::move(value)};
}

}  // namespace

CommandRights rights_of(host::ConfigurationPtr configuration, const model::Output& output) {
    CommandRights rights{.configuration = std::move(configuration), .commandable = {}, .readable = {}};
    const auto& slots = rights.configuration->slots();
    for (const auto& subject : output.commandable) rights.commandable.insert(slot_of(slots, subject));
    for (const auto& value : output.values) rights.readable.insert(slot_of(slots, value.subject));
    return rights;
}

Target target_of(const CommandRequest& request, const CommandRights& rights) {
    if (request.verb == CommandVerb::enable || request.verb == CommandVerb::disable)
        return switched(request, rights);
    const auto& configuration = *rights.configuration;
    const auto slot = configuration.find(request.subject);
    if (!slot) return unknown(request, rights);
    const bool get = request.verb == CommandVerb::get;
    if (!rights.commandable.contains(*slot) && !(get && rights.readable.contains(*slot)))
        return not_listed("variable", request.subject);
    if (get) return host::Command{.kind = host::Command::Kind::get, .slot = *slot};
    if (request.verb != CommandVerb::trigger) return with_value(request, configuration, *slot);
    if (!is_local(configuration, *slot) || configuration.info(*slot).type != DataType::boolean)
        return refuse(CommandRefusal::malformed,
                      "variable: " + request.subject + "; allowed for trigger: a local of type bool");
    return host::Command{.kind = host::Command::Kind::pull, .slot = *slot};
}

}  // namespace takt::publish
