#include "yaml/source.hpp"

#include <fmt/core.h>

#include <algorithm>

#include "takt/base/utf8.hpp"

namespace takt::file {
namespace {

constexpr std::size_t kBlock = 256;

std::uint8_t byte_at(std::string_view text, std::size_t at) {
    return at < text.size() ? static_cast<std::uint8_t>(text[at]) : 0;
}

bool refused(std::string_view text, std::size_t at, char32_t value) {
    if (value == '\t' || value == '\n') return false;
    if (value == '\r') return byte_at(text, at + 1) != '\n';
    return value < 0x20 || (value >= 0x7F && value < 0xA0) || value == 0xFEFF || value == 0xFFFE ||
           value == 0xFFFF;
}

}  // namespace

std::optional<Foreign> find_foreign(std::string_view text) {
    for (std::size_t at = 0; at < text.size();) {
        if (text[at] >= ' ' && text[at] <= '~') {
            ++at;
            continue;
        }
        const auto character = first_character(text.substr(at));
        if (character.bytes == 0) return Foreign{at, false, byte_at(text, at)};
        if (refused(text, at, character.code)) return Foreign{at, true, character.code};
        at += character.bytes;
    }
    return std::nullopt;
}

std::string in_words(const Foreign& foreign) {
    return foreign.utf8 ? fmt::format("U+{:04X}", foreign.value) : fmt::format("0x{:02X}", foreign.value);
}

Source::Source(std::uint32_t file, std::string_view text) : file_(file), text_(text), lines_{0} {
    if (text_.starts_with(kByteOrderMark)) text_.remove_prefix(kByteOrderMark.size());
    for (std::size_t at = text_.find('\n'); at != std::string_view::npos; at = text_.find('\n', at + 1))
        lines_.push_back(at + 1);
    if (std::ranges::all_of(text_, [](char c) { return static_cast<std::uint8_t>(c) < 0x80; })) return;
    std::size_t characters = 0;
    for (std::size_t at = 0; at < text_.size(); ++at) {
        if (at % kBlock == 0) characters_.push_back(characters);
        if (!continues_character(text_[at])) ++characters;
    }
    if (text_.size() % kBlock == 0) characters_.push_back(characters);
}

std::size_t Source::characters_before(std::size_t offset) const {
    if (characters_.empty()) return std::min(offset, text_.size());
    const auto block = offset / kBlock;
    const auto rest = text_.substr(block * kBlock, offset % kBlock);
    return characters_[block] + count_characters(rest);
}

std::size_t Source::line_of(std::size_t offset) const {
    constexpr std::size_t kNear = 8;
    const std::size_t from = lines_[last_line_] <= offset ? last_line_ : 0;
    const std::size_t near = std::min(from + kNear, lines_.size());
    const bool is_near = near == lines_.size() || offset < lines_[near];
    const auto end = lines_.begin() + static_cast<std::ptrdiff_t>(is_near ? near : lines_.size());
    const auto begin = lines_.begin() + static_cast<std::ptrdiff_t>(from);
    last_line_ = static_cast<std::size_t>(std::upper_bound(begin, end, offset) - 1 - lines_.begin());
    return last_line_;
}

model::SourceLocation Source::location(std::size_t offset) const {
    const auto line = line_of(offset);
    const auto column = characters_before(offset) - characters_before(lines_[line]) + 1;
    return {file_, static_cast<std::uint32_t>(line + 1), static_cast<std::uint32_t>(column)};
}

bool Source::stands_at(std::size_t offset, std::string_view text) const {
    return text_.substr(offset).starts_with(text);
}

std::string_view Source::character(std::size_t offset) const {
    if (offset >= text_.size()) return {};
    return text_.substr(offset, first_character(text_.substr(offset)).bytes);
}

}  // namespace takt::file
