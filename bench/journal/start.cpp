#include "start.hpp"

#include <fcntl.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>

#include "plant.hpp"
#include "takt/os/open.hpp"
#include "takt/store/journal.hpp"
#include "takt/store/posix_journal_storage.hpp"

namespace takt::bench {
namespace {

using namespace std::chrono_literals;

constexpr std::uint64_t kReserve = 2ULL << 30;  // of the disk
constexpr std::size_t kVariables = 2000;
constexpr std::size_t kCollected = 1700;  // about a full payload
constexpr std::string_view kNames[] = {"cloud"};
constexpr store::DestinationId kDestination{0};

double seconds_of(const auto& work) {
    const auto start = std::chrono::steady_clock::now();
    work();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// A journal with the default segments, open.
struct OpenJournal {
    explicit OpenJournal(const std::string& directory) {
        const store::JournalOptions options{.buffer_bytes = 64U << 20, .quota_bytes = 1ULL << 40};
        auto opened_storage = store::PosixJournalStorage::open(directory, options.segment_bytes);
        if (!opened_storage) throw Failure("the folder cannot be used");
        storage = *std::move(opened_storage);
        auto opened = store::Journal::open(*storage, options, kNames, now, 0);
        if (!opened) throw Failure("the journal cannot be opened");
        journal.emplace(*std::move(opened));
    }

    Instant now{};
    std::unique_ptr<store::PosixJournalStorage> storage;
    std::optional<store::Journal> journal;
};

// The records have the sequence numbers, counts and checksums of a real stream; their payloads are equal.
std::uint64_t fill(const std::string& directory, std::uint64_t bytes) {
    OpenJournal open(directory);
    std::vector<std::uint8_t> payload;
    std::uint64_t samples = 0;
    Plant(kVariables, Kind::floating)
        .collect(kCollected, 1, 1'000'000'000, [&](auto encoded, std::uint64_t count) {
            payload = std::move(encoded);
            samples = count;
        });
    while (open.journal->status().disk_bytes < bytes) {
        check_interrupted();
        if (!open.journal->append(open.now, {.samples = samples, .payload = payload}))
            throw Failure("the journal does not take a record");
        open.now += 1ms;
        open.journal->on_tick(open.now, 0);
        if (open.journal->status().failure) throw Failure("the journal cannot be written");
    }
    if (!open.journal->close(open.now)) throw Failure("the journal cannot be written");
    return open.journal->counters(kDestination).waiting;
}

void forget_cached(const std::string& directory) {
    for (const auto& entry : std::filesystem::directory_iterator(directory)) {
        const auto file = os::open_for_reading(entry.path().string());
        if (file) (void)::posix_fadvise(file->get(), 0, 0, POSIX_FADV_DONTNEED);
    }
}

}  // namespace

StartMeasured measure_start(std::uint64_t bytes, int runs, const WorkingFolder& folder) {
    const std::uint64_t free = folder.free_bytes();
    if (free < bytes + kReserve) {
        const std::uint64_t possible = free > 2 * kReserve ? free - kReserve : 0;
        fmt::print(stderr,
                   "The disk has {:.1f} GB: the start is measured with {:.1f} GB instead of {:.1f}.\n",
                   static_cast<double>(free) / 1e9, static_cast<double>(possible) / 1e9,
                   static_cast<double>(bytes) / 1e9);
        bytes = possible;
    }
    const std::string directory = folder.make("start");
    StartMeasured measured;
    measured.fill = seconds_of([&] { measured.waiting = fill(directory, bytes); });
    for (int i = 0; i < runs; ++i) {
        forget_cached(directory);
        for (auto* const figures : {&measured.cold, &measured.warm}) {
            check_interrupted();
            std::optional<OpenJournal> open;
            figures->push_back(seconds_of([&] { open.emplace(directory); }));
            const auto status = open->journal->status();
            measured.bytes = status.disk_bytes;
            measured.segments = status.segments;
            if (open->journal->counters(kDestination).waiting != measured.waiting)
                throw Failure("samples are missing after a start");
        }
    }
    std::filesystem::remove_all(directory);
    return measured;
}

}  // namespace takt::bench
