#include "takt/file/edit.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <functional>

#include "takt/file/load.hpp"
#include "takt/file/read.hpp"

namespace takt::file {
namespace edit_test {

using model::Node;

Node root_of(const std::string& text) {
    auto loaded = read_project_text("p.yaml", text);
    EXPECT_TRUE(loaded.readable && loaded.findings.empty()) << text;
    return std::move(loaded.document.root);
}

/// The wanted document as YAML in one line; `$from` is a key as others are.
std::string patched(const std::string& text, const std::string& wanted) {
    const auto changed = patched_project(text, root_of(wanted));
    return changed ? *changed
                   : "error " + std::to_string(static_cast<int>(changed.error().kind)) + " " +
                         changed.error().subject;
}

struct Case {
    std::string_view name;
    std::string text;
    std::string wanted;
    std::string expected;
};

void check(std::span<const Case> cases) {
    for (const auto& [name, text, wanted, expected] : cases)
        EXPECT_EQ(patched(text, wanted), expected) << name;
}

TEST(Edit, ReplacesScalarsInPlace) {
    const Case cases[] = {
        {"plain", "a: 1\nb: 2   # two\nc: 3\n", "{a: 1, b: 20, c: 3}", "a: 1\nb: 20   # two\nc: 3\n"},
        {"quotes stay", "lines: [{name: \"x\", port: 'y'}]\n", "{lines: [{$from: 0, name: z, port: it's}]}",
         "lines: [{name: \"z\", port: 'it''s'}]\n"},
        {"quotes where they are needed", "a: x\nb: x\nc: x\n", "{a: '# y', b: 'null', c: 'y: z'}",
         "a: \"# y\"\nb: \"null\"\nc: \"y: z\"\n"},
        {"a number in quotes loses them", "lines:\n  - name: l\n    baud: \"9600\"\n",
         "{lines: [{$from: 0, name: l, baud: 19200}]}", "lines:\n  - name: l\n    baud: 19200\n"},
        {"a text that looks like a number gets quotes", "lines: [{name: l}]\n",
         "{lines: [{$from: 0, name: '10'}]}", "lines: [{name: \"10\"}]\n"},
        {"a boolean stays plain", "derive_timeouts: true\n", "{derive_timeouts: 'false'}",
         "derive_timeouts: false\n"},
        {"in brackets", "a: {b: x, c: [p, q]}\n", "{a: {b: 'x, y', c: [p, 'q]']}}",
         "a: {b: \"x, y\", c: [p, \"q]\"]}\n"},
        {"a literal block", "a: |\n    one\n    two\n# c\nb: 1\n", "{a: \"three\\n\\nfour\\n\", b: 1}",
         "a: |\n    three\n\n    four\n# c\nb: 1\n"},
        {"a folded block", "a: >-\n  one\n  two\nb: 1\n", "{a: \"three\\nfour\", b: 1}",
         "a: >-\n  three\n\n  four\nb: 1\n"},
        {"a block that cannot hold the text", "a: |\n  one\nb: 1\n", "{a: two, b: 1}", "a: two\nb: 1\n"},
        {"a text of several lines", "a: one\n  two  # c\nb: 1\n", "{a: three, b: 1}",
         "a: three  # c\nb: 1\n"},
        {"CR LF", "a: 1\r\nb: 2 # two\r\n", "{a: 1, b: 3}", "a: 1\r\nb: 3 # two\r\n"},
        {"a byte order mark", "\xEF\xBB\xBF# c\na: 1\n", "{a: 2}", "\xEF\xBB\xBF# c\na: 2\n"},
        {"nothing and something", "a:\nb: 1 # c\nc: ~\nd: {e, f: 1}\n",
         "{a: 5, b: null, c: x, d: {e: 2, f: null}}", "a: 5\nb: # c\nc: x\nd: {e: 2, f: null}\n"},
        {"marks of a document", "%YAML 1.2\n---\na: 1\n...\n", "{a: 2}", "%YAML 1.2\n---\na: 2\n...\n"},
        {"without a last line break", "a: 1\nb: 2", "{a: 1, b: 3, c: 4}", "a: 1\nb: 3\nc: 4\n"},
    };
    check(cases);
}

TEST(Edit, AddsAndRemovesKeys) {
    const std::string device =
        "lines:\n  - name: l\n    devices:\n      # the boiler\n      - name: d      # first\n"
        "        address: 1\n        # often\n        poll_period: 1s\n\n        variables: []\n";
    const Case cases[] = {
        {"in the order of the fields", device,
         "{lines: [{$from: 0, name: l, baud: 9600, devices: [{$from: 0, name: d, address: 1, poll_period: "
         "1s, "
         "attempts: 2, variables: []}]}]}",
         "lines:\n  - name: l\n    baud: 9600\n    devices:\n      # the boiler\n      - name: d      # "
         "first\n"
         "        address: 1\n        # often\n        poll_period: 1s\n        attempts: 2\n\n"
         "        variables: []\n"},
        {"a key with its line; the comment above it stays", device,
         "{lines: [{$from: 0, name: l, devices: [{$from: 0, name: d, address: 1, variables: []}]}]}",
         "lines:\n  - name: l\n    devices:\n      # the boiler\n      - name: d      # first\n"
         "        address: 1\n        # often\n\n        variables: []\n"},
        {"the key behind the dash", device,
         "{lines: [{$from: 0, name: l, devices: [{$from: 0, address: 1, poll_period: 1s, variables: []}]}]}",
         "lines:\n  - name: l\n    devices:\n      # the boiler\n      - address: 1\n        # often\n"
         "        poll_period: 1s\n\n        variables: []\n"},
        {"in brackets", "locals:\n  - {name: a, default: 1, comment: x}\n  - { name: b }\n",
         "{locals: [{$from: 0, name: a, type: int, comment: x}, {$from: 1, name: b, type: bool}]}",
         "locals:\n  - {name: a, type: int, comment: x}\n  - { name: b, type: bool }\n"},
        {"all keys in brackets", "host: {jitter: 1ms}\n", "{host: {overhead: 2ms}}",
         "host: {overhead: 2ms}\n"},
        {"none is left", "takt: 1\nhost:\n  jitter: 1ms # c\n", "{takt: 1, host: {}}", "takt: 1\nhost: {}\n"},
    };
    check(cases);
}

TEST(Edit, AddsRemovesAndMovesItems) {
    const std::string block =
        "locals:\n  # all\n  - name: a\n    type: bool\n\n  # the second\n  - name: b # b\n    type: int\n\n"
        "  - name: c\n    type: bool\n# end\n";
    const std::string flow = "locals:\n- {name: a, type: bool}  # first\n# of b\n- {name: b, type: int}\n";
    const Case cases[] = {
        {"add in block style", block,
         "{locals: [{$from: 0, name: a, type: bool}, {$from: 1, name: b, type: int}, {$from: 2, name: c, "
         "type: "
         "bool}, {type: bool, name: d}]}",
         "locals:\n  # all\n  - name: a\n    type: bool\n\n  # the second\n  - name: b # b\n    type: int\n\n"
         "  - name: c\n    type: bool\n\n  - name: d\n    type: bool\n# end\n"},
        {"remove", block, "{locals: [{$from: 0, name: a, type: bool}, {$from: 2, name: c, type: bool}]}",
         "locals:\n  # all\n  - name: a\n    type: bool\n\n  # the second\n\n  - name: c\n    type: bool\n# "
         "end\n"},
        {"move", block,
         "{locals: [{$from: 2, name: c, type: bool}, {$from: 1, name: b, type: int}, {$from: 0, name: a, "
         "type: "
         "bool}]}",
         "locals:\n  # all\n  - name: c\n    type: bool\n\n  # the second\n  - name: b # b\n    type: int\n\n"
         "  - name: a\n    type: bool\n# end\n"},
        {"flow style, dashes below the key", flow,
         "{locals: [{$from: 1, name: b, type: int}, {$from: 0, name: a, type: bool}, {name: c, type: int}]}",
         "locals:\n# of b\n- {name: b, type: int}\n- {name: a, type: bool}  # first\n- {name: c, type: "
         "int}\n"},
        {"all", flow, "{locals: []}", "locals: []\n# of b\n"},
        {"into an empty list", "locals: [] # none\nx: 1\n", "{locals: [{name: a, type: int}], x: 1}",
         "locals: # none\n  - {name: a, type: int}\nx: 1\n"},
        {"a list that was missing", "takt: 1\noutputs: []\n",
         "{takt: 1, lines: [{name: l, devices: [{name: d, "
         "address: 1, variables: [{name: v, type: int}]}]}], outputs: []}",
         "takt: 1\nlines:\n  - name: l\n    devices:\n      - name: d\n        address: 1\n        "
         "variables:\n"
         "          - {name: v, type: int}\noutputs: []\n"},
        {"scalars", "a: [1, 2, 3]\nb:\n  - x\n  - y # y\n  - z\n", "{a: [1, 3], b: [x, w, y, z]}",
         "a: [1, 3]\nb:\n  - x\n  - w\n  - y # y\n  - z\n"},
        {"several lines in brackets", "a: [\n  1, # one\n  2, # two\n  3  # three\n]\n", "{a: [1, 3, 4]}",
         "a: [\n  1, # one\n  3, # two\n  4  # three\n]\n"},
        {"several lines of mappings", "a: [\n  {b: 1}, # one\n  {b: 2}, # two\n]\n",
         "{a: [{$from: 1, b: 2}, {b: 3}]}", "a: [\n  {b: 2}, # two\n  {b: 3},\n]\n"},
    };
    check(cases);
}

TEST(Edit, ChangesTheKindOfAValue) {
    const Case cases[] = {
        {"a scalar becomes a list", "lines:\n  - name: l\n    devices: # none\nx: 1\n",
         "{lines: [{$from: 0, name: l, devices: [{name: d, address: 1}]}], x: 1}",
         "lines:\n  - name: l\n    devices: # none\n      - name: d\n        address: 1\nx: 1\n"},
        {"a block becomes a scalar", "a: # c\n  - 1\n  # two\n  - 2\nb: 1\n", "{a: x, b: 1}",
         "a: x # c\n  # two\nb: 1\n"},
        {"a mapping in brackets becomes a scalar", "a: {b: 1} # c\n", "{a: 5}", "a: 5 # c\n"},
        {"an item", "a:\n  - x # c\n  - y\n", "{a: [{b: 1}, y]}", "a:\n  - {b: 1}\n  - y\n"},
    };
    check(cases);
}

TEST(Edit, RowsTakeThePlaceOfATable) {
    const std::vector<Case> cases{
        {"in a block", "locals: all.csv # c\nlines:\n  - name: l # d\n",
         "{locals: [{name: a, type: bool}], lines: [{$from: 0, name: l}]}",
         "locals: # c\n  - {name: a, type: bool}\nlines:\n  - name: l # d\n"},
        {"of a device in brackets", "lines: [{name: l, devices: [{name: d, variables: b.csv}]}] # c\n",
         "{lines: [{$from: 0, name: l, devices: [{$from: 0, name: d, variables: [{name: a}, {name: b}]}]}]}",
         "lines: [{name: l, devices: [{name: d, variables: [{name: a}, {name: b}]}]}] # c\n"},
    };
    check(cases);
}

TEST(Edit, RefusesWhatItCannotSave) {
    using Kind = EditError::Kind;
    const auto error = [](const std::string& text, const std::string& wanted) {
        const auto changed = patched_project(text, root_of(wanted));
        return changed ? EditError{Kind::differs, *changed} : changed.error();
    };
    EXPECT_EQ(error("a: &x 1\n", "{a: 2}"), EditError{Kind::unreadable});
    EXPECT_EQ(error("a: [\n", "{a: 2}"), EditError{Kind::unreadable});
    EXPECT_EQ(error("- a\n", "{a: 2}"), EditError{Kind::unreadable});
    const std::string items = "a:\n  b:\n    - c: 1\n";
    EXPECT_EQ(error(items, "{a: {b: [{$from: 1, c: 1, d: 1}]}}"), (EditError{Kind::origin, "a.b"}));
    EXPECT_EQ(error(items, "{a: {b: [{$from: x, c: 1, d: 1}]}}"), (EditError{Kind::origin, "a.b"}));
    EXPECT_EQ(error(items, "{a: {b: [{$from: 0, c: 1}, {$from: 0, c: 1}]}}"),
              (EditError{Kind::origin, "a.b"}));
    auto foreign = root_of("a: 1\n");
    foreign.entries[0].value.text = std::string("\0", 1);
    EXPECT_EQ(patched_project("a: 1\n", foreign).error(), (EditError{Kind::differs, "a"}));
}

TEST(Edit, ChangesOneLineOfEachExample) {
    namespace fs = std::filesystem;
    std::size_t files = 0;
    for (const auto& entry : fs::directory_iterator(TAKT_EXAMPLES)) {
        if (entry.path().extension() != ".yaml") continue;
        ++files;
        const auto text = read_file(entry.path().string(), kMaxFileBytes).value();
        // Each scalar in turn gets another text.
        auto root = root_of(text);
        std::vector<Node*> scalars;
        const std::function<void(Node&)> put_origins = [&](Node& node) {
            for (auto& item : node.items) put_origins(item);
            for (auto& [key, value] : node.entries) put_origins(value);
            for (std::size_t i = 0; i < node.items.size(); ++i)
                if (node.items[i].kind == Node::Kind::mapping)
                    node.items[i].entries.push_back(
                        {.key = {.kind = Node::Kind::scalar, .text = std::string(kOriginKey)},
                         .value = {.kind = Node::Kind::scalar, .text = std::to_string(i)}});
        };
        const std::function<void(Node&)> collect = [&](Node& node) {
            if (node.kind == Node::Kind::scalar) scalars.push_back(&node);
            for (auto& item : node.items) collect(item);
            for (auto& [key, value] : node.entries)
                if (key.text != kOriginKey) collect(value);
        };
        put_origins(root);
        collect(root);
        EXPECT_EQ(patched_project(text, root), text);
        for (auto* const scalar : scalars) {
            const auto before = std::exchange(scalar->text, "other");
            const auto changed = patched_project(text, root);
            ASSERT_TRUE(changed) << entry.path() << " " << before << " " << changed.error().subject;
            EXPECT_EQ(std::ranges::count(*changed, '\n'), std::ranges::count(text, '\n')) << before;
            scalar->text = before;
        }
    }
    EXPECT_GE(files, 15U);
}

}  // namespace edit_test
}  // namespace takt::file
