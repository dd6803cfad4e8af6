#include "takt/firmware/retained_registers.hpp"

#include <algorithm>

#include "takt/base/assert.hpp"
#include "takt/firmware/board.hpp"

namespace takt::firmware {
namespace {

constexpr std::uint32_t kErased = 0xFFFFFFFF;
constexpr std::size_t kHead = 2;    // words of a page before its records
constexpr std::size_t kFramed = 2;  // words of a record beside its values

std::size_t value_words(std::size_t count) {
    return (count + 1) / 2;
}

// CRC-32 (IEEE 802.3), a word at a time, low byte first.
std::uint32_t crc32(std::uint32_t crc, std::uint32_t word) {
    crc ^= word;
    for (int bit = 0; bit < 32; ++bit) crc = (crc >> 1U) ^ ((crc & 1U) != 0 ? 0xEDB88320U : 0U);
    return crc;
}

// An erased word is never a checksum.
std::uint32_t checksum(std::uint32_t crc) {
    return crc == kErased ? 0 : crc;
}

bool is_erased(std::span<const std::uint32_t> words) {
    return std::ranges::all_of(words, [](std::uint32_t word) { return word == kErased; });
}

}  // namespace

RetainedRegisters::RetainedRegisters(std::span<std::uint16_t> registers) : registers_(registers) {
    TAKT_ASSERT(registers.size() <= most());
}

std::size_t RetainedRegisters::most() {
    const std::size_t words = board::flash_page(0).size();
    constexpr std::size_t kWithoutValues = kHead + 2 * kFramed;
    return words < kWithoutValues ? 0 : (words - kWithoutValues) / 2 * 2;
}

std::optional<std::uint32_t> RetainedRegisters::sequence_of(Page page) const {
    if (page[0] == kErased || page[1] != ~page[0]) return std::nullopt;
    return page[0];
}

// 0: there is no whole record.
std::size_t RetainedRegisters::record_words(Page page, std::size_t index) const {
    if (index >= page.size()) return 0;
    const std::size_t first = page[index] & 0xFFFFU;
    const std::size_t count = page[index] >> 16U;
    const std::size_t words = kFramed + value_words(count);
    if (first + count > registers_.size() || index + words > page.size()) return 0;
    std::uint32_t crc = crc32(kErased, page[0]);
    for (std::size_t i = 0; i + 1 < words; ++i) crc = crc32(crc, page[index + i]);
    return page[index + words - 1] == checksum(crc) ? words : 0;
}

bool RetainedRegisters::restore() {
    if (registers_.empty()) return false;
    std::optional<std::uint32_t> newest;
    for (const unsigned page : {0U, 1U}) {
        const auto sequence = sequence_of(board::flash_page(page));
        // The numbers wrap around.
        if (!sequence || (newest && static_cast<std::int32_t>(*sequence - *newest) < 0)) continue;
        newest = sequence;
        page_ = page;
    }
    if (!newest) return false;
    const Page page = board::flash_page(page_);
    end_ = kHead;
    while (const std::size_t words = record_words(page, end_)) {
        const std::size_t first = page[end_] & 0xFFFFU;
        const std::size_t count = page[end_] >> 16U;
        for (std::size_t i = 0; i < count; ++i)
            registers_[first + i] =
                static_cast<std::uint16_t>(page[end_ + 1 + i / 2] >> (i % 2 == 0 ? 0U : 16U));
        end_ += words;
    }
    // The power failed inside a record: its words cannot be written again.
    if (!is_erased(page.subspan(end_))) end_ = page.size();
    sequence_ = *newest;
    valid_ = true;
    return true;
}

void RetainedRegisters::store(std::size_t first, std::size_t count) {
    if (first >= registers_.size() || count == 0) return;
    count = std::min(count, registers_.size() - first);
    const std::size_t words = kFramed + value_words(count);
    if (!valid_ || end_ + words > board::flash_page(page_).size()) return compact();
    end_ = append(end_, sequence_, first, count);
}

std::uint32_t RetainedRegisters::packed(std::size_t first, std::size_t count, std::size_t word) const {
    const std::size_t low = first + 2 * word;
    const std::uint32_t high = 2 * word + 1 < count ? registers_[low + 1] : 0;
    return high << 16U | registers_[low];
}

std::size_t RetainedRegisters::append(std::size_t index, std::uint32_t sequence, std::size_t first,
                                      std::size_t count) {
    const unsigned page = page_;
    std::uint32_t crc = crc32(kErased, sequence);
    const auto write = [&](std::uint32_t word) {
        crc = crc32(crc, word);
        board::write_word(page, index++, word);
    };
    write(static_cast<std::uint32_t>(count << 16U | first));
    for (std::size_t word = 0; word < value_words(count); ++word) write(packed(first, count, word));
    board::write_word(page, index++, checksum(crc));
    return index;
}

void RetainedRegisters::compact() {
    if (valid_) page_ = 1 - page_;
    ++sequence_;
    if (sequence_ == kErased) sequence_ = 0;
    board::erase_page(page_);
    end_ = append(kHead, sequence_, 0, registers_.size());
    board::write_word(page_, 0, sequence_);
    board::write_word(page_, 1, ~sequence_);
    valid_ = true;
}

}  // namespace takt::firmware
