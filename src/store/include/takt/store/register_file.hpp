// A file of a unit's registers that survives power cuts (docs/specification.md, section 9).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "takt/store/block_file.hpp"

namespace takt::store {

/// Items first..last of an area.
struct KeptRange {
    std::uint8_t area = 0;  ///< any number that the owner gives to it
    bool bits = false;      ///< of one bit each, else of 16
    std::uint16_t first = 0;
    std::uint16_t last = 0;
    friend bool operator==(const KeptRange&, const KeptRange&) = default;

    [[nodiscard]] std::uint32_t items() const { return last - first + 1U; }
    /// Encoding in an image: registers high byte first; bits from the least significant one of the first byte
    /// on.
    [[nodiscard]] std::size_t bytes() const { return bits ? (items() + 7U) / 8 : 2U * items(); }
};

/// The layout of an image: its ranges, one after the other.
struct RegisterLayout {
    static constexpr std::size_t kMostRanges = 512;

    std::uint8_t unit = 1;
    std::vector<KeptRange> ranges;  ///< at most kMostRanges
    friend bool operator==(const RegisterLayout&, const RegisterLayout&) = default;

    [[nodiscard]] std::size_t bytes() const;
};

/// Two copies of an image, written alternately. The older copy is overwritten and synchronised before the
/// newer one may be touched again. Each copy has a sequence number and a checksum. So after an interrupted
/// write the previous or the new image is found, never a mixture.
///
/// Only pages that differ from a copy's content are written. One thread at a time.
class RegisterFile {
public:
    static constexpr std::size_t kPage = 4096;
    static constexpr std::string_view kMark = "TaktRegs";  ///< a file of this kind begins with it

    struct Counters {
        std::uint64_t commits = 0;
        std::uint64_t bytes = 0;
        std::uint64_t failures = 0;
    };

    /// The size of the file of such a layout.
    [[nodiscard]] static std::uint64_t file_size(const RegisterLayout& layout);

    /// Writes a complete new file and synchronises it.
    /// @param file   of file_size() zeros; outlives the result
    /// @param image  layout.bytes() bytes
    [[nodiscard]] static Result<RegisterFile> make(BlockFile& file, const RegisterLayout& layout,
                                                   Bytes image);

    /// Finds the newest valid image.
    /// @param expected  the layout to use if the file's own description is damaged
    /// @returns unsupported (another kind of file, or a newer version: its number), malformed (no valid
    ///          copy; a first sector of zeros is a lost one), too_short (also a part of the mark), io_failed
    [[nodiscard]] static Result<RegisterFile> open(BlockFile& file, const RegisterLayout& expected);

    [[nodiscard]] const RegisterLayout& layout() const { return layout_; }
    /// The last image that is known to be durable.
    [[nodiscard]] Bytes image() const;
    [[nodiscard]] std::uint64_t sequence() const { return sequence_; }
    /// After open(): one copy or the description was damaged, and the other copy was used. An interrupted
    /// write does that and loses nothing that was acknowledged. But the damaged copy may also have been the
    /// newer one.
    [[nodiscard]] bool was_damaged() const { return damaged_; }

    /// Makes `image` durable with one synchronisation, also in a file that another program has overwritten in
    /// place (its newest copy has another header). Nothing is written if a restart would surely find this
    /// image.
    /// @returns io_failed, replaced: image() is unchanged; until the next successful commit() it is unknown
    ///          which image a restart finds
    [[nodiscard]] Result<void> commit(Bytes image);

    [[nodiscard]] const Counters& counters() const { return counters_; }

private:
    /// The content of a copy on the disk. Pages of unknown state are written again.
    struct Copy {
        std::vector<std::uint8_t> bytes;
        std::vector<bool> unknown;
    };

    RegisterFile(BlockFile& file, RegisterLayout layout);
    [[nodiscard]] std::uint64_t offset_of(std::size_t copy) const;
    [[nodiscard]] bool whole(const Copy& copy) const;
    [[nodiscard]] Result<void> check_contents();
    [[nodiscard]] Result<void> write_pages(std::size_t copy, const std::vector<std::uint8_t>& wanted);
    void put_header(std::vector<std::uint8_t>& bytes, std::uint64_t sequence) const;
    [[nodiscard]] Result<void> write_description();

    BlockFile* file_;
    RegisterLayout layout_;
    std::uint32_t fingerprint_ = 0;
    std::array<Copy, 2> copies_;
    std::size_t newest_ = 0;
    std::uint64_t sequence_ = 0;
    bool damaged_ = false;
    bool in_doubt_ = false;             // a commit failed: a restart may find its image
    std::vector<std::uint8_t> wanted_;  // buffer of the copy being written
    Counters counters_;
};

}  // namespace takt::store
