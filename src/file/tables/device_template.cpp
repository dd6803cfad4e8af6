// create() checks all expressions, so that a mistake in a template is reported once, and not by each device.
#include "tables/device_template.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <iterator>
#include <string_view>
#include <utility>
#include <vector>

#include "takt/base/ascii.hpp"
#include "takt/file/load.hpp"
#include "takt/model/nearest.hpp"
#include "takt/model/scalar.hpp"
#include "yaml/nodes.hpp"

namespace takt::file {
namespace {

using model::Node;
using model::SourceLocation;

constexpr std::string_view kTemplateKey = "device_template";
constexpr std::string_view kParametersKey = "parameters";
constexpr std::array<std::string_view, 2> kBuiltIn{"device", "address"};
constexpr std::int64_t kMostMagnitude = 1'000'000'000;

bool is_name(std::string_view text) {
    return !text.empty() && std::ranges::all_of(text, [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
    });
}

bool is_built_in(std::string_view name) {
    return std::ranges::find(kBuiltIn, name) != kBuiltIn.end();
}

/// An expression in a text: `$(name)`, `$(name + 10)`.
struct Expression {
    std::size_t begin = 0;
    std::size_t end = 0;  // behind `)`
    std::string_view name;
    std::int64_t added = 0;
    bool sum = false;
    bool valid = false;
};

std::optional<Expression> next_expression(std::string_view text, std::size_t from) {
    Expression found;
    found.begin = text.find("$(", from);
    if (found.begin == std::string_view::npos) return std::nullopt;
    const auto close = text.find(')', found.begin);
    found.end = close == std::string_view::npos ? text.size() : close + 1;
    if (close == std::string_view::npos) return found;
    const auto inside = text.substr(found.begin + 2, close - found.begin - 2);
    const auto sign = inside.find_first_of("+-");
    found.name = trimmed(inside.substr(0, sign));
    found.valid = is_name(found.name);
    if (sign == std::string_view::npos) return found;
    found.sum = true;
    const auto number = model::parse_integer(trimmed(inside.substr(sign + 1)));
    const auto value = number ? number->as_int64() : std::nullopt;
    found.valid = found.valid && value && *value >= 0 && *value <= kMostMagnitude;
    if (found.valid) found.added = inside[sign] == '-' ? -*value : *value;
    return found;
}

void for_each_scalar(const Node& node, const auto& visit) {
    if (node.kind == Node::Kind::scalar) visit(node);
    for (const auto& item : node.items) for_each_scalar(item, visit);
    for (const auto& [key, value] : node.entries) for_each_scalar(value, visit);
}

std::size_t count_nodes(const Node& node) {
    std::size_t count = 1;
    for (const auto& item : node.items) count += count_nodes(item);
    for (const auto& [key, value] : node.entries) count += 1 + count_nodes(value);
    return count;
}

std::string names_of(const Node& parameters) {
    std::string names;
    for (const auto& [key, value] : parameters.entries)
        names.append(names.empty() ? "" : ", ").append(key.text);
    for (const auto name : kBuiltIn) names.append(names.empty() ? "" : ", ").append(name);
    return names;
}

/// Whether the entries are names of parameters with single values.
bool check_parameters(const Node& parameters, const std::string& path, Reporter& reporter) {
    if (parameters.kind != Node::Kind::mapping) {
        reporter.error("file.template.parameters", parameters.location, {.path = path});
        return false;
    }
    bool valid = true;
    const auto refuse = [&](std::string_view code, const Node& at, const Node& key) {
        valid = false;
        reporter.error(code, at.location,
                       {.value = key.text,
                        .allowed = "1.." + std::to_string(kMostParameterBytes),
                        .path = path + '.' + key.text});
    };
    for (const auto& [key, value] : parameters.entries) {
        if (!is_name(key.text) || is_built_in(key.text)) refuse("file.template.parameter_name", key, key);
        if (value.kind != Node::Kind::null &&
            (value.kind != Node::Kind::scalar || value.text.size() > kMostParameterBytes))
            refuse("file.template.parameter_value", value, key);
    }
    return valid;
}

bool check_expressions(const Node& root, const Node& parameters, Reporter& reporter) {
    bool valid = true;
    for_each_scalar(root, [&](const Node& scalar) {
        std::size_t at = 0;
        while (const auto found = next_expression(scalar.text, at)) {
            at = found->end;
            const bool known = is_built_in(found->name) || parameters.find(found->name) != nullptr;
            if (found->valid && known) continue;
            valid = false;
            reporter.error(found->valid ? "file.template.unknown" : "file.template.expression",
                           scalar.location,
                           {.value = scalar.text.substr(found->begin, found->end - found->begin),
                            .allowed = names_of(parameters)});
        }
    });
    return valid;
}

/// The values for one device. Keeps copies, since the device grows while they are used.
class Values {
public:
    Values(const Node& device, const Node& defaults, const std::string& path, Reporter& reporter)
        : defaults_(defaults), reporter_(reporter), path_(path + '.' + std::string(kParametersKey)) {
        for (const auto name : kBuiltIn)
            if (const auto* const value = device.find(name == "device" ? "name" : name))
                set(built_in_, name, *value);
        const auto* const given = device.find(kParametersKey);
        if (given != nullptr && given->kind != Node::Kind::null) {
            complete_ = check_parameters(*given, path_, reporter) && are_known(*given);
            given_ = *given;
        }
        if (complete_) check_missing(device.find(kTemplateKey)->location);
    }

