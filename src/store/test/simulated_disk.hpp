// The files of a journal on a disk that loses, reorders and tears what was not synchronised when the power
// goes.
#pragma once

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "takt/store/journal_storage.hpp"

namespace takt::store::test {

class SimulatedDisk final : public JournalStorage {
public:
    static constexpr std::size_t kSector = 512;
    static constexpr std::uint64_t kSlotOffset = 4096;  // of cursor slot 1

    /// What a power cut leaves. How many bytes of a piece (a part of a sector) arrive: 0 to `size`.
    struct Survival {
        std::function<std::size_t(std::size_t index, std::size_t count, std::size_t size)> piece;
        bool last_create = true;      // the segment whose creation was cut exists
        bool removed_return = false;  // segments that were removed exist again
    };

    int crash_at = -1;   ///< number of the operation at which the power goes; -1: never
    int fail_from = -1;  ///< number of the first operation that fails
    int fail_count = 0;  ///< operations that fail from there
    int error_number = EIO;
    std::uint64_t segment_limit = 1U << 30;  ///< what create() returns
    bool full = false;                       ///< create() and append() fail
    std::optional<std::uint64_t> keeps;      ///< a segment that cannot be removed

    [[nodiscard]] int operations() const { return operations_; }
    [[nodiscard]] bool crashed() const { return crashed_; }
    [[nodiscard]] std::map<std::uint64_t, std::vector<std::uint8_t>> contents() const {
        std::map<std::uint64_t, std::vector<std::uint8_t>> all;
        for (const auto& [number, file] : segments_) all[number] = file.seen;
        return all;
    }
    /// Changes a byte of a segment on the disk.
    void flip(std::uint64_t segment, std::size_t offset) {
        segments_.at(segment).seen.at(offset) ^= 0x10;
        segments_.at(segment).durable.at(offset) ^= 0x10;
    }
    /// Takes bytes off the end of a segment, or all of it.
    void truncate(std::uint64_t segment, std::size_t bytes) {
        segments_.at(segment).seen.resize(bytes);
        segments_.at(segment).durable.resize(bytes);
    }
    void zero(std::uint64_t segment) { std::ranges::fill(segments_.at(segment).seen, std::uint8_t{0}); }
    void remove_segment(std::uint64_t segment) { segments_.erase(segment); }
    void remove_cursor(const std::string& name) { cursors_.erase(name); }
    void flip_cursor(const std::string& name, std::size_t offset) {
        cursors_.at(name).seen.at(offset) ^= 0x10;
    }

    /// The disk after the power is back.
    [[nodiscard]] SimulatedDisk after_crash(const Survival& survival) const {
        SimulatedDisk disk;
        disk.segments_ = segments_;
        if (!survival.last_create && creating_) disk.segments_.erase(*creating_);
        if (survival.removed_return) disk.segments_.insert(removed_.begin(), removed_.end());
        disk.cursors_ = cursors_;
        for (auto& [number, file] : disk.segments_) file.lose(survival);
        for (auto& [name, file] : disk.cursors_) file.lose(survival);
        disk.end_ = end_;
        disk.end_.lose(survival);
        return disk;
    }

    /// The disk after the process was killed at `crash_at`: the system keeps what was not synchronised.
    [[nodiscard]] SimulatedDisk after_kill() const {
        SimulatedDisk disk;
        disk.segments_ = segments_;
        disk.cursors_ = cursors_;
        disk.removed_ = removed_;
        disk.end_ = end_;
        return disk;
    }

    Result<std::vector<SegmentFile>> list_segments() override {
        std::vector<SegmentFile> files;
        for (const auto& [number, file] : segments_) files.push_back({number, file.seen.size()});
        std::ranges::reverse(files);
        return files;
    }
    Result<std::size_t> read(std::uint64_t segment, std::uint64_t offset,
                             std::span<std::uint8_t> into) override {
        const auto found = segments_.find(segment);
        return found == segments_.end() ? std::size_t{0} : found->second.read(offset, into);
    }
    Result<std::uint64_t> create(std::uint64_t segment) override {
        creating_ = segment;
        if (full) return fail(Code::io_failed, "disk", ENOSPC);
        const auto outcome = operate();
        if (!crashed_before_) segments_[segment] = {};  // after an error too
        TAKT_CHECK(outcome);
        creating_.reset();
        removed_.clear();
        return segment_limit;
    }
    Result<void> append(std::uint64_t segment, Bytes bytes) override {
        if (full) return fail(Code::io_failed, "disk", ENOSPC);
        const auto outcome = operate();
        if (crashed_before_) return outcome;
        File& file = segments_.at(segment);
        file.write(file.seen.size(), outcome || crashed_ ? bytes : bytes.first(bytes.size() / 2));
        return outcome;
    }
    Result<void> sync(std::uint64_t segment) override { return sync(segments_.at(segment)); }
    Result<void> remove(std::uint64_t segment) override {
        const auto outcome = operate();
        if (segment == keeps) return fail(Code::io_failed, "disk", error_number);
        const auto found = segments_.find(segment);
        if (crashed_before_ || !outcome || found == segments_.end()) return outcome;
        removed_.insert(*found);
        segments_.erase(found);
        return outcome;
    }

