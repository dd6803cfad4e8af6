#include "flow.hpp"

#include <algorithm>

namespace takt::model::test {
namespace {

class Parser {
public:
    Parser(std::string_view text, std::uint32_t file) : text_(text), file_(file) {}

    Node value(std::string_view ends) {
        skip_space();
        Node node{.location = location(), .cell = file_ != 0};
        if (peek() == '{') return mapping(std::move(node));
        if (peek() == '[') return list(std::move(node));
        if (peek() == '"') return quoted(std::move(node));
        while (peek() != '\0' && ends.find(peek()) == std::string_view::npos) node.text += take();
        node.text.erase(node.text.find_last_not_of(" \n") + 1);
        if (!node.text.empty()) node.kind = Node::Kind::scalar;
        return node;
    }

private:
    Node mapping(Node node) {
        node.kind = Node::Kind::mapping;
        for (take(), skip_space(); peek() != '}' && peek() != '\0'; skip_space()) {
            Node key = value(":");
            take();
            node.entries.emplace_back(std::move(key), value(",}"));
            skip_space();
            if (peek() == ',') take();
        }
        take();
        return node;
    }

    Node list(Node node) {
        node.kind = Node::Kind::list;
        for (take(), skip_space(); peek() != ']' && peek() != '\0'; skip_space()) {
            node.items.push_back(value(",]"));
            skip_space();
            if (peek() == ',') take();
        }
        take();
        return node;
    }

    Node quoted(Node node) {
        node.kind = Node::Kind::scalar;
        node.quoted = true;
        for (take(); peek() != '"' && peek() != '\0';) node.text += take();
        take();
        return node;
    }

    void skip_space() {
        while (peek() == ' ' || peek() == '\n') take();
    }

    [[nodiscard]] SourceLocation location() const { return {file_, line_, column_}; }
    [[nodiscard]] char peek() const { return at_ < text_.size() ? text_[at_] : '\0'; }
    char take() {
        const char c = peek();
        if (c == '\0') return c;
        ++at_;
        line_ += c == '\n' ? 1 : 0;
        column_ = c == '\n' ? 1 : column_ + 1;
        return c;
    }

    std::string_view text_;
    std::uint32_t file_;
    std::size_t at_ = 0;
    std::uint32_t line_ = 1;
    std::uint32_t column_ = 1;
};

Node list_of(Node item) {
    Node list{.kind = Node::Kind::list, .location = item.location};
    list.items.push_back(std::move(item));
    return list;
}

Node with(Node mapping, std::string_view key, Node value) {
    mapping.entries.emplace_back(Node{.kind = Node::Kind::scalar, .text = std::string(key)},
                                 std::move(value));
    return mapping;
}

}  // namespace

Node flow(std::string_view text, std::uint32_t file) {
    return Parser(text, file).value("");
}

Node changed(Node base, const Node& changes) {
    for (const auto& [key, value] : changes.entries) {
        const auto at =
            std::ranges::find(base.entries, key.text, [](const auto& entry) { return entry.key.text; });
        if (value.text == "~") {
            if (at != base.entries.end()) base.entries.erase(at);
        } else if (at != base.entries.end()) {
            at->value = value;
        } else {
            base.entries.emplace_back(key, value);
        }
    }
    return base;
}

Document document(const Changes& changes) {
    const auto part = [](std::string_view base, std::string_view change) {
        return changed(flow(base), flow(change));
    };
    auto variable = part("{name: V, type: int, register: 0, read: 0x03}", changes.variable);
    auto device = with(flow("{name: D, address: 16}"), "variables", list_of(std::move(variable)));
    device = changed(std::move(device), flow(changes.device));
    auto line =
        with(flow("{name: N, transport: serial, port: /dev/ttyS0}"), "devices", list_of(std::move(device)));
    line = changed(std::move(line), flow(changes.line));
    auto locals = flow("[{name: go, type: bool}, {name: state, type: int}]");
    locals.items.push_back(part("{name: L, type: int}", changes.local));
    auto project =
        with(with(flow("{takt: 1}"), "lines", list_of(std::move(line))), "locals", std::move(locals));
    return {.files = {"project.yaml", "table.csv"},
            .root = changed(std::move(project), flow(changes.project))};
}

}  // namespace takt::model::test
