// Copies a YAML text and puts the changes in.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "takt/file/edit.hpp"
#include "takt/model/fields.hpp"
#include "yaml/yaml_layout.hpp"
#include "yaml/yaml_match.hpp"
#include "yaml/yaml_scalar.hpp"
#include "yaml/yaml_style.hpp"

namespace takt::file {

/// An entry of a mapping in the order of the new text: kept, removed or new.
struct EntryStep {
    std::optional<std::size_t> old = {};        ///< its index in the text; nothing: it is new
    const model::Node* kept = nullptr;          ///< the wanted value of an old entry; nullptr: it is removed
    const model::Node::Entry* entry = nullptr;  ///< of a new one
};
[[nodiscard]] std::vector<EntryStep> entry_steps(const model::Node& old, const model::Node& wanted,
                                                 std::optional<model::Object> object);

/// One change of one text.
class YamlPatch {
public:
    /// @param text, layout  must outlive it
    YamlPatch(std::string_view text, const Layout& layout);

    /// The text with the changes. Throws EditError.
    [[nodiscard]] std::string apply(const model::Node& wanted);

private:
    using Object = std::optional<model::Object>;

    /// The kind and the surroundings of a value.
    struct Place {
        Object object;  ///< of the value if it is a mapping, of its items if it is a list
        ScalarUse use = ScalarUse::any;
        bool flow = false;
    };

    /// Adds to the path while it lives.
    class Path {
    public:
        Path(YamlPatch& patch, std::string_view key);
        Path(YamlPatch& patch, std::size_t index);
        ~Path() { path_.resize(size_); }
        Path(const Path&) = delete;
        Path& operator=(const Path&) = delete;

    private:
        std::string& path_;
        std::size_t size_;
    };

    [[nodiscard]] Place place_of(const model::Node& owner, std::string_view key, Object object,
                                 bool flow) const;
    [[nodiscard]] Origins origins_of(const Layout& old, const model::Node& wanted) const;

    /// Whether a value in the lines of a block collection can be changed where it is.
    [[nodiscard]] bool stays_in_place(const Layout& old, const model::Node& wanted) const;
    /// A value in place of the old one, between whose ends it stays.
    void put_value(const Layout& old, const model::Node& wanted, const Place& place);

    // Collections by indentation (yaml_patch_block.cpp).
    void put_block_mapping(const Layout& old, const model::Node& wanted, Object object);
    void put_block_entry(const LayoutPart& part, const model::Node& owner, const model::Node::Entry& entry,
                         Object object, std::size_t column);
    void put_on_key_line(const LayoutPart& part, std::string_view text);
    void put_below_key(const LayoutPart& part, std::string_view lines);
    void put_comments_of(const LayoutPart& part);
    void put_block_list(const Layout& old, const model::Node& wanted, Object object);
    void put_block_item(const Layout& old, std::optional<std::size_t> origin, const model::Node& wanted,
                        Object object, std::size_t neighbour);
    void begin_part(bool first, std::size_t column, std::string_view lead);
    void end_line();
    [[nodiscard]] std::string_view lead_of(const Layout& block, std::size_t index) const;

    // Collections in brackets (yaml_patch_flow.cpp).
    struct FlowStep {
        std::optional<std::size_t> old = {};  ///< index of the part; nothing: `text` is new
        const model::Node* wanted = nullptr;
        Place place = {};
        std::string text = {};
    };
    void put_flow_mapping(const Layout& old, const model::Node& wanted, Object object);
    void put_flow_list(const Layout& old, const model::Node& wanted, const Place& place);
    void put_flow(const Layout& old, const std::vector<FlowStep>& steps);
    void put_flow_part(const LayoutPart& part, const FlowStep& step, bool entry);
    [[nodiscard]] std::string flow_lead(const Layout& old, const FlowStep& step, bool first) const;
    [[nodiscard]] std::string_view flow_lead_of(const Layout& old, std::size_t index) const;
    [[nodiscard]] std::size_t flow_tail_end(const LayoutPart& part) const;

    [[nodiscard]] std::string_view span(std::size_t begin, std::size_t end) const {
        return text_.substr(begin, end - begin);
    }
    void copy(std::size_t begin, std::size_t end) { out_ += span(begin, end); }

    std::string_view text_;
    const Layout& root_;
    YamlStyle style_;
    YamlWriter writer_{style_};
    std::string out_;
    std::string path_;  // of the value, for errors
};

}  // namespace takt::file
