// Any document is accepted or gets findings: none does harm, and the number of findings is bounded.
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <set>
#include <string>
#include <vector>

#include "flow.hpp"
#include "takt/model/fields.hpp"
#include "takt/model/findings.hpp"

namespace takt::model::test {
namespace random_test {

std::vector<std::string> keys() {
    std::vector<std::string> all{"", "x", "servers"};
    for (const auto object : kObjects)
        for (const auto& field : fields(object)) all.emplace_back(field.key);
    return all;
}

std::vector<std::string> scalars() {
    std::vector<std::string> all{
        "",     "0",     "1",   "-1",    "16",    "247",        "65535",      "65536",
        "0x10", "010",   "1.5", "1e99",  "100ms", "0ms",        "25h",        "true",
        "yes",  "N",     "go",  "40001", "00001", "465536",     "\xff\xfe",   "9999999999999999999999",
        "none", "0..99", "9-3", "..",    "-",     "0x10..0x1F", "65530-65536"};
    for (const std::span<const std::string_view> words :
         {std::span<const std::string_view>(kTypes), std::span<const std::string_view>(kAreas),
          std::span<const std::string_view>(kTransports), std::span<const std::string_view>(kFramings),
          std::span<const std::string_view>(kStrategies), std::span<const std::string_view>(kWriteSingle),
          std::span<const std::string_view>(kReadFunctions),
          std::span<const std::string_view>(kWriteFunctions), std::span<const std::string_view>(kProfiles)})
        all.insert(all.end(), words.begin(), words.end());
    return all;
}

Node random_scalar() {
    static const auto kTexts = scalars();
    return {.kind = Node::Kind::scalar,
            .location = {*rc::gen::inRange(0U, 4U), *rc::gen::inRange(0U, 50U), 1},
            .text = *rc::gen::elementOf(kTexts),
            .quoted = *rc::gen::arbitrary<bool>()};
}

Node random_tree(int depth) {
    static const auto kKeys = keys();
    const auto kind = depth == 0 ? 1 : *rc::gen::inRange(0, 8);
    if (kind == 0) return {};
    if (kind < 4) return random_scalar();
    Node node{.kind = kind < 6 ? Node::Kind::list : Node::Kind::mapping};
    for (int i = *rc::gen::inRange(0, 6); i > 0; --i) {
        if (node.kind == Node::Kind::list)
            node.items.push_back(random_tree(depth - 1));
        else
            node.entries.emplace_back(Node{.kind = Node::Kind::scalar, .text = *rc::gen::elementOf(kKeys)},
                                      random_tree(depth - 1));
    }
    return node;
}

Node random_object(Object object, std::string_view list, Node item);

/// A value for a field: mostly a scalar, and a list or the keys of its mapping where those are allowed.
Node random_value(const Field& field) {
    const int shape = *rc::gen::inRange(0, 4);
    if (field.object && shape < 2) return random_object(*field.object, "", {});
    return field.kind == Kind::ranges && shape > 0 ? random_tree(2) : random_scalar();
}

/// An object with the fields of its kind, most of them with some value.
Node random_object(Object object, std::string_view list, Node item) {
    Node node{.kind = Node::Kind::mapping};
    for (const auto& field : fields(object))
        if (field.kind != Kind::list && *rc::gen::inRange(0, 3) != 0)
            node.entries.emplace_back(Node{.kind = Node::Kind::scalar, .text = std::string(field.key)},
                                      random_value(field));
    if (list.empty()) return node;
    Node items{.kind = Node::Kind::list};
    items.items = {item, item, std::move(item)};
    node.entries.emplace_back(Node{.kind = Node::Kind::scalar, .text = std::string(list)}, std::move(items));
    return node;
}

void judge(const AreaRanges& ranges) {
    for (const auto& area : ranges)
        for (std::size_t i = 0; i < area.size(); ++i) {
            RC_ASSERT(area[i].first <= area[i].last);
            if (i > 0) RC_ASSERT(area[i].first > area[i - 1].last + 1);
        }
}

/// Invariants of every project, also of one with findings.
void judge(const Project& project) {
    RC_ASSERT(project.backoff.first <= project.backoff.limit);
    RC_ASSERT(project.faults.every.count() > 0);
    for (const auto& line : project.lines)
        for (const auto& device : line.devices) {
            judge(device.readable);
            judge(device.no_read);
            RC_ASSERT(device.in_flight >= 1 && device.in_flight <= 16);
            if (device.backoff) RC_ASSERT(device.backoff->first <= device.backoff->limit);
        }
}

void judge(const Document& document) {
    const auto checked = interpret(document);
    RC_ASSERT(checked.findings.size() <= 1000U);
    for (const auto& finding : checked.findings) {
        const auto codes = finding_codes();
        RC_ASSERT(std::ranges::find(codes, std::string_view(finding.code)) != codes.end());
        RC_ASSERT(finding.value.size() <= 210U);
    }
    judge(checked.project);
    if (checked.has_errors()) return;
    for (const auto& line : checked.project.lines)
        for (const auto& device : line.devices)
            for (const auto& variable : device.variables) {
                RC_ASSERT(variable.start() + variable.items() <= 65536);
                RC_ASSERT(variable.scale != 0);
            }
}

RC_GTEST_PROP(Random, TreesOfKnownKeys, ()) {
    judge({{"a", "b"}, random_tree(7)});
}

RC_GTEST_PROP(Random, ObjectsOfTheRightShape, ()) {
    auto variable = random_object(Object::variable, "", {});
    auto device = random_object(Object::device, "variables", std::move(variable));
    auto line = random_object(Object::line, "devices", std::move(device));
    auto project = random_object(Object::project, "lines", std::move(line));
    judge({{"a", "b"}, std::move(project)});
}

RC_GTEST_PROP(Random, ADeviceInAGoodProject, ()) {
    auto source = document({});
    auto device = random_object(Object::device, "variables", random_object(Object::variable, "", {}));
    source.root.entries[1].value.items[0].entries[3].value.items[0] = std::move(device);
    judge(source);
}

RC_GTEST_PROP(Random, RangesSayWhatTheirItemsSay, ()) {
    std::set<unsigned> items;
    std::string list;
    for (int i = *rc::gen::inRange(1, 12); i > 0; --i) {
        const auto first = *rc::gen::inRange(0U, 40U);
        const auto last = first + *rc::gen::inRange(0U, 9U);
        const auto form = *rc::gen::elementOf(std::vector<std::string>{"..", "-", " .. ", "[", ""});
        const auto a = std::to_string(first);
        const auto b = std::to_string(form.empty() ? first : last);
        list += (form == "[" ? "[" + a + ", " + b + "]" : form.empty() ? a : a + form + b) + ", ";
        for (auto item = first; item <= (form.empty() ? first : last); ++item) items.insert(item);
    }
    const auto checked =
        interpret(document({.device = "{strategy: optimal, no_read: {input_register: [" + list + "]}}"}));
    RC_ASSERT(checked.findings.empty());
    const auto& ranges = checked.project.lines[0].devices[0].no_read;
    judge(ranges);
    std::set<unsigned> found;
    for (const auto& range : ranges[static_cast<std::size_t>(wire::Area::input_register)])
        for (unsigned item = range.first; item <= range.last; ++item) found.insert(item);
    RC_ASSERT(found == items);
    RC_ASSERT(ranges[0].empty() && ranges[1].empty() && ranges[3].empty());
}

RC_GTEST_PROP(Random, AVariableInAGoodProject, ()) {
    auto source = document({});
    source.root.entries[1].value.items[0].entries[3].value.items[0].entries[2].value.items[0] =
        random_object(Object::variable, "", {});
    judge(source);
}

}  // namespace random_test
}  // namespace takt::model::test
