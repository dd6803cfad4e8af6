// Resolves the names in bindings after all lines and locals are known.
#include <algorithm>

#include "devices/binding.hpp"
#include "takt/model/nearest.hpp"
#include "takt/model/service.hpp"

namespace takt::model {
namespace {

constexpr std::size_t kMostListed = 500;                // bytes
constexpr std::string_view kInstrumentState = "state";  // what every instrument has

void report_unknown_source(Reader& reader, std::string_view key, std::string_view wanted,
                           const std::vector<std::string_view>& names) {
    if (names.empty()) return reader.report(Rule::name_none, key, {}, {{"kind", std::string(key)}});
    reader.report(Rule::source_unknown, key, {},
                  {{"kind", std::string(key)}, {"nearest", std::string(nearest(wanted, names))}});
}

bool type_fits(Reader& reader, std::string_view key, const Variable& variable, DataType other) {
    if ((variable.type == DataType::string) == (other == DataType::string)) return true;
    reader.report(Rule::source_type, key, {}, {{"type", std::string(name(variable.type))}});
    return false;
}

/// The instrument, if there is one of that name, and the rest of `NAME.REST`.
std::pair<std::optional<std::size_t>, std::string_view> divided(const Interpretation& state,
                                                                std::string_view name) {
    const auto dot = name.rfind('.');
    if (dot == std::string_view::npos) return {};
    const auto& all = state.project.instruments;
    const auto found = std::ranges::find(all, name.substr(0, dot), &Instrument::name);
    if (found == all.end()) return {};
    return {static_cast<std::size_t>(found - all.begin()), name.substr(dot + 1)};
}

}  // namespace

Variable* read_polled(Interpretation& state, Reader& reader, const Variable& variable) {
    const auto name = reader.text("variable");
    if (!name) return nullptr;
    const auto found = state.polled.find(*name);
    if (found == state.polled.end() && resembles_service_name(*name)) {
        (void)read_service(state, reader, "variable");
        return nullptr;
    }
    if (found == state.polled.end()) {
        std::vector<std::string_view> names;
        for (const auto& [other, _] : state.polled)
            if (names.size() < kNamesToCompare) names.emplace_back(other);
        std::ranges::sort(names);
        report_unknown_source(reader, "variable", *name, names);
        return nullptr;
    }
    return type_fits(reader, "variable", variable, found->second->type) ? found->second : nullptr;
}

std::optional<LocalSource> read_local_name(Interpretation& state, Reader& reader, const Variable& variable) {
    const auto name = reader.text("local");
    if (!name) return std::nullopt;
    const auto found = state.locals.find(*name);
    if (found == state.locals.end() && resembles_service_name(*name)) {
        (void)read_service(state, reader, "local");
        return std::nullopt;
    }
    if (found == state.locals.end()) {
        std::vector<std::string_view> names;
        for (const auto& local : state.project.locals)
            if (names.size() < kNamesToCompare && !local.name.empty() && !local.service)
                names.emplace_back(local.name);
        report_unknown_source(reader, "local", *name, names);
        return std::nullopt;
    }
    if (!type_fits(reader, "local", variable, state.project.locals[found->second].type)) return std::nullopt;
    return LocalSource{*name};
}

std::optional<LocalSource> read_service_name(Interpretation& state, Reader& reader, std::string_view key,
                                             const Variable& variable) {
    const auto service = read_service(state, reader, key);
    if (!service) return std::nullopt;
    const auto& local = state.project.locals[*service];
    if (!type_fits(reader, key, variable, local.type)) return std::nullopt;
    if (outgrows(*find_service_field(local.name), variable.type, variable.scaled()))
        reader.report(Rule::service_outgrows, key, "uint32", {{"type", std::string(name(variable.type))}});
    return LocalSource{local.name};
}

std::optional<InstrumentSource> read_instrument_name(Interpretation& state, Reader& reader) {
    const auto name = reader.text("instrument");
    if (!name) return std::nullopt;
    const auto& all = state.project.instruments;
    const auto [instrument, measurement] = divided(state, *name);
    if (instrument && all[*instrument].has(measurement))
        return InstrumentSource{*instrument, std::string(measurement)};
    if (instrument && measurement == kInstrumentState) return InstrumentSource{*instrument, {}};
    std::vector<std::string> known;
    for (const auto& other : all) {
        for (const auto& exchange : other.exchanges)
            for (const auto found : exchange.answer.names())
                known.push_back(other.name + "." + std::string(found));
        known.push_back(other.name + "." + std::string(kInstrumentState));
    }
    report_unknown_source(reader, "instrument", *name, {known.begin(), known.end()});
    return std::nullopt;
}

std::optional<InstrumentSink> read_instrument_command(Interpretation& state, Reader& reader,
                                                      const Variable& variable) {
    const auto name = reader.text("instrument");
    if (!name) return std::nullopt;
    const auto& all = state.project.instruments;
    std::vector<std::string> known;
    for (std::size_t i = 0; i < all.size(); ++i)
        for (std::size_t j = 0; j < all[i].commands.size(); ++j) {
            const auto& command = all[i].commands[j];
            const auto full = all[i].name + "." + command.name;
            if (full != *name) {
                if (!command.name.empty() && std::ranges::find(known, full) == known.end())
                    known.push_back(full);
                continue;
            }
            if ((command.kind() == TextTemplate::Kind::text) == (variable.type == DataType::string))
                return InstrumentSink{i, j};
            reader.report(Rule::source_type, "instrument", {},
                          {{"type", std::string(takt::name(variable.type))}});
            return std::nullopt;
        }
    if (known.empty()) {
        reader.report(Rule::name_none, "instrument", {}, {{"kind", "command"}});
        return std::nullopt;
    }
    std::string listed;
    for (const auto& command : known)
        if (listed.size() < kMostListed) listed += (listed.empty() ? "" : ", ") + command;
    reader.report(Rule::instrument_command_unknown, "instrument", listed);
    return std::nullopt;
}

}  // namespace takt::model
