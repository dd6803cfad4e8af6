// Service variables that a project uses. A line or device may follow in the file, so that only the form of a
// name, and with it the type, is known when it is read.
#include "interpretation.hpp"
#include "takt/model/service.hpp"

namespace takt::model {

bool names_service(const Reader& reader, std::string_view key) {
    const Node* const node = reader.value(key);
    return node != nullptr && node->kind == Node::Kind::scalar && is_service_name(node->text);
}

std::optional<LocalIndex> read_service(Interpretation& state, Reader& reader, std::string_view key) {
    const Node* const node = reader.scalar(key);
    if (node == nullptr) return std::nullopt;
    if (reader.kind(key) == Kind::local_integer) {
        reader.report(Rule::service_read_only, key);
        return std::nullopt;
    }
    const auto* const field = find_service_field(node->text);
    state.used_services.push_back({node->text, node->location, reader.path_of(key)});
    if (field == nullptr) return std::nullopt;
    if (reader.kind(key) == Kind::local_bool && field->type != DataType::boolean) {
        reader.report(Rule::service_type, key, "bool", {{"type", std::string(name(field->type))}});
        return std::nullopt;
    }
    const auto [known, is_new] = state.services.try_emplace(node->text, state.project.locals.size());
    if (!is_new) return known->second;
    state.project.locals.push_back(service_local(node->text, *field));
    state.project.locals.back().location = node->location;
    state.local_type_known.push_back(true);
    return known->second;
}

void check_services(Interpretation& state) {
    if (state.used_services.empty()) return;
    const ServiceNames names(state.project);
    for (const auto& used : state.used_services) {
        if (names.find(used.name)) continue;
        auto hint = state.findings.full(Rule::service_unknown) ? ServiceHint{} : names.hint(used.name);
        state.findings.add(Rule::service_unknown, used.location, used.path, used.name,
                           std::move(hint.allowed), {{"nearest", std::move(hint.nearest)}});
    }
}

}  // namespace takt::model
