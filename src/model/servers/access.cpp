#include <algorithm>
#include <utility>

#include "servers/interpretation.hpp"
#include "takt/model/nearest.hpp"

namespace takt::model {
namespace {

constexpr std::uint8_t kReadingFunctions[] = {1, 2, 3, 4, 7, 11, 12, 17, 20, 24};
constexpr std::uint8_t kWritingFunctions[] = {5, 6, 15, 16, 21, 22, 23};
constexpr std::size_t kMostEntries = 256;

/// Calls `each` with every scalar of a list. A refused one is reported with `rule`; a text that is no number
/// is reported as an unknown word if `words` are allowed.
template <class Each>
void for_each_scalar(Interpretation& state, Reader& reader, std::string_view key, Rule rule,
                     std::string_view allowed, std::span<const std::string_view> words, const Each& each) {
    const Node* const list = reader.list(key);
    if (list == nullptr) return;
    if (list->items.empty()) reader.report(Rule::field_empty, key, {}, {{"key", std::string(key)}});
    for (std::size_t i = 0; i < list->items.size(); ++i) {
        const auto& item = list->items[i];
        if (i < kMostEntries && item.kind == Node::Kind::scalar && each(item.text)) continue;
        const bool no_word = !words.empty() && i < kMostEntries && !parse_integer(item.text);
        Arguments arguments;
        if (no_word) arguments = {{"nearest", std::string(nearest(item.text, words))}};
        state.findings.add(no_word ? Rule::field_unknown_word : rule, item.location,
                           reader.path_of(key) + "[" + std::to_string(i) + "]", item.text,
                           std::string(allowed), std::move(arguments));
    }
}

void read_peers(Interpretation& state, Reader& reader, AccessRule& rule) {
    rule.every_peer = !reader.given("peers");
    for_each_scalar(state, reader, "peers", Rule::peer_malformed, "192.0.2.0/24, 2001:db8::/32, serial", {},
                    [&rule](const std::string& text) {
                        if (text == "serial") return rule.serial = true;
                        const auto network = parse_network(text);
                        if (network) rule.networks.push_back(*network);
                        return network.has_value();
                    });
}

/// `none` is the role of a client whose certificate has none.
void read_roles(Interpretation& state, Reader& reader, AccessRule& rule) {
    constexpr std::size_t kLongest = 64;
    for_each_scalar(state, reader, "roles", Rule::field_out_of_range, "none, 1..64 bytes", {},
                    [&rule](const std::string& text) {
                        if (text.empty() || text.size() > kLongest) return false;
                        rule.roles.push_back(text == "none" ? "" : text);
                        return true;
                    });
}

void read_rule_functions(Interpretation& state, Reader& reader, AccessRule& rule) {
    rule.every_function = !reader.given("functions");
    const auto add = [&rule](std::span<const std::uint8_t> codes) {
        rule.functions.insert(rule.functions.end(), codes.begin(), codes.end());
        return true;
    };
    constexpr std::string_view kWords[] = {"read", "write"};
    for_each_scalar(state, reader, "functions", Rule::field_out_of_range, "read, write, 1..127", kWords,
                    [&](const std::string& text) {
                        // Function 43 reads with MEI type 14; the other types may write.
                        rule.identification = rule.identification || text == "read";
                        rule.other_encapsulated = rule.other_encapsulated || text == "write";
                        if (text == "read") return add(kReadingFunctions);
                        if (text == "write") return add(kWritingFunctions);
                        const auto code = parse_integer(text);
                        if (!code || code->negative || code->magnitude < 1 || code->magnitude > 127)
                            return false;
                        rule.functions.push_back(static_cast<std::uint8_t>(code->magnitude));
                        return true;
                    });
}

void read_rule_units(Interpretation& state, Reader& reader, AccessRule& rule) {
    if (!reader.given("units")) return;
    rule.units = read_item_ranges(state, reader, "units");
    for (const auto& range : rule.units)
        if (range.last > 255)
            state.findings.add(Rule::field_out_of_range, reader.value("units")->location,
                               reader.path_of("units"), std::to_string(range.last), "0..255");
}

void read_items(Interpretation& state, Reader& reader, AccessRule& rule) {
    rule.area = reader.choice<wire::Area>("area");
    if (!reader.given("items")) return;
    rule.items = read_item_ranges(state, reader, "items");
    // Without the area the rule would apply to more items than it seems to.
    if (!reader.given("area")) reader.report(Rule::field_missing, "area", {}, {{"key", "area"}});
}

void read_rate(Reader& reader, AccessRule& rule) {
    const auto rate = reader.integer("rate");
    const auto burst = reader.integer("burst");
    if (rate)
        rule.rate =
            AccessRate{static_cast<std::uint32_t>(*rate), static_cast<std::uint32_t>(burst.value_or(*rate))};
    if (!reader.given("rate") && reader.given("burst")) reader.report_without_effect("burst", "rate: none");
    if (rate && rule.permission == AccessPermission::deny) reader.report_without_effect("rate", "rule: deny");
}

AccessRule interpret_rule(Interpretation& state, const Node& node, const std::string& path) {
    Reader reader(state.findings, node, path, Object::access, state.context);
    AccessRule rule;
    rule.location = node.location;
    read_peers(state, reader, rule);
    read_roles(state, reader, rule);
    read_rule_units(state, reader, rule);
    read_rule_functions(state, reader, rule);
    read_items(state, reader, rule);
    rule.permission = reader.choice<AccessPermission>("rule").value_or(AccessPermission::deny);
    read_rate(reader, rule);
    return rule;
}

std::vector<AccessRule> interpret_rules(Interpretation& state, const Node& list, const std::string& path) {
    std::vector<AccessRule> rules;
    if (list.items.empty())
        state.findings.add(Rule::field_empty, list.location, path, "", {}, {{"key", "access"}});
    for (std::size_t i = 0; i < list.items.size(); ++i) {
        const auto& item = list.items[i];
        const auto at = path + "[" + std::to_string(i) + "]";
        if (i >= kMostEntries) {
            state.findings.add(Rule::field_out_of_range, item.location, at, std::to_string(list.items.size()),
                               "1.." + std::to_string(kMostEntries));
            break;
        }
        if (is_mapping(state, item, at)) rules.push_back(interpret_rule(state, item, at));
    }
    return rules;
}

}  // namespace

std::vector<AccessRule> read_access(Interpretation& state, Reader& reader) {
    const Node* const list = reader.list("access");
    if (list == nullptr) return {};
    return interpret_rules(state, *list, reader.path_of("access"));
}

CheckedAccess interpret_access(const Document& document) {
    Interpretation state(document);
    CheckedAccess checked;
    if (document.root.kind == Node::Kind::list)
        checked.rules = interpret_rules(state, document.root, "access");
    else
        state.findings.add(Rule::field_not_a_list, document.root.location, "access", document.root.text);
    checked.findings = std::move(state.findings).take();
    return checked;
}

}  // namespace takt::model
