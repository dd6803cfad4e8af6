// Selects names by patterns with * and ?.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

namespace takt::model {

/// Whether a pattern has a * or ?.
[[nodiscard]] bool is_wildcard(std::string_view pattern);

/// Whether a name is as the pattern: * is any text, also none, ? is one character.
[[nodiscard]] bool fits(std::string_view name, std::string_view pattern);

/// A list of patterns that notes which of them were of use. Names without wildcards are looked up, so that a
/// list of all names of a project costs no more than its length.
class NameFilter {
public:
    void add(std::string pattern);

    [[nodiscard]] std::size_t size() const { return patterns_.size(); }
    [[nodiscard]] const std::string& pattern(std::size_t index) const { return patterns_[index]; }

    /// Whether one of the patterns fits; notes each of them.
    bool select(std::string_view name);

    /// The same without wildcards.
    bool select_exactly(std::string_view name);

    /// Whether the pattern fitted a name.
    [[nodiscard]] bool used(std::size_t index) const { return used_[index]; }

private:
    std::vector<std::string> patterns_;
    std::vector<bool> used_;
    std::unordered_map<std::string, std::size_t> exact_;  // the first one of equal ones
    std::vector<std::size_t> wild_;
};

}  // namespace takt::model
