#include "takt/file/document_json.hpp"

#include <optional>

#include "takt/file/schema.hpp"
#include "takt/model/fields.hpp"
#include "yaml/yaml_match.hpp"
#include "yaml/yaml_scalar.hpp"

namespace takt::file {
namespace {

using model::Node;

/// Reads a document. Its state is that of one call.
class DocumentReader {
public:
    Result<Node> read(const Json& json, const Node* original) {
        Node root;
        if (!read(json, original, model::Object::project, root)) return std::unexpected(error_);
        return root;
    }

private:
    using Object = std::optional<model::Object>;

    bool refuse(Code code) {
        error_ = Error{code, std::string_view(path_), {}};
        return false;
    }

    bool read(const Json& json, const Node* original, Object object, Node& node) {
        if (left_-- == 0 || depth_ > kMaxDepth) return refuse(Code::too_long);
        if (const auto* const items = std::get_if<Json::Array>(&json.value()))
            return read_list(*items, original, object, node);
        if (const auto* const entries = std::get_if<Json::Object>(&json.value()))
            return read_mapping(*entries, original, object, node);
        return read_scalar(json, original, node);
    }

    bool read_scalar(const Json& json, const Node* original, Node& node) {
        if (json.is_null()) return true;
        node.kind = Node::Kind::scalar;
        if (const auto* const text = std::get_if<std::string>(&json.value()))
            node.text = *text;
        else
            node.text = json.dump();
        if (original != nullptr && original->kind == Node::Kind::scalar && original->text == node.text)
            node.quoted = original->quoted;
        return true;
    }

    bool read_list(const Json::Array& items, const Node* original, Object object, Node& node) {
        node.kind = Node::Kind::list;
        ++depth_;
        for (std::size_t i = 0; i < items.size(); ++i) {
            const auto size = path_.size();
            path_ += '[' + std::to_string(i) + ']';
            auto& item = node.items.emplace_back();
            if (!read(items[i], origin_of(items[i], i, original), object, item)) return false;
            path_.resize(size);
        }
        --depth_;
        return true;
    }

    // Mappings name the item that they come from; scalars are compared by position.
    static const Node* origin_of(const Json& item, std::size_t index, const Node* original) {
        if (original == nullptr || original->kind != Node::Kind::list) return nullptr;
        if (std::holds_alternative<Json::Object>(item.value())) {
            const auto* const from = item.find(kOriginKey);
            const auto* const number = from == nullptr ? nullptr : std::get_if<std::int64_t>(&from->value());
            const auto* const natural =
                from == nullptr ? nullptr : std::get_if<std::uint64_t>(&from->value());
            if (number == nullptr && natural == nullptr) return nullptr;
            index =
                static_cast<std::size_t>(natural != nullptr ? *natural : static_cast<std::uint64_t>(*number));
        }
        return index < original->items.size() ? &original->items[index] : nullptr;
    }

    bool read_mapping(const Json::Object& entries, const Node* original, Object object, Node& node) {
        node.kind = Node::Kind::mapping;
        if (entries.size() > kMaxEditedKeys) return refuse(Code::too_long);
        ++depth_;
        for (std::size_t i = 0; i < entries.size(); ++i) {
            const auto& [key, value] = entries[i];
            const auto size = path_.size();
            path_.append(path_.empty() ? "" : ".").append(key);
            const auto* const before = original == nullptr || original->kind != Node::Kind::mapping
                                           ? nullptr
                                           : find_near(*original, key, i);
            Node::Entry entry{.key = {.kind = Node::Kind::scalar, .text = key}};
            if (!read(value, before, object_behind(object, key), entry.value)) return false;
            node.entries.push_back(std::move(entry));
            path_.resize(size);
        }
        --depth_;
        // A new text of digits gets quotes when it is saved.
        for (auto& [key, value] : node.entries)
            if (value.kind == Node::Kind::scalar && use_of(object, node, key.text) == ScalarUse::digits)
                value.quoted = true;
        return true;
    }

    std::string path_;
    std::size_t depth_ = 0;
    std::size_t left_ = kMaxNodes;
    Error error_;
};

Json value_json(const Node& node) {
    switch (node.kind) {
        case Node::Kind::null: return {};
        case Node::Kind::scalar: return node.text;
        case Node::Kind::list: {
            Json::Array items;
            for (std::size_t i = 0; i < node.items.size(); ++i) {
                auto item = value_json(node.items[i]);
                if (node.items[i].kind == Node::Kind::mapping) item.set(kOriginKey, std::uint64_t{i});
                items.push_back(std::move(item));
            }
            return Json(std::move(items));
        }
        case Node::Kind::mapping: {
            Json::Object entries;
            for (const auto& [key, value] : node.entries) entries.emplace_back(key.text, value_json(value));
            return Json(std::move(entries));
        }
    }
    return {};
}

}  // namespace

Json document_json(const Node& root) {
    return value_json(root);
}

Result<Node> document_of(const Json& json, const Node* original) {
    return DocumentReader().read(json, original);
}

void without_origins(Node& node) {
    std::erase_if(node.entries, [](const Node::Entry& entry) { return entry.key.text == kOriginKey; });
    for (auto& item : node.items) without_origins(item);
    for (auto& [key, value] : node.entries) without_origins(value);
}

Json without_origins(const Json& json) {
    if (const auto* const items = std::get_if<Json::Array>(&json.value())) {
        Json::Array copy;
        for (const auto& item : *items) copy.push_back(without_origins(item));
        return Json(std::move(copy));
    }
    const auto* const entries = std::get_if<Json::Object>(&json.value());
    if (entries == nullptr) return json;
    Json::Object copy;
    for (const auto& [key, value] : *entries)
        if (key != kOriginKey) copy.emplace_back(key, without_origins(value));
    return Json(std::move(copy));
}

}  // namespace takt::file
