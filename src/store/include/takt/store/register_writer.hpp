// Retained registers: a thread of its own writes their changes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "takt/store/register_file.hpp"

namespace takt::store {

/// When a change counts as kept.
enum class Durability : std::uint8_t {
    acknowledged,  ///< it is synchronised with the disk before it is acknowledged
    interval,      ///< it is acknowledged at once and written within the interval
    at_end,        ///< it is acknowledged at once and written at the orderly end
};

/// Keeps the image of a unit's registers.
///
/// change() never waits for the disk: the thread takes all that came meanwhile as one commit, so many writers
/// share a synchronisation. With Durability::acknowledged a commit that fails stops the thread until
/// roll_back(); else it is tried again each second. All members are called by the owner's thread.
class RegisterWriter {
public:
    struct Options {
        Durability durability = Durability::acknowledged;
        Duration interval = std::chrono::milliseconds(100);
        /// Called on the writing thread after each commit.
        std::function<void()> on_progress;
    };

    /// The progress of writing. Changes with a ticket of at most `durable` are on the disk.
    struct Progress {
        std::uint64_t durable = 0;
        bool failed = false;   ///< the last commit
        bool stopped = false;  ///< by a failure: roll_back() is to be called
        Error why;             ///< io_failed (file, system's error number)
    };

    /// @param storage  of `file`; lives as long as this
    RegisterWriter(std::unique_ptr<BlockFile> storage, RegisterFile file, Options options);
    /// close()
    ~RegisterWriter();
    RegisterWriter(const RegisterWriter&) = delete;
    RegisterWriter& operator=(const RegisterWriter&) = delete;

    struct Change {
        std::size_t offset = 0;  ///< in the image
        Bytes bytes;
    };

    /// Changes the image, all at once.
    /// @returns the ticket it waits for; that of an earlier one where it changes nothing
    std::uint64_t change(std::span<const Change> changes);

    [[nodiscard]] Progress progress() const;

    /// After a failure: the image is the durable one again, and the thread goes on.
    /// @param image  filled with it
    void roll_back(std::vector<std::uint8_t>& image);

    /// Writes the remaining changes, tries once, and ends the thread. Later changes are not written.
    void close();

    [[nodiscard]] RegisterFile::Counters counters() const;

private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

/// A file of retained registers, opened or made.
struct OpenedRegisters {
    std::unique_ptr<BlockFile> storage;
    RegisterFile file;
    std::uint32_t taken = 0;    ///< items that were found in it
    std::uint32_t missing = 0;  ///< items that it does not have: they are as in `defaults`
    bool other_layout = false;  ///< it was of another layout; the old file was set aside
    bool was_damaged = false;   ///< one of its two copies was no good; the other served
    bool is_new = false;        ///< there was no file, or it was damaged beyond use and set aside
    std::string set_aside;      ///< where the file was moved; empty: it was not
};

/// Opens the file under `path` with that layout, or makes it with `defaults`. A file that is empty or damaged
/// beyond use is moved aside to the first free of "PATH.damaged-1" to "-999", a file of another layout to
/// "PATH.old-1" to "-999"; items of both layouts are taken over.
/// @returns busy, cannot_open, io_failed as the files do; unsupported (path, version): no regular file, of
///          another program, or a newer version; it is left alone, as is a file beside it with a name that is
///          needed for a new one
[[nodiscard]] Result<OpenedRegisters> open_registers(const std::string& path, const RegisterLayout& layout,
                                                     Bytes defaults);

}  // namespace takt::store
