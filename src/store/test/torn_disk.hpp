// A disk that loses, reorders and tears what was not synchronised when the power goes.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <vector>

#include "takt/store/block_file.hpp"

namespace takt::store::test {

class TornDisk final : public BlockFile {
public:
    static constexpr std::size_t kSector = 512;

    /// A part of a write that was not synchronised.
    struct Piece {
        std::uint64_t offset = 0;
        std::vector<std::uint8_t> bytes;  // at most a sector
    };
    /// How many bytes of a piece arrive: 0 to all.
    using Survival = std::function<std::size_t(const Piece&)>;

    explicit TornDisk(std::uint64_t size) : durable_(size), seen_(size) {}

    int fuse = -1;        ///< operations until the power goes; -1: it stays
    Survival fails_sync;  ///< the next sync() fails, and leaves this

    [[nodiscard]] bool cut() const { return cut_; }
    [[nodiscard]] int operations() const { return operations_; }
    [[nodiscard]] const std::vector<Piece>& unsynced() const { return unsynced_; }
    [[nodiscard]] const std::vector<std::uint8_t>& durable() const { return durable_; }

    /// The disk after the power is back.
    [[nodiscard]] TornDisk after_cut(const Survival& survival) const {
        TornDisk disk(durable_.size());
        disk.durable_ = durable_;
        disk.arrive(unsynced_, survival);
        disk.seen_ = disk.durable_;
        return disk;
    }

    Result<std::uint64_t> size() override { return durable_.size(); }

    Result<void> read_at(std::uint64_t offset, std::span<std::uint8_t> into) override {
        if (offset + into.size() > seen_.size()) return fail(Code::too_short);
        std::copy_n(seen_.begin() + static_cast<std::ptrdiff_t>(offset), into.size(), into.begin());
        return {};
    }

    Result<void> write_at(std::uint64_t offset, Bytes bytes) override {
        if (cut_) return fail(Code::io_failed);
        std::ranges::copy(bytes, seen_.begin() + static_cast<std::ptrdiff_t>(offset));
        while (!bytes.empty()) {
            const std::size_t length = std::min<std::size_t>(bytes.size(), kSector - offset % kSector);
            unsynced_.push_back(
                {offset, {bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(length)}});
            offset += length;
            bytes = bytes.subspan(length);
        }
        return operate();
    }

    Result<void> sync() override {
        if (cut_) return fail(Code::io_failed);
        if (auto left = operate(); !left) return left;
        const Survival failing = std::exchange(fails_sync, {});
        arrive(unsynced_, failing ? failing : [](const Piece& piece) { return piece.bytes.size(); });
        unsynced_.clear();  // after a failure too: the system does not write them again
        if (failing) return fail(Code::io_failed);
        return {};
    }

private:
    Result<void> operate() {
        ++operations_;
        if (fuse >= 0 && fuse-- == 0) {
            cut_ = true;
            return fail(Code::io_failed);
        }
        return {};
    }

    void arrive(const std::vector<Piece>& pieces, const Survival& survival) {
        for (const Piece& piece : pieces)
            std::copy_n(piece.bytes.begin(), survival(piece),
                        durable_.begin() + static_cast<std::ptrdiff_t>(piece.offset));
    }

    std::vector<std::uint8_t> durable_;
    std::vector<std::uint8_t> seen_;  // by who reads while the power is on
    std::vector<Piece> unsynced_;
    int operations_ = 0;
    bool cut_ = false;
};

}  // namespace takt::store::test
