#include "takt/model/name_filter.hpp"

#include <utility>

#include "takt/base/utf8.hpp"

namespace takt::model {
namespace {

/// The end of the character that begins at `at`.
std::size_t after_character(std::string_view text, std::size_t at) {
    do ++at;
    while (at < text.size() && continues_character(text[at]));
    return at;
}

}  // namespace

bool is_wildcard(std::string_view pattern) {
    return pattern.find_first_of("*?") != std::string_view::npos;
}

// Greedy with one way back: only the last * can have to take more text.
bool fits(std::string_view name, std::string_view pattern) {
    constexpr auto kNone = std::string_view::npos;
    std::size_t n = 0;
    std::size_t p = 0;
    std::size_t star = kNone;
    std::size_t taken = 0;
    while (n < name.size()) {
        if (p < pattern.size() && pattern[p] == '*') {
            star = p++;
            taken = n;
        } else if (p < pattern.size() && pattern[p] == '?') {
            n = after_character(name, n);
            ++p;
        } else if (p < pattern.size() && pattern[p] == name[n]) {
            ++n;
            ++p;
        } else if (star != kNone) {
            taken = after_character(name, taken);
            n = taken;
            p = star + 1;
        } else {
            return false;
        }
    }
    return pattern.find_first_not_of('*', p) == kNone;
}

void NameFilter::add(std::string pattern) {
    if (is_wildcard(pattern))
        wild_.push_back(patterns_.size());
    else
        exact_.try_emplace(pattern, patterns_.size());
    patterns_.push_back(std::move(pattern));
    used_.push_back(false);
}

bool NameFilter::select(std::string_view name) {
    bool selected = select_exactly(name);
    for (const auto index : wild_)
        if (fits(name, patterns_[index])) selected = used_[index] = true;
    return selected;
}

bool NameFilter::select_exactly(std::string_view name) {
    const auto found = exact_.find(std::string(name));
    if (found == exact_.end()) return false;
    return used_[found->second] = true;
}

}  // namespace takt::model