    [[nodiscard]] bool complete() const { return complete_; }

    /// Replaces the expressions of a text.
    void replace_in(std::string& text) {
        std::string made;
        std::size_t at = 0;
        while (const auto found = next_expression(text, at)) {
            made.append(text, at, found->begin - at);
            at = found->end;
            made += value_of(*found);
        }
        if (at > 0) text = made.append(text, at);
    }

private:
    bool are_known(const Node& given) {
        std::vector<std::string_view> known;
        for (const auto& [key, value] : defaults_.entries) known.push_back(key.text);
        bool all = true;
        for (const auto& [key, value] : given.entries) {
            if (defaults_.find(key.text) != nullptr) continue;
            all = false;
            std::string allowed;
            for (const auto name : known) allowed.append(allowed.empty() ? "" : ", ").append(name);
            const auto nearest = known.empty() ? std::string_view("–") : model::nearest(key.text, known);
            reporter_.error("file.template.parameter_unknown", key.location,
                            {.value = key.text,
                             .allowed = allowed.empty() ? "–" : allowed,
                             .path = path_ + '.' + key.text,
                             .arguments = {{"nearest", std::string(nearest)}}});
        }
        return all;
    }

    void check_missing(const SourceLocation& location) {
        for (const auto& [key, value] : defaults_.entries) {
            if (value.kind != Node::Kind::null || find(key.text) != nullptr) continue;
            complete_ = false;
            reporter_.error("file.template.parameter_missing", location, {.value = key.text, .path = path_});
        }
    }

    [[nodiscard]] const Node* find(std::string_view name) const {
        const auto* value = is_built_in(name) ? built_in_.find(name) : given_.find(name);
        if (value == nullptr || value->kind == Node::Kind::null) value = defaults_.find(name);
        return value == nullptr || value->kind != Node::Kind::scalar ? nullptr : value;
    }

    std::string value_of(const Expression& expression) {
        const auto* const value = find(expression.name);
        if (value == nullptr) return {};
        if (!expression.sum) return value->text;
        const auto parsed = model::parse_integer(value->text);
        const auto number = parsed ? parsed->as_int64() : std::nullopt;
        if (number && *number >= -kMostMagnitude && *number <= kMostMagnitude)
            return std::to_string(*number + expression.added);
        if (std::ranges::find(refused_, value) == refused_.end()) {
            refused_.push_back(value);
            reporter_.error(
                "file.template.not_an_integer", value->location,
                {.value = value->text,
                 .allowed = std::to_string(-kMostMagnitude) + ".." + std::to_string(kMostMagnitude),
                 .arguments = {{"parameter", std::string(expression.name)}}});
        }
        return "0";  // so that no other finding follows
    }

