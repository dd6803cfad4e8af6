// The files of a journal in a directory.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "takt/os/descriptor.hpp"
#include "takt/store/journal_storage.hpp"

namespace takt::store {

/// Segments are `segment-NUMBER` (20 digits), cursors `cursor-NAME`, the end is `stream-end`. What has such a
/// name and is no file gets the suffix `.damaged-N`. Other files are left alone. The
/// directory is locked against other programs for as long as this object exists. If it is removed meanwhile,
/// the next sync fails, and the next segment is created in a new directory.
class PosixJournalStorage final : public JournalStorage {
public:
    /// @param directory      exists and is writable
    /// @param segment_bytes  disk space to reserve for each segment, see JournalOptions
    /// @returns cannot_open (directory, system's error number), busy (directory): another program uses it
    [[nodiscard]] static Result<std::unique_ptr<PosixJournalStorage>> open(const std::string& directory,
                                                                           std::uint64_t segment_bytes);

    [[nodiscard]] Result<std::vector<SegmentFile>> list_segments() override;
    [[nodiscard]] Result<std::size_t> read(std::uint64_t segment, std::uint64_t offset,
                                           std::span<std::uint8_t> into) override;
    [[nodiscard]] Result<std::uint64_t> create(std::uint64_t segment) override;
    [[nodiscard]] Result<void> append(std::uint64_t segment, Bytes bytes) override;
    [[nodiscard]] Result<void> sync(std::uint64_t segment) override;
    [[nodiscard]] Result<void> remove(std::uint64_t segment) override;
    [[nodiscard]] Result<std::size_t> read_cursor(std::string_view destination, unsigned slot,
                                                  std::span<std::uint8_t> into) override;
    [[nodiscard]] Result<void> write_cursor(std::string_view destination, unsigned slot,
                                            Bytes bytes) override;
    [[nodiscard]] Result<void> sync_cursor(std::string_view destination) override;
    [[nodiscard]] Result<std::size_t> read_end(unsigned slot, std::span<std::uint8_t> into) override;
    [[nodiscard]] Result<void> write_end(unsigned slot, Bytes bytes) override;
    [[nodiscard]] Result<void> sync_end() override;
    [[nodiscard]] std::string set_aside() const override { return set_aside_; }

private:
    struct OpenSegment {
        std::uint64_t number = 0;
        os::Descriptor file;
    };

    PosixJournalStorage(std::string directory, os::Descriptor folder, std::uint64_t segment_bytes);
    [[nodiscard]] std::string path_of(std::uint64_t segment) const;
    [[nodiscard]] std::string path_of(std::string_view destination) const;
    [[nodiscard]] Result<int> writable(std::uint64_t segment);
    [[nodiscard]] Result<int> cursor(std::string_view destination, bool create);
    [[nodiscard]] Result<void> replace_removed_folder();
    [[nodiscard]] Result<void> sync_folder();
    [[nodiscard]] Result<void> move_aside(const std::string& path);
    [[nodiscard]] Result<os::Descriptor> end_file(bool create);

    std::string directory_;
    os::Descriptor folder_;
    std::uint64_t segment_bytes_;
    std::optional<OpenSegment> written_;  // kept: an error of the disk is reported to it
    std::optional<OpenSegment> read_;     // the last one
    std::map<std::string, os::Descriptor, std::less<>> cursors_;
    std::string set_aside_;
    bool folder_changed_ = true;  // a name may not be durable
};

}  // namespace takt::store
