// Whatever stands in a file, it is judged: no document does harm, and what is said about it is bounded.
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <string>
#include <vector>

#include "flow.hpp"
#include "takt/model/fields.hpp"
#include "takt/model/findings.hpp"

namespace takt::model::test {
namespace {

std::vector<std::string> keys() {
    std::vector<std::string> all{"", "x", "servers"};
    for (const auto object : {Object::project, Object::line, Object::device, Object::variable, Object::local})
        for (const auto& field : fields(object)) all.emplace_back(field.key);
    return all;
}

std::vector<std::string> scalars() {
    std::vector<std::string> all{"",      "0",     "1",     "-1",     "16",       "247",
                                 "65535", "65536", "0x10",  "010",    "1.5",      "1e99",
                                 "100ms", "0ms",   "25h",   "true",   "yes",      "N",
                                 "go",    "40001", "00001", "465536", "\xff\xfe", "9999999999999999999999",
                                 "none"};
    for (const std::span<const std::string_view> words :
         {std::span<const std::string_view>(kTypes), std::span<const std::string_view>(kAreas),
          std::span<const std::string_view>(kTransports), std::span<const std::string_view>(kFramings),
          std::span<const std::string_view>(kStrategies), std::span<const std::string_view>(kReadFunctions),
          std::span<const std::string_view>(kWriteFunctions), std::span<const std::string_view>(kProfiles)})
        all.insert(all.end(), words.begin(), words.end());
    return all;
}

Node random_scalar() {
    static const auto kTexts = scalars();
    return {.kind = Node::Kind::scalar,
            .place = {*rc::gen::inRange(0U, 4U), *rc::gen::inRange(0U, 50U), 1},
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

/// An object with the fields of its kind, most of them with some scalar.
Node random_object(Object object, std::string_view list, Node item) {
    Node node{.kind = Node::Kind::mapping};
    for (const auto& field : fields(object))
        if (field.kind != Kind::list && *rc::gen::inRange(0, 3) != 0)
            node.entries.emplace_back(Node{.kind = Node::Kind::scalar, .text = std::string(field.key)},
                                      random_scalar());
    if (list.empty()) return node;
    Node items{.kind = Node::Kind::list};
    items.items = {item, item, std::move(item)};
    node.entries.emplace_back(Node{.kind = Node::Kind::scalar, .text = std::string(list)}, std::move(items));
    return node;
}

void judge(const Document& document) {
    const auto checked = interpret(document);
    RC_ASSERT(checked.findings.size() <= 1000U);
    for (const auto& finding : checked.findings) {
        const auto codes = finding_codes();
        RC_ASSERT(std::ranges::find(codes, std::string_view(finding.code)) != codes.end());
        RC_ASSERT(finding.value.size() <= 210U);
    }
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

RC_GTEST_PROP(Random, AVariableInAGoodProject, ()) {
    auto source = document({});
    source.root.entries[1].value.items[0].entries[3].value.items[0].entries[2].value.items[0] =
        random_object(Object::variable, "", {});
    judge(source);
}

}  // namespace
}  // namespace takt::model::test
