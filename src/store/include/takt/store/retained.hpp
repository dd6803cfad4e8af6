// Values that survive the end of the program, however it ends (docs/specification.md, section 2: retain).
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "takt/base/data_type.hpp"
#include "takt/base/result.hpp"
#include "takt/value/value.hpp"

namespace takt::store {

/// One value under its name, with the type it had when it was kept.
struct Retained {
    std::string name;
    DataType type = DataType::int16;
    bool scaled = false;  ///< its values are doubles, whichever the type
    value::Value value;   ///< std::monostate: none
    value::Value wanted;  ///< what the project last set a written variable to; std::monostate: nothing
};

/// How far the writing is. A ticket at most `durable` is on the disk; one above it and at most `failed` is
/// not, and is tried again.
struct Progress {
    std::uint64_t durable = 0;
    std::uint64_t failed = 0;
    Error why;  ///< of the last failure: io_failed (file, system's error number), replaced (file)
};

/// A file of retained values and the thread that writes it.
///
/// put() never waits for the disk: the thread takes all that has come meanwhile and writes it as one
/// transaction, synchronised with the disk before it counts as durable. At most one entry waits for
/// each name. A transaction that fails is tried again each second, with what came meanwhile.
///
/// The file is an SQLite database (application id "Takt", one table; each row has a checksum). One program at
/// a time has it open. put() and progress(): any thread.
class RetainedFile {
public:
    struct Opened;

    /// Opens or makes the file, and reads what is in it. A damaged file is moved aside, whole, to the first
    /// free of "PATH.damaged-1" to "-999", and a new one begun.
    /// @param on_progress  called on the writing thread after each transaction; may be empty
    /// @returns busy (another program has it open); unsupported (it does not begin like such a file, is none,
    ///          or of a newer version: it is left alone); cannot_open, io_failed with the system's error
    ///          number
    [[nodiscard]] static Result<Opened> open(const std::string& path, std::function<void()> on_progress);

    /// The contents of the file, without opening it for writing: for a folder that cannot be written to.
    /// @returns as open(); malformed also for a damaged file; not_found
    [[nodiscard]] static Result<std::vector<Retained>> read(const std::string& path);

    /// close()
    ~RetainedFile();
    RetainedFile(const RetainedFile&) = delete;
    RetainedFile& operator=(const RetainedFile&) = delete;

    /// Keeps a value in place of the one of that name. @returns its ticket: 1, 2, 3, …
    std::uint64_t put(Retained entry);

    [[nodiscard]] Progress progress() const;

    /// Writes the remaining entries, tries once, and ends the thread. Later entries are not written.
    void close();

private:
    struct Impl;
    explicit RetainedFile(std::unique_ptr<Impl> impl);
    std::unique_ptr<Impl> impl_;
};

struct RetainedFile::Opened {
    std::unique_ptr<RetainedFile> file;
    std::vector<Retained> values;  ///< by name
    std::string set_aside;         ///< where a damaged file was moved; empty: there was none
};

}  // namespace takt::store
