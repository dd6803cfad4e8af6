// Registers that keep their values without power, in two pages of flash.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace takt::firmware {

/// A log of writes in the pages of the board (board.hpp). A page begins with its sequence number and the
/// complement of it. Records follow: count and first register; the values, two in a word; a CRC-32. When a
/// page is full, the other one is erased and takes all values; its sequence number, written last, makes it
/// valid. So the power may fail at any word: after the restart each record is there as a whole or not at all.
///
/// store() returns when the values are in the flash: a response that is sent afterwards promises it.
///
/// No heap. One owner, outside of interrupt handlers.
class RetainedRegisters {
public:
    /// @param registers  outlive it; at most most() of them
    explicit RetainedRegisters(std::span<std::uint16_t> registers);

    /// The most registers for the pages of this board: a page holds all of them twice.
    [[nodiscard]] static std::size_t most();

    /// Sets the registers to what the flash holds.
    /// @returns false: it holds nothing yet; the registers stay as they are
    bool restore();

    [[nodiscard]] std::size_t size() const { return registers_.size(); }

    /// Stores registers; with the first call all of them. Numbers behind the last one are ignored.
    void store(std::size_t first, std::size_t count);

private:
    using Page = std::span<const std::uint32_t>;

    [[nodiscard]] std::optional<std::uint32_t> sequence_of(Page page) const;
    [[nodiscard]] std::size_t record_words(Page page, std::size_t index) const;
    std::size_t append(std::size_t index, std::uint32_t sequence, std::size_t first, std::size_t count);
    [[nodiscard]] std::uint32_t packed(std::size_t first, std::size_t count, std::size_t word) const;
    void compact();

    std::span<std::uint16_t> registers_;
    bool valid_ = false;  // a page holds all registers
    unsigned page_ = 0;
    std::uint32_t sequence_ = 0;
    std::size_t end_ = 0;  // where the next record begins; the size of the page: it is full
};

}  // namespace takt::firmware
