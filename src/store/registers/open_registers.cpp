#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <optional>
#include <system_error>
#include <utility>

#include "takt/store/register_writer.hpp"

namespace takt::store {
namespace {

namespace fs = std::filesystem;

/// Gives the file a second name. Both names exist until the new file replaces the first one, so a power cut
/// never leaves the path without a file.
/// @returns the second name
Result<std::string> keep_aside(const std::string& path, const std::string& why) {
    constexpr int kMost = 999;
    for (int i = 1; i <= kMost; ++i) {
        std::string aside = path;
        aside.append(".").append(why).append("-").append(std::to_string(i));
        std::error_code error;
        if (fs::exists(fs::symlink_status(aside, error))) continue;
        fs::create_hard_link(path, aside, error);
        if (error) fs::copy_file(path, aside, error);  // the file system has no hard links
        if (error) return fail(Code::io_failed, aside, error.value());
        return aside;
    }
    return fail(Code::io_failed, path, EEXIST);
}

bool bit_at(Bytes bytes, std::size_t index) {
    return (bytes[index / 8] >> (index % 8) & 1) != 0;
}

/// Copies item `from` of one range of an image to item `to` of another one.
void copy_item(const KeptRange& range, Bytes from_bytes, std::size_t from, std::span<std::uint8_t> to_bytes,
               std::size_t to) {
    if (!range.bits) {
        std::copy_n(from_bytes.begin() + static_cast<std::ptrdiff_t>(2 * from), 2,
                    to_bytes.begin() + static_cast<std::ptrdiff_t>(2 * to));
        return;
    }
    const auto mask = static_cast<std::uint8_t>(1U << (to % 8));
    auto& byte = to_bytes[to / 8];
    byte = static_cast<std::uint8_t>(bit_at(from_bytes, from) ? byte | mask : byte & ~mask);
}

/// Copies the items that both layouts have. @returns their number
std::uint32_t take_over(const RegisterLayout& from, Bytes old_image, const RegisterLayout& to,
                        std::vector<std::uint8_t>& image) {
    std::uint32_t taken = 0;
    std::size_t to_at = 0;
    for (const auto& range : to.ranges) {
        const auto into = std::span(image).subspan(to_at, range.bytes());
        to_at += range.bytes();
        std::size_t from_at = 0;
        for (const auto& old : from.ranges) {
            const Bytes source = old_image.subspan(from_at, old.bytes());
            from_at += old.bytes();
            if (old.area != range.area || old.bits != range.bits) continue;
            const unsigned first = std::max(old.first, range.first);
            const unsigned last = std::min(old.last, range.last);
            for (unsigned item = first; item <= last; ++item, ++taken)
                copy_item(range, source, item - old.first, into, item - range.first);
        }
    }
    return taken;
}

std::uint32_t items(const RegisterLayout& layout) {
    std::uint32_t sum = 0;
    for (const auto& range : layout.ranges) sum += range.items();
    return sum;
}

/// Creates a new file, replacing the file of that path.
Result<OpenedRegisters> make_new(const std::string& path, const RegisterLayout& layout, Bytes image,
                                 std::uint32_t taken) {
    TAKT_TRY(auto made, NewBlockFile::make(path, RegisterFile::file_size(layout), RegisterFile::kMark));
    TAKT_TRY(auto file, RegisterFile::make(made.file(), layout, image));
    TAKT_TRY(auto storage, made.publish());
    OpenedRegisters opened{std::move(storage), std::move(file)};
    opened.taken = taken;
    opened.missing = items(layout) - taken;
    return opened;
}

Result<OpenedRegisters> begin_anew(const std::string& path, const RegisterLayout& layout, Bytes defaults) {
    TAKT_TRY(auto opened, make_new(path, layout, defaults, 0));
    opened.is_new = true;
    return opened;
}

/// A new file with the values that the file of another layout shares with it.
Result<OpenedRegisters> convert(const std::string& path, const RegisterFile& old,
                                const RegisterLayout& layout, Bytes defaults) {
    std::vector<std::uint8_t> image(defaults.begin(), defaults.end());
    const std::uint32_t taken = take_over(old.layout(), old.image(), layout, image);
    TAKT_TRY(auto aside, keep_aside(path, "old"));
    TAKT_TRY(auto opened, make_new(path, layout, image, taken));
    opened.other_layout = true;
    opened.set_aside = std::move(aside);
    return opened;
}

}  // namespace

Result<OpenedRegisters> open_registers(const std::string& path, const RegisterLayout& layout,
                                       Bytes defaults) {
    auto storage = open_block_file(path);
    if (!storage && storage.error().code == Code::not_found) return begin_anew(path, layout, defaults);
    if (!storage) return std::unexpected(storage.error());
    auto file = RegisterFile::open(**storage, layout);
    if (!file && (file.error().code == Code::malformed || file.error().code == Code::too_short)) {
        TAKT_TRY(auto aside, keep_aside(path, "damaged"));
        TAKT_TRY(auto opened, begin_anew(path, layout, defaults));
        opened.set_aside = std::move(aside);
        return opened;
    }
    if (!file && file.error().code == Code::unsupported)
        return fail(Code::unsupported, path, file.error().numbers[0]);
    if (!file) return std::unexpected(file.error());
    if (file->layout() != layout) return convert(path, *file, layout, defaults);
    OpenedRegisters opened{*std::move(storage), *std::move(file)};
    opened.was_damaged = opened.file.was_damaged();
    opened.taken = items(layout);
    return opened;
}

}  // namespace takt::store