    const Node& defaults_;
    Reporter& reporter_;
    std::string path_;
    Node built_in_ = collection(Node::Kind::mapping);
    Node given_;
    std::vector<const Node*> refused_;
    bool complete_ = true;
};

void replace_in(Node& node, Values& values) {
    if (node.kind == Node::Kind::scalar) values.replace_in(node.text);
    for (auto& item : node.items) replace_in(item, values);
    for (auto& [key, value] : node.entries) replace_in(value, values);
}

/// The variables of the template, then those of the device.
void add_variables(Node& device, Node variables) {
    const auto name = text_of(device, "name");
    for (auto& item : variables.items)
        for (auto& [key, value] : item.entries)
            if (key.text == "name" && value.kind == Node::Kind::scalar && !name.empty())
                value.text.insert(0, name + '.');
    for (auto& [key, own] : device.entries)
        if (key.text == "variables") {
            if (own.kind == Node::Kind::list)
                std::ranges::move(own.items, std::back_inserter(variables.items));
            else if (own.kind != Node::Kind::null)
                return;  // reported by the interpretation
            own = std::move(variables);
            return;
        }
    set(device, "variables", std::move(variables));
}

}  // namespace

DeviceTemplate::DeviceTemplate(Node root) : root_(std::move(root)) {
    defaults_ = collection(Node::Kind::mapping);
    for (auto& [key, value] : root_.entries)
        if (key.text == kParametersKey && value.kind == Node::Kind::mapping) defaults_ = std::move(value);
    std::erase_if(root_.entries, [](const Node::Entry& entry) {
        return entry.key.text == kParametersKey || entry.key.text == "takt";
    });
    nodes_ = count_nodes(root_);
    for_each_scalar(root_, [this](const Node& scalar) {
        bytes_ += scalar.text.size();
        std::size_t at = 0;
        while (const auto found = next_expression(scalar.text, at)) {
            at = found->end;
            bytes_ += kMostParameterBytes;
        }
    });
}

std::optional<DeviceTemplate> DeviceTemplate::create(Node root, Reporter& reporter) {
    const auto* const version = root.find("takt");
    const auto* const variables = root.find("variables");
    if (root.kind != Node::Kind::mapping || version == nullptr || version->text != "1" ||
        root.find("lines") != nullptr) {
        reporter.error("file.template.none", root.location);
        return std::nullopt;
    }
    if (const auto* const nested = root.find(kTemplateKey)) {
        reporter.error("file.template.nested", nested->location, {.path = std::string(kTemplateKey)});
        return std::nullopt;
    }
    if (variables != nullptr && variables->kind != Node::Kind::list) {
        reporter.error("file.template.variables", variables->location, {.path = "variables"});
        return std::nullopt;
    }
    const auto* const parameters = root.find(kParametersKey);
    if (parameters != nullptr && parameters->kind != Node::Kind::null &&
        !check_parameters(*parameters, std::string(kParametersKey), reporter))
        return std::nullopt;
    DeviceTemplate made(std::move(root));
    if (!check_expressions(made.root_, made.defaults_, reporter)) return std::nullopt;
    return made;
}

void DeviceTemplate::apply(Node& device, const std::string& path, Budget& budget, Reporter& reporter) const {
    const auto bytes = bytes_ + nodes_ * text_of(device, "name").size();
    const auto location = device.find(kTemplateKey)->location;
    Values values(device, defaults_, path, reporter);
    if (nodes_ > budget.nodes || bytes > budget.bytes) {
        reporter.error(
            "file.template.too_large", location,
            {.allowed = std::to_string(kMaxNodes), .path = path + '.' + std::string(kTemplateKey)});
        budget = {};
    } else if (values.complete()) {
        budget.nodes -= nodes_;
        budget.bytes -= bytes;
        for (const auto& [key, value] : root_.entries) {
            const bool variables = key.text == "variables";
            if (!variables && device.find(key.text) != nullptr) continue;
            auto copy = value;
            replace_in(copy, values);
            if (variables)
                add_variables(device, std::move(copy));
            else
                device.entries.emplace_back(key, std::move(copy));
        }
    }
}

void drop_template_keys(Node& device) {
    std::erase_if(device.entries, [](const Node::Entry& entry) {
        return entry.key.text == kTemplateKey || entry.key.text == kParametersKey;
    });
}

}  // namespace takt::file
