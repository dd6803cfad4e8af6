// The files of the journal, as an interface: a directory, or a simulated disk.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "takt/base/engine.hpp"
#include "takt/base/result.hpp"

namespace takt::store {

/// A segment file. The number of each new segment is higher than all before.
struct SegmentFile {
    std::uint64_t number = 0;
    std::uint64_t bytes = 0;

    friend bool operator==(const SegmentFile&, const SegmentFile&) = default;
};

/// Bytes that were appended or written before a successful sync of their file survive a power cut. Other
/// bytes may survive in any order, partly, or not at all.
///
/// Errors: io_failed and cannot_open with the system's error number as the first argument (28: the disk is
/// full). One thread at a time.
class JournalStorage {
public:
    virtual ~JournalStorage() = default;

    /// @returns all segment files, in any order
    [[nodiscard]] virtual Result<std::vector<SegmentFile>> list_segments() = 0;
    /// @returns the number of bytes read: fewer than `into` only at the end of the file. 0 of a segment that
    ///          does not exist
    [[nodiscard]] virtual Result<std::size_t> read(std::uint64_t segment, std::uint64_t offset,
                                                   std::span<std::uint8_t> into) = 0;
    /// Creates an empty segment; after success its name survives a power cut. After an error it may exist.
    /// @returns the bytes that the segment should have at most: few if the disk is nearly full
    [[nodiscard]] virtual Result<std::uint64_t> create(std::uint64_t segment) = 0;
    /// After an error any part of `bytes` may be in the file.
    [[nodiscard]] virtual Result<void> append(std::uint64_t segment, Bytes bytes) = 0;
    /// After an error the state of all bytes since the last successful sync is unknown, also when a read
    /// returns them: the system may have dropped the pages. A segment that was removed by another program is
    /// an error.
    [[nodiscard]] virtual Result<void> sync(std::uint64_t segment) = 0;
    /// A removed segment may exist again after a power cut, until a later create() has succeeded. Removing a
    /// segment that does not exist succeeds.
    [[nodiscard]] virtual Result<void> remove(std::uint64_t segment) = 0;

    /// Reads a slot (0 or 1) of the cursor file of a destination.
    /// @returns the number of bytes read, 0 for a slot that was not written
    [[nodiscard]] virtual Result<std::size_t> read_cursor(std::string_view destination, unsigned slot,
                                                          std::span<std::uint8_t> into) = 0;
    /// Writes a slot; creates the file. The other slot keeps its bytes, also in a power cut.
    [[nodiscard]] virtual Result<void> write_cursor(std::string_view destination, unsigned slot,
                                                    Bytes bytes) = 0;
    /// Makes the slots of a destination and the name of its file durable. @returns not_found
    [[nodiscard]] virtual Result<void> sync_cursor(std::string_view destination) = 0;

    /// As the functions for cursors, of the file with the end of the stream. @returns 0 bytes: there is no
    /// file
    [[nodiscard]] virtual Result<std::size_t> read_end(unsigned slot, std::span<std::uint8_t> into) = 0;
    [[nodiscard]] virtual Result<void> write_end(unsigned slot, Bytes bytes) = 0;
    [[nodiscard]] virtual Result<void> sync_end() = 0;

    /// Where something was moved that had the name of a segment or cursor and is no file: a folder, a FIFO.
    /// The last one; empty: there was none.
    [[nodiscard]] virtual std::string set_aside() const { return {}; }
};

}  // namespace takt::store
