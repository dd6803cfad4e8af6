// Request tables in two pages of flash (board.hpp): the power may fail while one is stored.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "takt/base/engine.hpp"
#include "takt/base/result.hpp"

namespace takt::firmware {

/// Holds two tables. A new one replaces one of them; the other one stays.
/// A page that begins with an image itself, as a programmer writes it, is the oldest.
///
/// Layout of a page, in words: sequence, length in bytes, complement of the sequence (written last), the
/// image. No heap, no state; not for interrupts.
class TableStore {
public:
    /// The stored images in place, the newest first; empty: none. They are not checked (table::View::open).
    [[nodiscard]] static std::array<Bytes, 2> stored();

    /// The image becomes the newest one.
    /// @param image  outside of the flash
    /// @param kept   an image of stored(), which stays; empty: the newest one stays
    /// @returns the image in the flash; too_long (bytes, most)
    [[nodiscard]] static Result<Bytes> store(Bytes image, Bytes kept);
};

}  // namespace takt::firmware
