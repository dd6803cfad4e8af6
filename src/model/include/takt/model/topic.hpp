// Templates of MQTT topics: `plant/{device}/{variable}`.
#pragma once

#include <cstdint>
#include <expected>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace takt::model {

enum class TopicPart : std::uint8_t { output, line, device, variable };

/// The names of the placeholders, in the order of TopicPart.
[[nodiscard]] std::span<const std::string_view> topic_parts();

/// `{line}` and `{device}` of a local. The check for equal topics finds a conflict with a device of this
/// name.
inline constexpr std::string_view kLocalsInTopics = "locals";

/// The texts of the placeholders.
struct TopicNames {
    std::string_view output;
    std::string_view line;
    std::string_view device;
    std::string_view variable;
};

/// Why a text is not a template.
enum class TopicError : std::uint8_t {
    unknown_part,  ///< a placeholder of another name
    brace,         ///< a brace without its other one
    wildcard,      ///< `+` or `#`, which only subscriptions may have
    empty_level,   ///< nothing before, after or between slashes; one slash at the end is allowed
};

class TopicTemplate {
public:
    struct Failure {
        TopicError error{};
        std::string_view part;  ///< of `text`: the unknown placeholder with its braces, else empty
    };

    TopicTemplate() = default;

    [[nodiscard]] static std::expected<TopicTemplate, Failure> parse(std::string_view text);

    [[nodiscard]] bool has(TopicPart part) const;

    /// The topic. In a name each `/`, `+`, `#` and control character becomes `_`, so that a name is one
    /// level at most.
    [[nodiscard]] std::string expand(const TopicNames& names) const;

    friend bool operator==(const TopicTemplate&, const TopicTemplate&) = default;

private:
    /// Text, then a placeholder.
    std::vector<std::pair<std::string, TopicPart>> parts_;
    std::string rest_;
};

}  // namespace takt::model
