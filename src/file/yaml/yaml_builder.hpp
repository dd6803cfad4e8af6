// Builds nodes from the events of yaml-cpp's parser. Its loader is not used, because it follows recursive
// aliases and keeps the last of two equal keys.
#pragma once

#include <yaml-cpp/eventhandler.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "takt/model/document.hpp"
#include "yaml/reporter.hpp"
#include "yaml/source.hpp"

namespace takt::file {

/// Thrown to stop the parser. The reason has been reported.
struct Stop {};

/// The keys of one mapping, with their lines.
class KeyLines {
public:
    /// The line of that key if it is known; else adds it.
    std::optional<std::uint32_t> add(const std::string& key, std::uint32_t line);
    void clear();

private:
    static constexpr std::size_t kFew = 16;

    std::vector<std::pair<std::string, std::uint32_t>>
        few_;  // the first keys: a search is faster than a hash
    std::unordered_map<std::string, std::uint32_t> more_;
};

class YamlBuilder : public YAML::EventHandler {
public:
    YamlBuilder(const Source& source, std::size_t& nodes_left, Reporter& reporter);

    /// Whether the text has a document that is not empty.
    [[nodiscard]] bool has_content() const { return root_.kind != model::Node::Kind::null; }
    model::Node take_root() { return std::move(root_); }

    /// The location of the innermost open `[` or `{`; its line is 0 if there is none.
    [[nodiscard]] model::SourceLocation open_bracket() const;
    /// The beginning of a quoted text of several lines that ends in the line of `offset`, directly before it;
    /// its line is 0 if there is none.
    [[nodiscard]] model::SourceLocation quote_before(std::size_t offset) const;
    /// The path of the next node: "lines[0].devices[2].name".
    [[nodiscard]] std::string path() const;

    void OnDocumentStart(const YAML::Mark& mark) override;
    void OnDocumentEnd() override {}
    void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override;
    void OnAlias(const YAML::Mark& mark, YAML::anchor_t anchor) override;
    void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                  const std::string& value) override;
    void OnSequenceStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                         YAML::EmitterStyle::value style) override;
    void OnSequenceEnd() override { end(); }
    void OnMapStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                    YAML::EmitterStyle::value style) override;
    void OnMapEnd() override { end(); }
    void OnAnchor(const YAML::Mark& mark, const std::string& name) override;

private:
    // The meaning of the next event of a mapping.
    enum class Expect : std::uint8_t { key, value, nothing };  // nothing: a value whose key was refused

    // An open collection. Its memory serves the next one of the same depth.
    struct Frame {
        model::Node::Kind kind = model::Node::Kind::list;
        model::SourceLocation location;
        bool bracket = false;  // begun with one, as opposed to by indentation
        Expect expect = Expect::key;
        model::Node key;
        std::vector<model::Node> items;
        std::vector<model::Node::Entry> entries;
        KeyLines lines;
    };

    [[nodiscard]] std::span<const Frame> open_frames() const { return {frames_.data(), depth_}; }
    void begin(model::Node::Kind kind, std::size_t offset, const std::string& tag);
    void end();
    void attach(model::Node&& node);
    void take_key(Frame& frame, model::Node&& node);
    void leave_out(const model::SourceLocation& location);
    void count(std::size_t offset);
    void check_tag(std::size_t offset, const std::string& tag);
    void check_quotes(std::size_t offset, const std::string& value);
    [[nodiscard]] model::SourceLocation location_of_missing(std::size_t offset) const;

    const Source& source_;
    std::size_t& nodes_left_;
    Reporter& reporter_;
    std::size_t documents_ = 0;
    std::vector<Frame> frames_;
    std::size_t depth_ = 0;  // the first frames are open
    model::Node root_;
    // Of the last text, when it was in quotes and of several lines; else both are 0.
    std::size_t quote_open_ = 0;
    std::size_t quote_close_ = 0;
};

/// The offset of a mark, at most the end of the text. yaml-cpp also has marks without a location.
std::size_t offset_of(const YAML::Mark& mark, const Source& source);

}  // namespace takt::file
