// Opens an image of owen-kc1: magic and header, 28 bytes; then lines of 20 bytes, devices of 16 and entries
// of 20, without gaps.
#include "takt/table/owen_view.hpp"

#include <algorithm>
#include <string_view>

namespace takt::table {

using namespace std::string_view_literals;
namespace {

Result<OwenHeader> open_header(Bytes image) {
    const auto there = static_cast<std::int64_t>(image.size());
    const auto known = std::min<std::ptrdiff_t>(kMagicSize, std::ssize(image));
    if (!std::equal(image.begin(), image.begin() + known, kOwenMagic))
        return fail(Code::malformed, "magic"sv);
    if (image.size() < kMagicSize + 2) return fail(Code::too_short, there, std::int64_t{kOwenHeaderSize});
    OwenHeader header;
    Take{image.data() + kMagicSize}(header.version);
    if (header.version > kOwenVersion)
        return fail(Code::unsupported, "version"sv, header.version, kOwenVersion);
    if (header.version == 0) return fail(Code::malformed, "version"sv);
    if (image.size() < kOwenHeaderSize) return fail(Code::too_short, there, std::int64_t{kOwenHeaderSize});
    Take take(image.data() + kMagicSize);
    code(take, header);
    if (image.size() < header.length) return fail(Code::too_short, there, header.length);
    if (image.size() > header.length) return fail(Code::too_long, there, header.length);
    if (image_checksum(image) != header.checksum) return fail(Code::bad_checksum);
    const std::size_t length = kOwenHeaderSize + header.masters * record_size<OwenMaster>() +
                               header.devices * record_size<OwenDevice>() +
                               header.entries * record_size<OwenEntry>();
    if (header.header_size != kOwenHeaderSize || length != image.size())
        return fail(Code::malformed, "header"sv);
    return header;
}

bool runs_through(std::size_t first, std::size_t count, std::size_t& next) {
    const bool fits = first == next;
    next += count;
    return fits;
}

}  // namespace

bool is_owen(Bytes image) {
    return image.size() >= kMagicSize && std::equal(kOwenMagic, kOwenMagic + kMagicSize, image.begin());
}

Result<OwenView> OwenView::open(Bytes image) {
    OwenView view(image);
    TAKT_TRY(view.header_, open_header(image));
    TAKT_CHECK(view.check());
    return view;
}

Result<void> OwenView::check() const {
    std::size_t next = 0;
    for (std::size_t i = 0; i < header_.masters; ++i) {
        const auto m = master(i);
        if (m.framing > 1 || m.parity > 2 || !runs_through(m.first_device, m.device_count, next))
            return fail(Code::malformed, "line"sv, static_cast<std::int64_t>(i));
    }
    if (next != header_.devices) return fail(Code::malformed, "line"sv);
    next = 0;
    for (std::size_t i = 0; i < header_.devices; ++i) {
        const auto d = device(i);
        if (!runs_through(d.first_entry, d.entry_count, next) || d.status > header_.places ||
            d.poll_enable > header_.places)
            return fail(Code::malformed, "device"sv, static_cast<std::int64_t>(i));
    }
    if (next != header_.entries) return fail(Code::malformed, "device"sv);
    for (std::size_t i = 0; i < header_.entries; ++i) {
        const auto e = entry(i);
        const bool places = e.data >= 1 &&
                            e.data + std::size_t{e.quantity} <= header_.places + std::size_t{1} &&
                            std::max({e.read_trigger, e.write_trigger, e.status}) <= header_.places;
        if (!places || e.quantity < 1 || e.kind() > OwenEntry::kDoubleWord)
            return fail(Code::malformed, "entry"sv, static_cast<std::int64_t>(i));
    }
    return {};
}

}  // namespace takt::table
