// File format: one description page, then two copies of the image in whole pages. Numbers are little-endian.
//   description: "TaktRegs", version (2), unit (1), 0, ranges (2), 0 (2), image bytes (4); for each range
//                area (1), bits (1), first (2), last (2); CRC-32C of all the above (4)
//   copy:        "TaktCopy", sequence (8), CRC-32C of the description (4), image bytes (4), CRC-32C of the
//                preceding header bytes and the image (4); the image
// A new file has both copies, with the sequences 1 and 0. So a copy of zeros has lost its contents.
//
// Commits alternate between the copies and increment the sequence. The copy that is written is never the
// newest valid one, so a power cut during a commit leaves the previous image intact. Reading takes the valid
// copy with the greater sequence.
#include "takt/store/register_file.hpp"

#include <algorithm>
#include <string_view>
#include <utility>

#include "takt/base/assert.hpp"
#include "takt/store/crc32c.hpp"

namespace takt::store {
namespace {

constexpr std::string_view kRegistersMark = RegisterFile::kMark;
constexpr std::string_view kCopyMark = "TaktCopy";
constexpr std::uint16_t kRegistersVersion = 1;
constexpr std::size_t kRangesAt = 20;
constexpr std::size_t kRangeBytes = 6;
constexpr std::size_t kChecksumAt = 24;  // in a copy's header
constexpr std::size_t kCopyHeaderBytes = 28;
constexpr std::size_t kSectorBytes = 512;  // a medium loses at least that much
static_assert(kRangesAt + RegisterLayout::kMostRanges * kRangeBytes + 4 <= RegisterFile::kPage);

template <class T>
void put_number_at(std::vector<std::uint8_t>& bytes, std::size_t at, T number) {
    for (std::size_t i = 0; i < sizeof(T); ++i)
        bytes[at + i] = static_cast<std::uint8_t>(std::uint64_t{number} >> (8 * i));
}

template <class T>
T take_number_at(Bytes bytes, std::size_t at) {
    std::uint64_t number = 0;
    for (std::size_t i = 0; i < sizeof(T); ++i) number |= std::uint64_t{bytes[at + i]} << (8 * i);
    return static_cast<T>(number);
}

void copy_text(std::vector<std::uint8_t>& bytes, std::string_view text) {
    std::ranges::copy(text, bytes.begin());
}

bool begins_with(Bytes bytes, std::string_view text) {
    return std::ranges::equal(bytes.first(text.size()), text, {}, {},
                              [](char c) { return static_cast<std::uint8_t>(c); });
}

bool is_zeros(Bytes bytes) {
    return std::ranges::all_of(bytes, [](std::uint8_t byte) { return byte == 0; });
}

std::size_t whole_pages(std::size_t bytes) {
    return (bytes + RegisterFile::kPage - 1) / RegisterFile::kPage * RegisterFile::kPage;
}

std::vector<std::uint8_t> description(const RegisterLayout& layout) {
    TAKT_ASSERT(layout.ranges.size() <= RegisterLayout::kMostRanges);
    std::vector<std::uint8_t> bytes(kRangesAt + layout.ranges.size() * kRangeBytes);
    copy_text(bytes, kRegistersMark);
    put_number_at(bytes, 8, kRegistersVersion);
    put_number_at(bytes, 10, layout.unit);
    put_number_at(bytes, 12, static_cast<std::uint16_t>(layout.ranges.size()));
    put_number_at(bytes, 16, static_cast<std::uint32_t>(layout.bytes()));
    std::size_t at = kRangesAt;
    for (const auto& range : layout.ranges) {
        put_number_at(bytes, at, range.area);
        put_number_at(bytes, at + 1, static_cast<std::uint8_t>(range.bits ? 1 : 0));
        put_number_at(bytes, at + 2, range.first);
        put_number_at(bytes, at + 4, range.last);
        at += kRangeBytes;
    }
    return bytes;
}

/// Returns nothing if the page does not hold a valid description.
std::optional<RegisterLayout> described(Bytes page) {
    const std::size_t ranges = take_number_at<std::uint16_t>(page, 12);
    if (!begins_with(page, kRegistersMark) || ranges > RegisterLayout::kMostRanges) return std::nullopt;
    const std::size_t end = kRangesAt + ranges * kRangeBytes;
    if (crc32c(page.first(end)) != take_number_at<std::uint32_t>(page, end)) return std::nullopt;
    RegisterLayout layout{take_number_at<std::uint8_t>(page, 10), {}};
    for (std::size_t at = kRangesAt; at < end; at += kRangeBytes)
        layout.ranges.push_back({page[at], page[at + 1] != 0, take_number_at<std::uint16_t>(page, at + 2),
                                 take_number_at<std::uint16_t>(page, at + 4)});
    const bool sane =
        std::ranges::all_of(layout.ranges, [](const KeptRange& r) { return r.first <= r.last; });
    if (!sane || layout.bytes() != take_number_at<std::uint32_t>(page, 16)) return std::nullopt;
    return layout;
}

}  // namespace

std::size_t RegisterLayout::bytes() const {
    std::size_t sum = 0;
    for (const auto& range : ranges) sum += range.bytes();
    return sum;
}

RegisterFile::RegisterFile(BlockFile& file, RegisterLayout layout)
    : file_(&file), layout_(std::move(layout)), fingerprint_(crc32c(description(layout_))) {
    const std::size_t bytes = whole_pages(kCopyHeaderBytes + layout_.bytes());
    for (auto& copy : copies_) {
        copy.bytes.resize(bytes);
        copy.unknown.resize(bytes / kPage);
    }
    wanted_.resize(bytes);
}

std::uint64_t RegisterFile::file_size(const RegisterLayout& layout) {
    return kPage + 2 * whole_pages(kCopyHeaderBytes + layout.bytes());
}

std::uint64_t RegisterFile::offset_of(std::size_t copy) const {
    return kPage + copy * copies_[0].bytes.size();
}

Bytes RegisterFile::image() const {
    return Bytes(copies_[newest_].bytes).subspan(kCopyHeaderBytes, layout_.bytes());
}

void RegisterFile::put_header(std::vector<std::uint8_t>& bytes, std::uint64_t sequence) const {
    copy_text(bytes, kCopyMark);
    put_number_at(bytes, 8, sequence);
    put_number_at(bytes, 16, fingerprint_);
    put_number_at(bytes, 20, static_cast<std::uint32_t>(layout_.bytes()));
    const Bytes all(bytes);
    put_number_at(bytes, kChecksumAt,
                  crc32c(all.subspan(kCopyHeaderBytes, layout_.bytes()), crc32c(all.first(kChecksumAt))));
}

bool RegisterFile::whole(const Copy& copy) const {
    const Bytes bytes(copy.bytes);
    return begins_with(bytes, kCopyMark) && take_number_at<std::uint32_t>(bytes, 16) == fingerprint_ &&
           take_number_at<std::uint32_t>(bytes, 20) == layout_.bytes() &&
           take_number_at<std::uint32_t>(bytes, kChecksumAt) ==
               crc32c(bytes.subspan(kCopyHeaderBytes, layout_.bytes()), crc32c(bytes.first(kChecksumAt)));
}

Result<void> RegisterFile::write_description() {
    std::vector<std::uint8_t> page(kPage);
    const auto bytes = description(layout_);
    std::ranges::copy(bytes, page.begin());
    put_number_at(page, bytes.size(), fingerprint_);
    return file_->write_at(0, page);
}

Result<RegisterFile> RegisterFile::make(BlockFile& file, const RegisterLayout& layout, Bytes image) {
    TAKT_ASSERT(image.size() == layout.bytes());
    RegisterFile made(file, layout);
    TAKT_CHECK(made.write_description());
    std::ranges::copy(image, made.wanted_.begin() + kCopyHeaderBytes);
    made.sequence_ = 1;
    for (const std::size_t copy : {1U, 0U}) {
        made.copies_[copy].unknown.assign(made.copies_[copy].unknown.size(), true);
        made.put_header(made.wanted_, made.sequence_ - copy);
        TAKT_CHECK(made.write_pages(copy, made.wanted_));
        made.copies_[copy].bytes = made.wanted_;
    }
    TAKT_CHECK(file.sync());
    for (Copy& copy : made.copies_) copy.unknown.assign(copy.unknown.size(), false);
    made.newest_ = 0;
    return made;
}

Result<RegisterFile> RegisterFile::open(BlockFile& file, const RegisterLayout& expected) {
    TAKT_TRY(const std::uint64_t size, file.size());
    std::vector<std::uint8_t> page(kPage);
    const auto there = std::span(page).first(std::min<std::uint64_t>(size, kPage));
    TAKT_CHECK(file.read_at(0, there));
    const bool own_mark = begins_with(there, kRegistersMark.substr(0, there.size()));
    const bool lost = is_zeros(there.first(std::min(there.size(), kSectorBytes)));
    if (there.size() < kPage && !own_mark && !lost) return fail(Code::unsupported);
    if (there.size() < kPage)
        return fail(Code::too_short, static_cast<std::int64_t>(size), static_cast<std::int64_t>(kPage));
    const auto own = described(page);
    if (own && take_number_at<std::uint16_t>(page, 8) != kRegistersVersion)
        return fail(Code::unsupported, {}, take_number_at<std::uint16_t>(page, 8));
    RegisterFile opened(file, own.value_or(expected));
    std::array<bool, 2> whole{};
    bool known = own_mark || lost;
    for (std::size_t i = 0; i < opened.copies_.size(); ++i) {
        Copy& copy = opened.copies_[i];
        if (const auto read = file.read_at(opened.offset_of(i), copy.bytes); !read) {
            // A truncated file may still hold its first copy.
            if (read.error().code != Code::too_short) return std::unexpected(read.error());
            opened.damaged_ = true;
            copy.unknown.assign(copy.unknown.size(), true);
            continue;
        }
        known = known || begins_with(copy.bytes, kCopyMark);
        whole[i] = opened.whole(copy);
        if (whole[i]) continue;
        opened.damaged_ = true;
        copy.unknown.assign(copy.unknown.size(), true);
    }
    if (!known) return fail(Code::unsupported);
    if (!whole[0] && !whole[1]) return fail(Code::malformed);
    const auto number = [&](std::size_t i) {
        return take_number_at<std::uint64_t>(opened.copies_[i].bytes, 8);
    };
    opened.newest_ = whole[1] && (!whole[0] || number(1) > number(0)) ? 1 : 0;
    opened.sequence_ = number(opened.newest_);
    if (!own) {
        opened.damaged_ = true;
        TAKT_CHECK(opened.write_description());
        TAKT_CHECK(file.sync());
    }
    return opened;
}

// Adjacent changed pages are written together.
Result<void> RegisterFile::write_pages(std::size_t copy, const std::vector<std::uint8_t>& wanted) {
    const Copy& there = copies_[copy];
    const auto differs = [&](std::size_t page) {
        const auto at = static_cast<std::ptrdiff_t>(page * kPage);
        return there.unknown[page] ||
               !std::equal(wanted.begin() + at, wanted.begin() + at + kPage, there.bytes.begin() + at);
    };
    const std::size_t pages = there.unknown.size();
    for (std::size_t first = 0; first < pages; ++first) {
        if (!differs(first)) continue;
        std::size_t end = first + 1;
        while (end < pages && differs(end)) ++end;
        const Bytes run = Bytes(wanted).subspan(first * kPage, (end - first) * kPage);
        TAKT_CHECK(file_->write_at(offset_of(copy) + first * kPage, run));
        counters_.bytes += run.size();
        first = end;
    }
    return {};
}

// Only pages that differ are written. If another program has emptied or overwritten the file, the others are
// missing, so everything is written again.
Result<void> RegisterFile::check_contents() {
    std::array<std::uint8_t, kCopyHeaderBytes> header{};
    const auto read = file_->read_at(offset_of(newest_), header);
    if (!read && read.error().code != Code::too_short) return read;
    if (read && std::ranges::equal(header, Bytes(copies_[newest_].bytes).first(kCopyHeaderBytes))) return {};
    for (Copy& copy : copies_) copy.unknown.assign(copy.unknown.size(), true);
    return write_description();
}

Result<void> RegisterFile::commit(Bytes image) {
    TAKT_ASSERT(image.size() == layout_.bytes());
    if (!in_doubt_ && std::ranges::equal(image, this->image())) return {};
    const std::size_t older = 1 - newest_;
    std::ranges::copy(image, wanted_.begin() + kCopyHeaderBytes);
    put_header(wanted_, sequence_ + 1);
    auto written = check_contents();
    if (written) written = write_pages(older, wanted_);
    if (written) written = file_->sync();
    if (!written) {
        ++counters_.failures;
        in_doubt_ = true;
        copies_[older].unknown.assign(copies_[older].unknown.size(), true);
        return written;
    }
    in_doubt_ = false;
    ++counters_.commits;
    ++sequence_;
    copies_[older].bytes.swap(wanted_);
    copies_[older].unknown.assign(copies_[older].unknown.size(), false);
    newest_ = older;
    return {};
}

}  // namespace takt::store
