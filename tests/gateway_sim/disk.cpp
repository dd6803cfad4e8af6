#include "disk.hpp"

#include <cerrno>

#include "judge/records.hpp"

namespace takt::gatewaysim {

using namespace std::chrono_literals;

/// The storage that a run of the program owns.
class DiskPort final : public store::JournalStorage {
public:
    explicit DiskPort(Disk& disk) : disk_(disk) {}

    Result<std::vector<store::SegmentFile>> list_segments() override {
        if (disk_.crashed()) return fail(Code::io_failed, "disk", EIO);
        disk_.observer_.on_listed();
        return inner().list_segments();
    }
    Result<std::size_t> read(std::uint64_t segment, std::uint64_t offset,
                             std::span<std::uint8_t> into) override {
        if (const int error = disk_.prepare(disk_.mood_ == Disk::Mood::fails, false)) {
            disk_.settle(0);
            disk_.complaints_.count("disk_read_failed");
            return fail(Code::io_failed, "disk", error);
        }
        if (disk_.crashed()) return fail(Code::io_failed, "disk", EIO);
        return inner().read(segment, offset, into);
    }
    Result<std::uint64_t> create(std::uint64_t segment) override {
        return operate(
            true, [&] { return inner().create(segment); },
            [&](int error) { disk_.observer_.on_create(segment, error); });
    }
    Result<void> append(std::uint64_t segment, Bytes bytes) override {
        return operate(
            true, [&] { return inner().append(segment, bytes); },
            [&](int error) { disk_.observer_.on_append(segment, bytes, error); });
    }
    Result<void> sync(std::uint64_t segment) override {
        return operate(
            false, [&] { return inner().sync(segment); },
            [&](int error) { disk_.observer_.on_sync(segment, error); });
    }
    Result<void> remove(std::uint64_t segment) override {
        return operate(
            false, [&] { return inner().remove(segment); },
            [&](int error) { disk_.observer_.on_remove(segment, error); });
    }
    Result<std::size_t> read_cursor(std::string_view destination, unsigned slot,
                                    std::span<std::uint8_t> into) override {
        return inner().read_cursor(destination, slot, into);
    }
    Result<void> write_cursor(std::string_view destination, unsigned slot, Bytes bytes) override {
        return operate(
            false, [&] { return inner().write_cursor(destination, slot, bytes); },
            [&](int error) {
                disk_.has_cursor_ = true;
                disk_.observer_.on_cursor_written(bytes, error);
            });
    }
    Result<void> sync_cursor(std::string_view destination) override {
        return operate(
            false, [&] { return inner().sync_cursor(destination); },
            [&](int error) { disk_.observer_.on_cursor_synced(error); });
    }
    // A disk that does not keep the end of the stream: the judge knows only gaps that a run has written for
    // its own samples.
    Result<std::size_t> read_end(unsigned /*slot*/, std::span<std::uint8_t> /*into*/) override { return 0U; }
    Result<void> write_end(unsigned /*slot*/, Bytes /*bytes*/) override { return {}; }
    Result<void> sync_end() override { return {}; }

private:
    [[nodiscard]] store::test::SimulatedDisk& inner() { return disk_.disk_; }

    // An operation after the crash has no effect and is not reported.
    auto operate(bool grows, const auto& carry_out, const auto& report) -> decltype(carry_out()) {
        if (disk_.crashed()) return fail(Code::io_failed, "disk", EIO);
        const int error = disk_.prepare(true, grows);
        auto outcome = carry_out();
        disk_.settle(error);
        if (!outcome && outcome.error().code == Code::not_found) return outcome;
        report(outcome ? 0 : error != 0 ? error : EIO);
        return outcome;
    }

    Disk& disk_;
};

Disk::Disk(std::uint64_t seed, DiskObserver& observer, Complaints& complaints)
    : random_(sim::Random(seed).fork(0xD15C)), observer_(observer), complaints_(complaints) {}

std::unique_ptr<store::JournalStorage> Disk::connect() {
    return std::make_unique<DiskPort>(*this);
}

void Disk::set_mood(Mood mood) {
    mood_ = mood;
    failing_percent_ = random_.below(2) == 0 ? 100 : 30;
    left_ = random_.below(20'000);
}

int Disk::prepare(bool may_fail, bool grows) {
    if (mood_ == Mood::slow) busy_ += random_.below(4) == 0 ? random_.between(10ms, 3s) : 1ms;
    int error = 0;
    if (mood_ == Mood::fails && may_fail && random_.below(100) < failing_percent_) error = EIO;
    if (mood_ == Mood::full && grows && left_ == 0) error = ENOSPC;
    if (mood_ == Mood::full && grows) left_ -= std::min<std::uint64_t>(left_, 2000);
    if (may_fail && fail_once_) error = std::exchange(fail_once_, false) ? EIO : error;
    if (error == 0) return 0;
    ++failures_;
    complaints_.count(error == EIO ? "disk_failed" : "disk_full");
    disk_.fail_from = disk_.operations();
    disk_.fail_count = 1;
    disk_.error_number = error;
    return error;
}

void Disk::settle(int error) {
    disk_.fail_from = -1;
    // Other programs use the same disk.
    if (error == ENOSPC && random_.below(8) == 0) left_ = random_.below(20'000);
}

void Disk::cut_power() {
    const auto kind = random_.below(4);
    store::test::SimulatedDisk::Survival survival;
    survival.last_create = random_.below(2) == 0;
    survival.removed_return = random_.below(2) == 0;
    survival.piece = [&, kind](std::size_t index, std::size_t count, std::size_t size) -> std::size_t {
        switch (kind) {
            case 0: return 0;  // nothing
            case 1: return index + 1 < count ? size : std::min<std::size_t>(size, random_.below(512));
            case 2: return random_.below(2) == 0 ? size : 0;  // some, in any order
            default: return std::min<std::size_t>(size, random_.below(600));
        }
    };
    disk_ = disk_.after_crash(survival);
}

std::optional<Disk::Damage> Disk::damage_segment() {
    const auto contents = disk_.contents();
    if (contents.empty()) return std::nullopt;
    auto chosen = contents.begin();
    std::advance(chosen, random_.below(static_cast<std::uint32_t>(contents.size())));
    if (chosen->second.empty()) return std::nullopt;
    const Damage damage{chosen->first, random_.below(static_cast<std::uint32_t>(chosen->second.size()))};
    disk_.flip(damage.segment, damage.offset);
    return damage;
}

void Disk::damage_record(std::uint64_t segment, std::uint64_t sequence) {
    const auto bytes = disk_.contents().at(segment);
    for (const auto& record : read_records(bytes))
        if (record.facts.sequence == sequence && !record.payload.empty())
            disk_.flip(segment, static_cast<std::size_t>(record.payload.data() - bytes.data()));
}

std::vector<std::uint8_t> Disk::cursor(const std::string& name, unsigned slot) {
    std::vector<std::uint8_t> bytes(256);
    if (!has_cursor_) return {};
    const auto size = disk_.read_cursor(name, slot, bytes);
    bytes.resize(size ? *size : 0);
    return bytes;
}

void Disk::damage_cursor(const std::string& name, bool both) {
    for (unsigned slot = 0; slot < (both ? 2U : 1U); ++slot)
        if (!cursor(name, slot).empty())
            disk_.flip_cursor(name, slot * store::test::SimulatedDisk::kSlotOffset + 20);
}

}  // namespace takt::gatewaysim
