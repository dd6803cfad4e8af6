// Random documents in random styles, and random changes: the new text reads as the wanted document, and lines
// of items that did not change are still there.
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "takt/file/edit.hpp"

namespace takt::file {
namespace edit_random_test {

using model::Node;

const std::vector<std::string> kScalars{"1",
                                        "0x10",
                                        "100ms",
                                        "x y",
                                        "it's",
                                        "a: b",
                                        "# c",
                                        "null",
                                        "~",
                                        "",
                                        "true",
                                        "-",
                                        "- a",
                                        "[",
                                        "}",
                                        "a,b",
                                        "?",
                                        "\"q\"",
                                        "кот",
                                        " x",
                                        "x ",
                                        "a\nb",
                                        "a\n",
                                        "\n",
                                        "%a",
                                        "@",
                                        "a #b",
                                        "a#b",
                                        "|",
                                        ">",
                                        "&x",
                                        "*x",
                                        "!t",
                                        "---",
                                        "...",
                                        "x:",
                                        ":x",
                                        "{a: 1}",
                                        "\ttab",
                                        "a\tb",
                                        "'",
                                        "\\",
                                        "40001",
                                        "no",
                                        "2026-01-01",
                                        "0,5",
                                        "line\n\n\nother\n",
                                        "  indented\nnot"};
const std::vector<std::string> kKeys{"takt",   "name",    "lines",   "devices", "variables",
                                     "type",   "comment", "default", "locals",  "host",
                                     "jitter", "x",       "кл",      "a b",     "0"};

Node scalar(std::string text) {
    return {.kind = Node::Kind::scalar, .text = std::move(text)};
}

Node random_node(int depth, bool nulls = true) {
    const int kind = depth == 0 ? *rc::gen::inRange(0, 5) : *rc::gen::inRange(0, 9);
    if (kind == 0 && nulls) return {};
    if (kind < 5) return scalar(*rc::gen::elementOf(kScalars));
    Node node{.kind = kind < 7 ? Node::Kind::list : Node::Kind::mapping};
    const int count = *rc::gen::inRange(0, 5);
    for (int i = 0; i < count; ++i) {
        if (node.kind == Node::Kind::list) {
            node.items.push_back(random_node(depth - 1));
        } else {
            auto key = *rc::gen::elementOf(kKeys);
            if (node.find(key) == nullptr) node.entries.emplace_back(scalar(key), random_node(depth - 1));
        }
    }
    return node;
}

Node random_document() {
    Node root{.kind = Node::Kind::mapping};
    root.entries.emplace_back(scalar("takt"), scalar("1"));
    for (const auto* key : {"lines", "locals", "x"}) root.entries.emplace_back(scalar(key), random_node(4));
    return root;
}

/// Writes a document in random styles, with comments.
class RandomWriter {
public:
    std::string write(const Node& root) {
        if (*rc::gen::inRange(0, 4) == 0) text_ = "\xEF\xBB\xBF";
        if (*rc::gen::inRange(0, 4) == 0) text_ += "# head" + break_ + "---" + break_;
        block(root, 0);
        if (*rc::gen::inRange(0, 4) == 0) text_ += "# tail";
        return std::move(text_);
    }

private:
    static bool chance(int of) { return *rc::gen::inRange(0, of) == 0; }
    std::string space() { return std::string(static_cast<std::size_t>(*rc::gen::inRange(1, 3)), ' '); }

    std::string quoted(const std::string& text) {
        std::string result = "\"";
        for (const char c : text) {
            if (c == '"' || c == '\\') result += '\\';
            result += c == '\n' ? std::string("\\n") : c == '\t' ? std::string("\\t") : std::string(1, c);
        }
        return result + "\"";
    }

