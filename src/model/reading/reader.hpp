// Reads the fields of one object of a document with the field table, and reports their errors.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "reading/rules.hpp"
#include "takt/model/document.hpp"
#include "takt/model/fields.hpp"
#include "takt/model/scalar.hpp"

namespace takt::model {

/// The write or read function of a variable as in the file: `none` is no function.
struct FunctionChoice {
    std::optional<wire::Function> function;
};

/// Reads one object, a mapping. A getter returns nothing if the key is absent or its value invalid; the
/// latter is reported. Keys must be in the table with the kind of the getter.
class Reader {
public:
    /// Reports unknown and missing keys.
    /// @param node     a mapping; must outlive the reader
    /// @param path     "lines[0].devices[2]"; empty for the project itself
    /// @param context  evaluated when a field is read; may be filled in meanwhile
    Reader(Findings& findings, const Node& node, std::string path, Object object, const Context& context);

    std::optional<std::int64_t> integer(std::string_view key);
    std::optional<Duration> duration(std::string_view key);
    /// Of a duration with words: whether one of them is written instead.
    [[nodiscard]] bool word_instead(std::string_view key) const;
    std::optional<bool> boolean(std::string_view key);
    std::optional<double> number(std::string_view key);
    std::optional<std::string> text(std::string_view key);
    std::optional<FunctionChoice> function(std::string_view key);
    /// A word, as in the table.
    std::optional<std::string_view> word(std::string_view key);
    /// A word as an enum with the values in the order of the table.
    template <class E>
    std::optional<E> choice(std::string_view key) {
        const auto found = word_index(key);
        if (!found) return std::nullopt;
        return static_cast<E>(*found);
    }
    /// A list; an empty one for an empty key where that is allowed.
    const Node* list(std::string_view key);
    /// The mapping of a key, for a reader of its own.
    const Node* mapping(std::string_view key);
    /// Any scalar.
    const Node* scalar(std::string_view key);

    /// Whether the value of the key is a mapping.
    [[nodiscard]] bool is_mapping(std::string_view key) const {
        return given(key) && value(key)->kind == Node::Kind::mapping;
    }
    /// Whether the key has a value, valid or not.
    [[nodiscard]] bool given(std::string_view key) const { return value(key) != nullptr; }
    /// The value of a key as written; nullptr if there is none.
    [[nodiscard]] const Node* value(std::string_view key) const;

    /// Whether an unknown key was surely a misspelling of this one: the missing key is then already reported.
    [[nodiscard]] bool misspelt(std::string_view key) const;

    [[nodiscard]] Kind kind(std::string_view key) const { return field(key).kind; }
    /// The allowed values of a key's field, as text.
    [[nodiscard]] std::string allowed_text(std::string_view key) const {
        return allowed(field(key), context_);
    }

    [[nodiscard]] const Node& node() const { return node_; }
    [[nodiscard]] Object object() const { return object_; }
    [[nodiscard]] std::string path_of(std::string_view key) const;

    /// Reports at the value of a key, or at the object if the key is absent.
    void report(Rule rule, std::string_view key, std::string allowed = {}, Arguments arguments = {});
    /// Reports that a given key has no effect with another setting ("transport: tcp").
    void report_without_effect(std::string_view key, std::string condition);
    /// Reports a given key that is only allowed with a condition.
    void report_needs(std::string_view key, std::string condition);

private:
    void check_keys();
    void check_key(const Node& key);
    bool check_slip(const Node& key);
    bool check_password(const Node& key);
    [[nodiscard]] bool divided_by_comma(std::string_view key) const;
    void report_unknown_word(const Field& field, std::string_view text);
    void check_missing();
    const Field& field(std::string_view key) const;
    std::optional<std::size_t> word_index(std::string_view key);
    /// The scalar of a number: not in quotes.
    const Node* number_scalar(std::string_view key);
    void report_scalar(ScalarError error, const Field& field, Rule malformed);
    std::optional<std::int64_t> in_range(const Field& field, std::int64_t value);

    Findings& findings_;
    const Node& node_;
    std::string path_;
    Object object_;
    const Context& context_;
    std::vector<std::string_view> misspelt_;
};

/// Whether quotes mark a scalar as text: in YAML yes; cells of a CSV table have no types.
bool is_quoted(const Node& node);

}  // namespace takt::model
