#include "takt/firmware/table_store.hpp"

#include <algorithm>

#include "takt/firmware/board.hpp"
#include "takt/table/owen_view.hpp"
#include "takt/table/view.hpp"

namespace takt::firmware {
namespace {

constexpr unsigned kFirstPage = 2;
constexpr std::size_t kSequence = 0, kLength = 1, kComplement = 2, kHeadWords = 3;
constexpr std::size_t kWordBytes = sizeof(std::uint32_t);

struct Stored {
    std::uint32_t sequence = 0;  // 0: there is none, or an image without a sequence
    Bytes image;
};

Bytes bytes_of(std::span<const std::uint32_t> words, std::size_t length) {
    return Bytes(reinterpret_cast<const std::uint8_t*>(words.data()), words.size_bytes()).first(length);
}

Stored read(unsigned page) {
    const auto words = board::flash_page(page);
    if (words.size() <= table::kChecksumOffset / kWordBytes) return {};
    const Bytes raw = bytes_of(words, words.size_bytes());
    if (std::equal(table::kMagic, table::kMagic + table::kMagicSize, raw.begin()) || table::is_owen(raw)) {
        std::uint32_t length = 0;
        table::Take{raw.data() + table::kLengthOffset}(length);
        return {0, length <= raw.size() ? raw.first(length) : Bytes{}};
    }
    if (words[kComplement] != ~words[kSequence] || words[kLength] > (words.size() - kHeadWords) * kWordBytes)
        return {};
    return {words[kSequence], bytes_of(words.subspan(kHeadWords), words[kLength])};
}

// The sequence wraps around.
bool is_newer(const Stored& a, const Stored& b) {
    if (a.image.empty() || b.image.empty()) return b.image.empty();
    return static_cast<std::int32_t>(a.sequence - b.sequence) >= 0;
}

}  // namespace

std::array<Bytes, 2> TableStore::stored() {
    const Stored first = read(kFirstPage);
    const Stored second = read(kFirstPage + 1);
    if (is_newer(first, second)) return {first.image, second.image};
    return {second.image, first.image};
}

Result<Bytes> TableStore::store(Bytes image, Bytes kept) {
    const Stored first = read(kFirstPage);
    const Stored second = read(kFirstPage + 1);
    const bool first_is_newer = is_newer(first, second);
    const bool first_stays = kept.empty() ? first_is_newer : kept.data() == first.image.data();
    const unsigned page = kFirstPage + (first_stays ? 1 : 0);
    const std::size_t words = board::flash_page(page).size();
    const std::size_t most = words < kHeadWords ? 0 : (words - kHeadWords) * kWordBytes;
    if (image.size() > most)
        return fail(Code::too_long, static_cast<std::int64_t>(image.size()), static_cast<std::int64_t>(most));
    // Neither the sequence of an image without one nor an erased word.
    std::uint32_t sequence = (first_is_newer ? first : second).sequence + 1;
    while (sequence == 0 || sequence == ~0U) ++sequence;
    board::erase_page(page);
    for (std::size_t at = 0; at < image.size(); at += kWordBytes) {
        std::uint32_t word = ~0U;
        std::copy_n(image.begin() + static_cast<std::ptrdiff_t>(at), std::min(kWordBytes, image.size() - at),
                    reinterpret_cast<std::uint8_t*>(&word));
        board::write_word(page, kHeadWords + at / kWordBytes, word);
    }
    board::write_word(page, kLength, static_cast<std::uint32_t>(image.size()));
    board::write_word(page, kSequence, sequence);
    board::write_word(page, kComplement, ~sequence);
    return read(page).image;
}

}  // namespace takt::firmware
