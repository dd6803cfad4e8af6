#include <ranges>

#include "servers/interpretation.hpp"
#include "takt/model/nearest.hpp"
#include "takt/model/service.hpp"

namespace takt::model {
namespace {

void report_unknown_local(const Interpretation& state, Reader& reader, std::string_view key,
                          std::string_view wanted, const char* types) {
    if (state.locals.empty()) {
        reader.report(Rule::local_undeclared, key, types);
        return;
    }
    std::vector<std::string_view> names;
    if (!state.findings.full(Rule::local_unknown))
        for (const auto& local : std::views::take(state.project.locals, kNamesToCompare))
            if (!local.name.empty() && !local.service) names.emplace_back(local.name);
    reader.report(Rule::local_unknown, key, {}, {{"nearest", std::string(nearest(wanted, names))}});
}

}  // namespace

Local interpret_local(Interpretation& state, const Node& node, const std::string& path) {
    Reader reader(state.findings, node, path, Object::local, state.context);
    Local local;
    local.location = node.location;
    local.name = read_name(state, reader, state.names);
    const LocalIndex index = state.project.locals.size();
    if (!local.name.empty()) state.locals.try_emplace(local.name, index);
    if (const auto word = reader.word("type")) {
        local.type = data_type(*word).value_or(local.type);
        state.local_type_known[index] = true;
        local.default_value = read_constant(reader, "default", {.type = local.type});
    }
    local.admission = read_admission(reader);
    if (state.local_type_known[index] && local.type != DataType::boolean)
        for (const std::string_view key : {"min_interval", "burst"})
            if (reader.given(key))
                reader.report(Rule::local_not_a_trigger, key, {},
                              {{"key", std::string(key)}, {"type", std::string(name(local.type))}});
    local.retain = reader.boolean("retain").value_or(false);
    reader.boolean("used");  // kept in the file for tables; without effect
    local.comment = reader.text("comment").value_or("");
    return local;
}

std::optional<LocalIndex> read_local(Interpretation& state, Reader& reader, std::string_view key) {
    const Node* const node = reader.scalar(key);
    if (node == nullptr) return std::nullopt;
    const bool wants_bool = reader.kind(key) == Kind::local_bool;
    const auto types = wants_bool ? "bool" : "int16, uint16, int32, uint32, int64, uint64";
    if (names_service(reader, key)) return read_service(state, reader, key);
    const auto found = state.locals.find(node->text);
    if (found == state.locals.end() && resembles_service_name(node->text))
        return read_service(state, reader, key);
    if (found == state.locals.end()) {
        report_unknown_local(state, reader, key, node->text, types);
        return std::nullopt;
    }
    if (!state.local_type_known[found->second]) return std::nullopt;
    const auto type = state.project.locals[found->second].type;
    if (wants_bool ? type == DataType::boolean : is_integer(type)) return found->second;
    reader.report(Rule::local_type, key, types, {{"type", std::string(name(type))}});
    return std::nullopt;
}

}  // namespace takt::model