    Result<std::size_t> read_cursor(std::string_view name, unsigned slot,
                                    std::span<std::uint8_t> into) override {
        return cursors_.at(std::string(name)).read(slot * kSlotOffset, into);
    }
    Result<void> write_cursor(std::string_view name, unsigned slot, Bytes bytes) override {
        const auto outcome = operate();
        if (crashed_before_) return outcome;
        cursors_[std::string(name)].write(slot * kSlotOffset,
                                          outcome || crashed_ ? bytes : bytes.first(bytes.size() / 2));
        return outcome;
    }
    Result<void> sync_cursor(std::string_view name) override {
        const auto found = cursors_.find(std::string(name));
        if (found == cursors_.end()) return fail(Code::not_found, name);
        return sync(found->second);
    }

    Result<std::size_t> read_end(unsigned slot, std::span<std::uint8_t> into) override {
        return end_.read(slot * kSector, into);
    }
    Result<void> write_end(unsigned slot, Bytes bytes) override {
        const auto outcome = operate();
        if (!crashed_before_)
            end_.write(slot * kSector, outcome || crashed_ ? bytes : bytes.first(bytes.size() / 2));
        return outcome;
    }
    Result<void> sync_end() override { return sync(end_); }

private:
    struct Piece {
        std::uint64_t offset = 0;
        std::vector<std::uint8_t> bytes;  // at most a sector
    };

    struct File {
        std::vector<std::uint8_t> durable;
        std::vector<std::uint8_t> seen;  // while the power is on
        std::vector<Piece> unsynced;

        [[nodiscard]] std::size_t read(std::uint64_t offset, std::span<std::uint8_t> into) const {
            if (offset >= seen.size()) return 0;
            const std::size_t size = std::min(into.size(), seen.size() - static_cast<std::size_t>(offset));
            std::copy_n(seen.begin() + static_cast<std::ptrdiff_t>(offset), size, into.begin());
            return size;
        }
        void write(std::uint64_t offset, Bytes bytes) {
            put(seen, offset, bytes);
            while (!bytes.empty()) {
                const std::size_t size = std::min<std::size_t>(bytes.size(), kSector - offset % kSector);
                unsynced.push_back(
                    {offset, {bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size)}});
                offset += size;
                bytes = bytes.subspan(size);
            }
        }
        void lose(const Survival& survival) {
            for (std::size_t i = 0; i < unsynced.size(); ++i) {
                const Bytes bytes = unsynced[i].bytes;
                const std::size_t size = survival.piece(i, unsynced.size(), bytes.size());
                if (size > 0) put(durable, unsynced[i].offset, bytes.first(size));
            }
            unsynced.clear();
            seen = durable;
        }
        static void put(std::vector<std::uint8_t>& into, std::uint64_t offset, Bytes bytes) {
            if (into.size() < offset + bytes.size()) into.resize(offset + bytes.size());
            std::ranges::copy(bytes, into.begin() + static_cast<std::ptrdiff_t>(offset));
        }
    };

    Result<void> sync(File& file) {
        const auto outcome = operate();
        if (crashed_) return outcome;
        if (outcome)
            for (const Piece& piece : file.unsynced) File::put(file.durable, piece.offset, piece.bytes);
        file.unsynced.clear();  // after an error too: the system has dropped the pages, but still reads them
        return outcome;
    }

    Result<void> operate() {
        crashed_before_ = crashed_;
        const int now = operations_++;
        if (now == crash_at) crashed_ = true;
        const bool fails = fail_from >= 0 && now >= fail_from && now < fail_from + fail_count;
        if (crashed_ || fails) return fail(Code::io_failed, "disk", error_number);
        return {};
    }

    std::map<std::uint64_t, File> segments_;
    std::map<std::uint64_t, File> removed_;
    std::map<std::string, File> cursors_;
    File end_;
    std::optional<std::uint64_t> creating_;
    int operations_ = 0;
    bool crashed_ = false;
    bool crashed_before_ = false;  // the operation is after the power cut
};

}  // namespace takt::store::test
