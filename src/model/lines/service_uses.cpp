// Service variables that a project uses. A line or device may follow in the file, so that only the form of a
// name, and with it the type, is known when it is read.
#include <algorithm>
#include <limits>

#include "servers/interpretation.hpp"
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
    if (field != nullptr && reader.kind(key) == Kind::local_bool && field->type != DataType::boolean) {
        state.used_services.push_back({node->text, node->location, reader.path_of(key)});
        reader.report(Rule::service_type, key, "bool", {{"type", std::string(name(field->type))}});
        return std::nullopt;
    }
    return use_service(state, node->text, node->location, reader.path_of(key));
}

std::optional<LocalIndex> use_service(Interpretation& state, const std::string& name,
                                      const SourceLocation& location, const std::string& path) {
    const auto* const field = find_service_field(name);
    state.used_services.push_back({name, location, path});
    if (field == nullptr) return std::nullopt;
    const auto [known, is_new] = state.services.try_emplace(name, state.project.locals.size());
    if (!is_new) return known->second;
    state.project.locals.push_back(service_local(name, *field));
    state.project.locals.back().location = location;
    state.local_type_known.push_back(true);
    return known->second;
}

namespace {

constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();

/// Finds devices that wait for themselves: each has at most one device whose answers enable it.
class Enables {
public:
    Enables(const Project& project, const ServiceNames& names) {
        std::vector<std::size_t> first;  // of each line
        for (std::size_t l = 0; l < project.lines.size(); ++l) {
            first.push_back(devices_.size());
            for (std::size_t d = 0; d < project.lines[l].devices.size(); ++d) devices_.push_back({l, d});
        }
        by_.resize(devices_.size(), kNone);
        for (std::size_t i = 0; i < devices_.size(); ++i) {
            const auto& enable = project.lines[devices_[i].line].devices[devices_[i].device].poll_enable;
            const auto found = enable ? names.find(project.locals[*enable].name) : std::nullopt;
            if (found && found->field->value == ServiceValue::device_answering)
                by_[i] = first[found->line] + found->device;
        }
    }

    /// Calls `each(line, device)` for the devices of each circle.
    template <class Each>
    void circles(const Each& each) const {
        std::vector<std::size_t> walk(devices_.size(), kNone);  // the walk that came to a device first
        for (std::size_t start = 0; start < devices_.size(); ++start) {
            std::size_t at = start;
            while (at != kNone && walk[at] == kNone) {
                walk[at] = start;
                at = by_[at];
            }
            if (at == kNone || walk[at] != start) continue;
            const std::size_t end = at;
            do {
                each(devices_[at].line, devices_[at].device);
                at = by_[at];
            } while (at != end);
        }
    }

private:
    struct Position {
        std::size_t line = 0;
        std::size_t device = 0;
    };
    std::vector<Position> devices_;
    std::vector<std::size_t> by_;
};

void check_enables(Interpretation& state, const ServiceNames& names) {
    Enables(state.project, names).circles([&](std::size_t line, std::size_t index) {
        if (state.findings.full(Rule::service_circular)) return;
        const auto& device = state.project.lines[line].devices[index];
        const auto path =
            "lines[" + std::to_string(line) + "].devices[" + std::to_string(index) + "].poll_enable";
        const auto used = std::ranges::find(state.used_services, path, &Interpretation::UsedService::path);
        if (used == state.used_services.end()) return;
        state.findings.add(Rule::service_circular, used->location, path, used->name, {},
                           {{"device", device.name}});
    });
}

}  // namespace

void check_services(Interpretation& state) {
    if (state.used_services.empty()) return;
    const ServiceNames names(state.project);
    check_enables(state, names);
    for (const auto& used : state.used_services) {
        if (names.find(used.name)) continue;
        auto hint = state.findings.full(Rule::service_unknown) ? ServiceHint{} : names.hint(used.name);
        state.findings.add(Rule::service_unknown, used.location, used.path, used.name,
                           std::move(hint.allowed), {{"nearest", std::move(hint.nearest)}});
    }
}

}  // namespace takt::model
