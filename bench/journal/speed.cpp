#include "speed.hpp"

#include <algorithm>
#include <chrono>
#include <ctime>
#include <filesystem>
#include <memory>
#include <optional>
#include <thread>
#include <utility>

#include "takt/store/journal.hpp"
#include "takt/store/posix_journal_storage.hpp"

namespace takt::bench {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

constexpr Duration kCollect = 50ms;  // as Outputs
constexpr store::DestinationId kDestination{0};

Instant now() {
    return Instant(std::chrono::duration_cast<Duration>(Clock::now().time_since_epoch()));
}

std::int64_t wall_ns() {
    return std::chrono::duration_cast<Duration>(std::chrono::system_clock::now().time_since_epoch()).count();
}

double thread_seconds() {
    ::timespec time{};
    ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_nsec) / 1e9;
}

/// Adds the processor time of its scope to a sum.
class Stopwatch {
public:
    explicit Stopwatch(double& sum) : sum_(sum), start_(thread_seconds()) {}
    ~Stopwatch() { sum_ += thread_seconds() - start_; }
    Stopwatch(const Stopwatch&) = delete;
    Stopwatch& operator=(const Stopwatch&) = delete;

private:
    double& sum_;
    double start_;
};

class Run {
public:
    Run(const SpeedOptions& options, const std::string& folder)
        : options_(options), plant_(options.variables, options.kind) {
        const store::JournalOptions journal{.buffer_bytes = 4U << 20};  // as an output of a project
        auto storage = store::PosixJournalStorage::open(folder, journal.segment_bytes);
        if (!storage) throw Failure("the folder cannot be used");
        storage_ = *std::move(storage);
        const std::string_view names[] = {"cloud"};
        auto opened = store::Journal::open(*storage_, journal, names, now(), wall_ns());
        if (!opened) throw Failure("the journal cannot be opened");
        journal_.emplace(*std::move(opened));
    }

    SpeedMeasured run() {
        const Instant start = now();
        const Instant end = start + std::chrono::seconds(options_.seconds);
        Instant collect_at = start + kCollect;
        while (collect_at <= end) {
            check_interrupted();
            const Instant until = std::min(collect_at, journal_->next_wakeup());
            std::this_thread::sleep_for(std::max<Duration>(until - now(), 0ns));
            if (now() >= collect_at) {
                measured_.most_late = std::max(measured_.most_late, seconds(now() - collect_at));
                collect();
                collect_at += kCollect;
            }
            tick();
            read();
        }
        measured_.seconds = seconds(now() - start);
        if (!journal_->close(now())) throw Failure("the journal cannot be written");
        read();
        finish();
        return measured_;
    }

private:
    static double seconds(Duration duration) { return static_cast<double>(duration.count()) / 1e9; }

    void collect() {
        const auto count = options_.per_second * static_cast<std::size_t>(kCollect / 1ms) / 1000;
        const std::int64_t wall = wall_ns();
        const double before = measured_.write;
        const Stopwatch watch(measured_.encode);
        plant_.collect(
            count, std::exchange(collected_until_, wall), wall, [&](auto payload, std::uint64_t samples) {
                const Stopwatch of_append(measured_.write);
                const Instant t = now();
                const bool appended = journal_
                                          ->append(t, {.samples = samples,
                                                       .wall_ns = wall,
                                                       .monotonic_ns = t.time_since_epoch().count(),
                                                       .payload = payload})
                                          .has_value();
                if (appended) measured_.samples += samples;
            });
        measured_.encode -= measured_.write - before;
    }

    void tick() {
        const Instant start = now();
        if (journal_->next_wakeup() > start) return;
        const Stopwatch watch(measured_.write);
        journal_->on_tick(start, wall_ns());
        measured_.longest_tick = std::max(measured_.longest_tick, seconds(now() - start));
    }

    void read() {
        const Stopwatch watch(measured_.read);
        for (;;) {
            const auto entry = journal_->read(kDestination);
            if (!entry) throw Failure("the journal cannot be read");
            if (!*entry) return;
            if (!(*entry)->gap) check((*entry)->payload);
            if (!journal_->acknowledge(now(), kDestination, (*entry)->header.sequence))
                throw Failure("an entry cannot be acknowledged");
        }
    }

    // The variables are sampled in turn, so each record continues the one before.
    void check(Bytes payload) {
        const auto batch = publish::decode_samples(payload);
        if (!batch) throw Failure("a record is damaged");
        for (const auto& sample : batch->samples) {
            if (sample.wall_ns < last_wall_) throw Failure("samples are out of order");
            last_wall_ = sample.wall_ns;
        }
        measured_.delivered += batch->samples.size();
    }

    void finish() {
        const auto status = journal_->status();
        measured_.syncs = status.syncs;
        measured_.disk_bytes = status.disk_bytes;
        if (measured_.delivered != measured_.samples) throw Failure("samples are missing");
    }

    const SpeedOptions& options_;
    Plant plant_;
    std::unique_ptr<store::PosixJournalStorage> storage_;
    std::optional<store::Journal> journal_;
    SpeedMeasured measured_;
    std::int64_t collected_until_ = wall_ns();
    std::int64_t last_wall_ = 0;  // of the last sample that was read
};

}  // namespace

SpeedMeasured measure_speed(const SpeedOptions& options, const WorkingFolder& folder) {
    const std::string directory = folder.make("speed");
    const auto measured = Run(options, directory).run();
    std::filesystem::remove_all(directory);
    return measured;
}

}  // namespace takt::bench
