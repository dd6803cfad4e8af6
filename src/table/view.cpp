// Opens an image: checks its header, then each of its records.
#include "takt/table/view.hpp"

#include <algorithm>
#include <string_view>

#include "rules.hpp"

namespace takt::table {

using namespace std::string_view_literals;
namespace {

Result<void> check_envelope(Bytes image) {
    const auto there = static_cast<std::int64_t>(image.size());
    if (!std::equal(image.begin(), image.begin() + std::min<std::ptrdiff_t>(kMagicSize, std::ssize(image)),
                    kMagic))
        return fail(Code::malformed, "magic"sv);
    if (image.size() < kMagicSize + 2)
        return fail(Code::too_short, there, static_cast<std::int64_t>(kHeaderSize));
    std::uint16_t version = 0;
    Take{image.data() + kMagicSize}(version);
    if (version == 0) return fail(Code::malformed, "version"sv);
    if (version != kVersion) return fail(Code::unsupported, "version"sv, version, kVersion);
    if (image.size() < kHeaderSize)
        return fail(Code::too_short, there, static_cast<std::int64_t>(kHeaderSize));
    return {};
}

template <class Record>
bool inside(const Header& header, const Section& section) {
    const std::uint64_t end = section.offset + std::uint64_t{section.count} * record_size<Record>();
    return section.offset >= kHeaderSize && end <= header.length;
}

Result<void> check_header(Bytes image, const Header& header) {
    const auto there = static_cast<std::int64_t>(image.size());
    if (image.size() < header.length) return fail(Code::too_short, there, header.length);
    if (image.size() > header.length) return fail(Code::too_long, there, header.length);
    if (header.length > kMaxImage) return fail(Code::too_long, there, static_cast<std::int64_t>(kMaxImage));
    if (image_checksum(image) != header.checksum) return fail(Code::bad_checksum);
    if (header.header_size != kHeaderSize) return fail(Code::malformed, "header"sv);
    const bool whole =
        inside<LineRecord>(header, header.lines) && inside<DeviceRecord>(header, header.devices) &&
        inside<EntryRecord>(header, header.entries) && inside<std::uint32_t>(header, header.members) &&
        inside<ItemRecord>(header, header.items) && inside<std::uint8_t>(header, header.texts);
    if (!whole) return fail(Code::malformed, "sections"sv);
    return {};
}

}  // namespace

Result<View> View::open(Bytes image) {
    TAKT_CHECK(check_envelope(image));
    View view(image);
    Take take(image.data() + kMagicSize);
    code(take, view.header_);
    TAKT_CHECK(check_header(image, view.header_));
    const Rules rules(view, image.subspan(view.header_.texts.offset, view.header_.texts.count));
    TAKT_CHECK(rules.check());
    return view;
}

std::string_view View::text(std::uint32_t text) const {
    if (text == kNone) return {};
    const std::uint8_t* const bytes = image_.data() + header_.texts.offset + text;
    std::uint16_t length = 0;
    Take{bytes}(length);
    return {reinterpret_cast<const char*>(bytes + 2), length};
}

std::uint32_t words_of(const ItemRecord& item) {
    return static_cast<std::uint32_t>(register_count(type_of(item), item.registers));
}

std::uint32_t items_of(const ItemRecord& item) {
    return wire::is_bit_area(wire::Area{item.area}) ? 1 : words_of(item);
}

}  // namespace takt::table
