// Damage of a history file: what its checksums and counts show.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace takt::store {

/// The part of the file that is damaged.
enum class HistoryPart : std::uint8_t {
    log,       ///< the samples of a commit that are in no chunk yet, of any variables
    chunk,     ///< samples of one variable
    rollup,    ///< rows that name the chunks of a variable
    gap,       ///< recorded gaps
    series,    ///< a variable: its name or properties
    state,     ///< the last commit: how many rows the other tables have is unknown, too
    recorded,  ///< a gap of cause `damaged`, which a writer has put in the place of damaged samples
};

/// The stable name of a part, as in "chunk".
[[nodiscard]] std::string_view name(HistoryPart part);

/// A damaged row, or rows that are missing. The times are those of the samples that may be missing.
struct HistoryDamage {
    HistoryPart part = HistoryPart::chunk;
    std::int64_t row = 0;                  ///< its number in the table; 0: unknown, or several rows
    std::string variable = {};             ///< empty: unknown, or several
    std::optional<std::int64_t> first_ns;  ///< since 1970 UTC; nothing: unknown. Set together with last_ns
    std::optional<std::int64_t> last_ns;
    std::uint64_t samples = 0;  ///< that are missing; 0: unknown

    friend bool operator==(const HistoryDamage&, const HistoryDamage&) = default;
};

}  // namespace takt::store