    std::string scalar_text(const std::string& text) {
        const bool simple = std::ranges::all_of(
            text, [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9'); });
        const bool plain = simple && !text.empty() && text != "null";
        if (plain && chance(2)) return text;
        if (text.find_first_of("\n\t") == std::string::npos && chance(2)) {
            std::string single = "'";
            for (const char c : text) single.append(c == '\'' ? 2 : 1, c);
            return single + "'";
        }
        return quoted(text);
    }

    std::string flow(const Node& node) {
        const std::string gap = chance(6) ? " # f" + break_ + "              " : chance(3) ? " " : "";
        std::string inside;
        for (const auto& item : node.items) inside += (inside.empty() ? gap : "," + space()) + flow(item);
        for (const auto& [key, value] : node.entries)
            inside += (inside.empty() ? gap : "," + space()) + scalar_text(key.text) + ": " + flow(value);
        if (!inside.empty() && chance(6)) inside += ",";
        if (!inside.empty() && chance(6)) inside += " # l" + break_ + "              ";
        switch (node.kind) {
            case Node::Kind::null: return chance(2) ? "~" : "null";
            case Node::Kind::scalar: return scalar_text(node.text);
            case Node::Kind::list: return "[" + inside + "]";
            case Node::Kind::mapping: return "{" + inside + "}";
        }
        return {};
    }

    void indent(std::size_t column) { text_.append(column, ' '); }
    void comment() {
        if (chance(4)) text_ += "  # behind";
        text_ += break_;
    }
    void lead(std::size_t column) {
        if (chance(6)) text_ += break_;
        if (chance(6)) {
            indent(column);
            text_ += "# above" + break_;
        }
    }

    void value(const Node& node, std::size_t column, bool after_dash) {
        const bool empty = node.items.empty() && node.entries.empty();
        const bool collection = node.kind == Node::Kind::list || node.kind == Node::Kind::mapping;
        if (collection && !empty && !chance(3)) {
            if (after_dash && chance(2)) {
                text_ += " ";
                return block(node, column + 2, true);
            }
            comment();
            const auto inner =
                column + (node.kind == Node::Kind::list && !after_dash ? chance(2) ? 0U : 2U : 2U);
            return block(node, inner);
        }
        const auto& text = node.text;
        if (node.kind == Node::Kind::scalar && text.ends_with('\n') &&
            text.find("\n\n") == std::string::npos && text.size() > 1 && !text.starts_with(' ')) {
            text_ += " |" + break_;
            std::string line;
            for (const char c : text) {
                if (c != '\n') {
                    line += c;
                    continue;
                }
                indent(column + 2);
                text_ += line + break_;
                line.clear();
            }
            return;
        }
        if (node.kind == Node::Kind::null && chance(2)) return comment();
        text_ += space() + flow(node);
        comment();
    }

    void block(const Node& node, std::size_t column, bool in_line = false) {
        bool first = in_line;
        const auto begin = [&] {
            if (!first) {
                lead(column);
                indent(column);
            }
            first = false;
        };
        for (const auto& item : node.items) {
            begin();
            text_ += "-";
            value(item, column, true);
        }
        for (const auto& [key, item] : node.entries) {
            begin();
            text_ += (key.text == "a b" || key.text == "кл" ? key.text : scalar_text(key.text)) + ":";
            value(item, column, false);
        }
    }

    const std::string break_ = chance(3) ? "\r\n" : "\n";
    std::string text_;
};

void put_origins(Node& node) {
    for (auto& item : node.items) put_origins(item);
    for (auto& [key, value] : node.entries) put_origins(value);
    for (std::size_t i = 0; i < node.items.size(); ++i)
        if (node.items[i].kind == Node::Kind::mapping)
            node.items[i].entries.emplace_back(scalar(std::string(kOriginKey)), scalar(std::to_string(i)));
}

void change(Node& node, int depth) {
    const auto members = static_cast<int>(node.items.size() + node.entries.size());
    if (members == 0 || *rc::gen::inRange(0, 3) == 0) {
        switch (*rc::gen::inRange(0, 3)) {
            case 0: node = random_node(depth); return;
            case 1:
                if (node.kind == Node::Kind::mapping) {
                    const auto key = *rc::gen::elementOf(kKeys);
                    if (node.find(key) == nullptr)
                        node.entries.emplace_back(scalar(key), random_node(depth - 1));
                } else if (node.kind == Node::Kind::list) {
                    const auto place = *rc::gen::inRange(0, static_cast<int>(node.items.size()) + 1);
                    node.items.insert(node.items.begin() + place, random_node(depth - 1));
                }
                return;
            default: break;
        }
    }
    if (members == 0) return;
    const auto at = *rc::gen::inRange(0, members);
    if (node.kind == Node::Kind::list) {
        switch (*rc::gen::inRange(0, 4)) {
            case 0: node.items.erase(node.items.begin() + at); return;
            case 1: std::swap(node.items[static_cast<std::size_t>(at)], node.items[0]); return;
            default: change(node.items[static_cast<std::size_t>(at)], depth - 1);
        }
    } else {
        auto& entry = node.entries[static_cast<std::size_t>(at)];
        if (entry.key.text == kOriginKey) return;
        if (*rc::gen::inRange(0, 5) == 0)
            node.entries.erase(node.entries.begin() + at);
        else
            change(entry.value, std::max(depth - 1, 0));
    }
}

RC_GTEST_PROP(EditRandom, TheNewTextReadsAsTheWantedDocument, ()) {
    const auto document = random_document();
    const auto text = RandomWriter().write(document);
    const auto read = read_project_text("p.yaml", text);
    if (!read.findings.empty()) RC_LOG() << text << read.findings[0].code;
    RC_ASSERT(read.findings.empty());
    RC_LOG() << "---- old\n" << text << "\n";
    RC_ASSERT(same_document(read.document.root, document));
    auto wanted = document;
    put_origins(wanted);
    for (int changes = *rc::gen::inRange(0, 5); changes > 0; --changes) change(wanted, 4);
    if (wanted.kind != Node::Kind::mapping) RC_DISCARD("the root");
    const auto changed = patched_project(text, wanted);
    if (!changed) {
        RC_LOG() << static_cast<int>(changed.error().kind) << " " << changed.error().subject << "\n";
        RC_FAIL("refused");
    }
    RC_LOG() << "---- new\n" << *changed << "\n";
    RC_ASSERT(same_document(read_project_text("p.yaml", *changed).document.root, wanted));
    RC_ASSERT(text.contains("\r\n") == changed->contains("\r\n") || !changed->contains('\n'));
    RC_ASSERT(!changed->contains("\r\n") ||
              std::ranges::count(*changed, '\r') == std::ranges::count(*changed, '\n'));
}

// The lines of a mapping at the root, whose keys do not change.
RC_GTEST_PROP(EditRandom, UnchangedEntriesKeepTheirBytes, ()) {
    auto document = random_document();
    document.entries.emplace_back(scalar("z"), scalar("end"));
    const auto text = RandomWriter().write(document);
    auto wanted = document;
    put_origins(wanted);
    change(wanted.entries[1].value, 3);  // lines
    const auto changed = patched_project(text, wanted);
    if (!changed) {
        RC_LOG() << text << "\n" << static_cast<int>(changed.error().kind) << " " << changed.error().subject;
        RC_FAIL("refused");
    }
    // The whole text before and behind that entry stays.
    const auto same_front =
        static_cast<std::size_t>(std::ranges::mismatch(text, *changed).in1 - text.begin());
    const auto same_back = static_cast<std::size_t>(
        std::mismatch(text.rbegin(), text.rend(), changed->rbegin(), changed->rend()).first - text.rbegin());
    RC_LOG() << text << "\n----\n" << *changed;
    const auto line_of = [&](const std::string& key) {
        return std::min({text.find("\n" + key), text.find("\n'" + key), text.find("\n\"" + key)});
    };
    const auto lines = line_of("lines");
    const auto locals = line_of("locals");
    RC_ASSERT(same_front >= std::min(lines, text.size()));
    RC_ASSERT(locals == std::string::npos || same_back >= text.size() - locals || text == *changed);
}

}  // namespace edit_random_test
}  // namespace takt::file
