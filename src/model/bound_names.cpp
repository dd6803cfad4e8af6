// Resolves the names in bindings after all lines and locals are known.
#include <algorithm>

#include "binding.hpp"
#include "takt/model/nearest.hpp"
#include "takt/model/service.hpp"

namespace takt::model {
namespace {

constexpr std::size_t kNamesToCompare = 500;

void report_unknown(Reader& reader, std::string_view key, std::string_view wanted,
                    const std::vector<std::string_view>& names) {
    if (names.empty()) return reader.report(Rule::name_none, key, {}, {{"kind", std::string(key)}});
    reader.report(Rule::source_unknown, key, {},
                  {{"kind", std::string(key)}, {"nearest", std::string(nearest(wanted, names))}});
}

bool fits(Reader& reader, std::string_view key, const Variable& variable, DataType other) {
    if ((variable.type == DataType::string) == (other == DataType::string)) return true;
    reader.report(Rule::source_type, key, {}, {{"type", std::string(name(variable.type))}});
    return false;
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
        report_unknown(reader, "variable", *name, names);
        return nullptr;
    }
    return fits(reader, "variable", variable, found->second->type) ? found->second : nullptr;
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
        report_unknown(reader, "local", *name, names);
        return std::nullopt;
    }
    if (!fits(reader, "local", variable, state.project.locals[found->second].type)) return std::nullopt;
    return LocalSource{*name};
}

std::optional<LocalSource> read_service_name(Interpretation& state, Reader& reader, std::string_view key,
                                             const Variable& variable) {
    const auto service = read_service(state, reader, key);
    if (!service) return std::nullopt;
    const auto& local = state.project.locals[*service];
    if (!fits(reader, key, variable, local.type)) return std::nullopt;
    if (outgrows(*find_service_field(local.name), variable.type, variable.scaled()))
        reader.report(Rule::service_outgrows, key, "uint32", {{"type", std::string(name(variable.type))}});
    return LocalSource{local.name};
}

std::optional<InstrumentSource> read_instrument_name(Interpretation& state, Reader& reader) {
    const auto name = reader.text("instrument");
    if (!name) return std::nullopt;
    const auto dot = name->rfind('.');
    const auto& all = state.project.instruments;
    const auto found =
        dot == std::string::npos
            ? all.end()
            : std::ranges::find(all, std::string_view(*name).substr(0, dot), &Instrument::name);
    if (found != all.end() && found->has(name->substr(dot + 1)))
        return InstrumentSource{static_cast<std::size_t>(found - all.begin()), name->substr(dot + 1)};
    std::vector<std::string> known;
    for (const auto& instrument : all)
        for (const auto& exchange : instrument.exchanges)
            for (const auto measurement : exchange.answer.names())
                known.push_back(instrument.name + "." + std::string(measurement));
    report_unknown(reader, "instrument", *name, {known.begin(), known.end()});
    return std::nullopt;
}

}  // namespace takt::model
