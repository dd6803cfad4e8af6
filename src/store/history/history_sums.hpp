// Checksums of rows. SQLite has none. A row's column `sum` is the CRC-32C of the values that a reader takes
// from it. A second number guards a whole table, or the rows of one variable: the count and the sum of the
// rows' sums. It shows rows that are missing, doubled or in the wrong place.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <string_view>

#include "history/history_bytes.hpp"
#include "journal/little_endian.hpp"
#include "takt/store/crc32c.hpp"

namespace takt::store {

/// In a column of sums or counts: there is none, because a program of version 1 wrote the row.
inline constexpr std::int64_t kNoSum = -1;

class RowSum {
public:
    /// @param table  rows of two tables have different sums
    explicit RowSum(char table) { bytes_.push_back(static_cast<std::uint8_t>(table)); }

    RowSum& add(std::int64_t value) {
        put_little(bytes_, static_cast<std::uint64_t>(value));
        return *this;
    }
    /// As SQLite returns it: a number that is none is null, thus 0, and there is one zero.
    RowSum& add(double value) {
        const bool zero = std::isnan(value) || value == 0;
        return add(std::bit_cast<std::int64_t>(zero ? 0.0 : value));
    }
    RowSum& add(std::string_view text) {
        put_text(bytes_, text);
        return *this;
    }
    /// 0 to 2^32 - 1
    [[nodiscard]] std::int64_t value() const { return crc32c(bytes_); }

private:
    ByteVector bytes_;
};

/// Of the rows of a table.
struct RowsDigest {
    std::int64_t rows = 0;
    std::int64_t sum = 0;  ///< of their sums

    void add(std::int64_t row_sum) {
        ++rows;
        sum += row_sum;
    }
    void remove(std::int64_t row_sum) {
        --rows;
        sum -= row_sum;
    }
    [[nodiscard]] bool is_known() const { return rows != kNoSum; }
    friend bool operator==(const RowsDigest&, const RowsDigest&) = default;
};

inline constexpr RowsDigest kUnknownDigest{kNoSum, kNoSum};

}  // namespace takt::store
