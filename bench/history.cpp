// The history: bytes of a sample by kind of data, samples a second into the file, and the time of queries.
#include <fmt/format.h>
#include <sqlite3.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include "takt/store/crc32c.hpp"
#include "takt/store/history.hpp"
#include "takt/store/history_codec.hpp"
#include "takt/store/history_reader.hpp"

namespace {

using namespace takt;
using Samples = std::vector<store::HistorySample>;

constexpr std::int64_t kMs = 1'000'000;
constexpr std::int64_t kSecond = 1000 * kMs;
constexpr std::int64_t kStart = 500'000 * 3600 * kSecond;
constexpr int kDay = 86'400;
constexpr double kRowBytes = 25;  // time 8, previous poll 8, value 8, quality 1

[[noreturn]] void end(const std::string& why) {
    fmt::print(stderr, "bench: {}\n", why);
    std::exit(1);
}

double cpu_seconds() {
    ::timespec time{};
    ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_nsec) / 1e9;
}

double seconds_of(const auto& work) {
    const auto start = std::chrono::steady_clock::now();
    work();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// A day of a variable that is polled once a second, 200 µs of jitter in each poll.
class Day {
public:
    explicit Day(bool only_changes) : only_changes_(only_changes) {}

    void poll(value::Value value) {
        const std::int64_t time = kStart + second_++ * kSecond + jitter_(random_) * 1000;
        const bool changed = samples.empty() || !value::same(samples.back().value, value);
        if (changed || !only_changes_)
            samples.push_back({.time_ns = time, .previous_ns = previous_, .value = std::move(value)});
        previous_ = time;
    }
    [[nodiscard]] double noise(double width) { return width * normal_(random_); }

    Samples samples;

private:
    bool only_changes_;
    std::int64_t second_ = 0;
    std::optional<std::int64_t> previous_;
    std::mt19937_64 random_{7};
    std::uniform_int_distribution<std::int64_t> jitter_{0, 400};
    std::normal_distribution<double> normal_;
};

struct Kind {
    std::string name;
    DataType type;
    bool scaled;
    value::Value (*value)(Day& day, int second);
};

double tenths(double value) {
    return std::nearbyint(value * 10) / 10;
}
double of_day(int second) {
    return std::sin(second * 2 * 3.14159265358979 / kDay);
}

const std::vector<Kind>& kinds() {
    using value::Value;
    static const std::vector<Kind> kKinds{
        {"slow temperature, scale 0.1", DataType::int16, true,
         [](Day& day, int s) { return Value(tenths(21 + 4 * of_day(s) + day.noise(0.03))); }},
        {"counter", DataType::uint32, false,
         [](Day& day, int s) {
             return Value(static_cast<std::uint64_t>(100'000 + s * 3 + std::abs(day.noise(1))));
         }},
        {"noisy power, int16", DataType::int16, false,
         [](Day& day, int s) {
             return Value(static_cast<std::int64_t>(4000 + 900 * of_day(s) + day.noise(25)));
         }},
        {"bool, 100 changes an hour", DataType::boolean, false,
         [](Day&, int s) { return Value(s / 36 % 2 == 0); }},
        {"float, all bits noisy", DataType::float32, false,
         [](Day& day, int s) {
             return Value(static_cast<double>(static_cast<float>(230 + 2 * of_day(s) + day.noise(0.4))));
         }},
        {"float of two decimals", DataType::float32, false,
         [](Day& day, int s) {
             return Value(static_cast<double>(
                 static_cast<float>(std::nearbyint((50 + 0.02 * of_day(s) + day.noise(0.01)) * 100) / 100)));
         }},
        {"constant setting", DataType::int16, false, [](Day&, int) { return Value(std::int64_t{1500}); }},
    };
    return kKinds;
}

Samples day_of(const Kind& kind, bool only_changes) {
    Day day(only_changes);
    for (int second = 0; second < kDay; ++second) day.poll(kind.value(day, second));
    return day.samples;
}

double encoded(const Samples& samples, std::size_t chunk, const store::HistoryCodecOptions& options) {
    std::size_t bytes = 0;
    for (std::size_t at = 0; at < samples.size(); at += chunk)
        bytes += store::encode_history(std::span(samples).subspan(at, std::min(chunk, samples.size() - at)),
                                       options)
                     .size();
    return static_cast<double>(bytes) / static_cast<double>(samples.size());
}

/// Bytes of a file with a row for each sample, and an index by series and time.
double sqlite_rows(const std::string& path, const Samples& samples) {
    std::filesystem::remove(path);
    ::sqlite3* database = nullptr;
    const auto run = [&](const char* text) {
        if (::sqlite3_exec(database, text, nullptr, nullptr, nullptr) != SQLITE_OK) end("sqlite");
    };
    if (::sqlite3_open(path.c_str(), &database) != SQLITE_OK) end("sqlite");
    run("CREATE TABLE sample (series INTEGER, time INTEGER, previous INTEGER, value REAL, quality INTEGER);"
        "CREATE INDEX by_time ON sample (series, time); BEGIN");
    ::sqlite3_stmt* insert = nullptr;
    ::sqlite3_prepare_v2(database, "INSERT INTO sample VALUES (1, ?, ?, ?, 1)", -1, &insert, nullptr);
    for (const auto& sample : samples) {
        ::sqlite3_bind_int64(insert, 1, sample.time_ns / kMs);
        ::sqlite3_bind_int64(insert, 2, sample.previous_ns.value_or(sample.time_ns) / kMs);
        struct Number {
            double operator()(std::monostate) const { return 0; }
            double operator()(const std::string&) const { return 0; }
            double operator()(bool value) const { return value ? 1 : 0; }
            double operator()(double value) const { return value; }
            double operator()(std::int64_t value) const { return static_cast<double>(value); }
            double operator()(std::uint64_t value) const { return static_cast<double>(value); }
        };
        ::sqlite3_bind_double(insert, 3, std::visit(Number{}, sample.value));
        ::sqlite3_step(insert);
        ::sqlite3_reset(insert);
    }
    ::sqlite3_finalize(insert);
    run("COMMIT");
    ::sqlite3_close(database);
    return static_cast<double>(std::filesystem::file_size(path)) / static_cast<double>(samples.size());
}

std::unique_ptr<store::History> new_history(const std::string& path) {
    for (const char* suffix : {"", "-wal", "-shm"}) std::filesystem::remove(path + suffix);
    auto opened = store::History::open(path);
    if (!opened) end("the history cannot be opened");
    return std::move(opened->history);
}

void commit(store::History& history, std::int64_t time_ns) {
    if (!history.commit(time_ns)) end("the history cannot be written");
}

double history_file(const std::string& path, const Kind& kind, const Samples& samples) {
    {
        const auto history = new_history(path);
        const auto id = history->series({kind.name, "", kind.type, kind.scaled, ""}).value();
        for (std::size_t i = 0; i < samples.size(); ++i) {
            history->append(id, samples[i]);
            if (i % 1000 == 999) commit(*history, samples[i].time_ns);
        }
        commit(*history, kStart + 2 * kDay * kSecond);
    }
    const auto history = std::move(store::History::open(path)->history);
    commit(*history, kStart + 2 * kDay * kSecond);  // folds the log
    return static_cast<double>(history->status().used_bytes) / static_cast<double>(samples.size());
}

void measure_sizes(const std::string& folder) {
    fmt::print(
        "\nBytes of a sample, a day polled once a second (file: all pages in use, roll-ups included)\n");
    fmt::print("{:<32} {:>9} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8}\n", "data", "samples", "plain", "zstd",
               "zstd µs", "file", "SQLite", "record");
    for (const bool only_changes : {false, true}) {
        fmt::print("{}\n", only_changes ? "each change a sample" : "each poll a sample");
        for (const auto& kind : kinds()) {
            const auto samples = day_of(kind, only_changes);
            if (samples.size() < 1000) continue;
            constexpr std::size_t chunk = 1000;
            fmt::print("{:<32} {:>9} {:>8.2f} {:>8.2f} {:>8.2f} {:>8.2f} {:>8.1f} {:>8.1f}\n", kind.name,
                       samples.size(), encoded(samples, chunk, {.compress = false}),
                       encoded(samples, chunk, {}), encoded(samples, chunk, {.unit_ns = 1000}),
                       history_file(folder + "/kind.db", kind, samples),
                       sqlite_rows(folder + "/rows.db", samples), kRowBytes);
        }
    }
}

constexpr int kSeries = 1000;

/// Bytes that the process has written to files.
std::size_t written_bytes() {
    std::ifstream io("/proc/self/io");
    for (std::string key; io >> key;) {
        std::size_t value = 0;
        io >> value;
        if (key == "wchar:") return value;
    }
    end("/proc/self/io");
}

/// The checksums of all rows cost less than one of every byte that SQLite wrote, pages and their copies in
/// the write-ahead log included.
void measure_checksums(std::size_t bytes, double cpu) {
    const std::vector<std::uint8_t> page(4096, 7);
    std::uint32_t sum = 0;
    const double start = cpu_seconds();
    for (std::size_t at = 0; at < bytes; at += page.size()) sum = store::crc32c(page, sum);
    const double used = cpu_seconds() - start;
    fmt::print("  a checksum of all {} MB written: {:.2f} s, {:.1f} % of the processor time ({:x})\n",
               bytes >> 20U, used, 100 * used / cpu, sum);
}

void measure_speed(const std::string& folder) {
    const std::string path = folder + "/speed.db";
    const auto history = new_history(path);
    std::vector<store::SeriesId> ids;
    for (int i = 0; i < kSeries; ++i)
        ids.push_back(history->series({fmt::format("v{}", i), "", DataType::int16, true, ""}).value());
    constexpr int kSeconds = 3600;
    double longest = 0;
    const std::size_t written = written_bytes();
    const double cpu = cpu_seconds();
    const double wall = seconds_of([&] {
        std::mt19937_64 random(7);
        for (int second = 0; second < kSeconds; ++second) {
            for (int i = 0; i < kSeries; ++i) {
                const std::int64_t time = kStart + second * kSecond + i * 150'000;
                history->append(ids[static_cast<std::size_t>(i)],
                                {.time_ns = time,
                                 .previous_ns = time - kSecond,
                                 .value = static_cast<double>(200 + (random() >> 61U)) / 10});
            }
            longest = std::max(longest, seconds_of([&] { commit(*history, kStart + second * kSecond); }));
        }
    });
    const double used = cpu_seconds() - cpu;
    constexpr double kCount = double{kSeconds} * kSeries;
    fmt::print("\n{} series once a second for an hour, a commit for each second\n", kSeries);
    fmt::print("  {:.0f} samples/s of wall time, {:.0f} samples/s of one core; longest commit {:.0f} ms\n",
               kCount / wall, kCount / used, longest * 1000);
    fmt::print("  {:.2f} bytes a sample in the pages in use\n",
               static_cast<double>(history->status().used_bytes) / kCount);
    measure_checksums(written_bytes() - written, used);
    auto reader = store::HistoryReader::open(path);
    const double query = seconds_of([&] {
        if (!reader->picture(ids[500], {kStart, kStart + kSeconds * kSecond}, 1000)) end("query");
    });
    fmt::print("  query of the hour of one series, the log among it: {:.1f} ms\n", query * 1000);
}

void measure_queries(const std::string& folder) {
    constexpr int kDays = 100;
    const std::string path = folder + "/queries.db";
    store::SeriesId id;
    {
        const auto history = new_history(path);
        id = history->series({"a", "", DataType::int16, true, ""}).value();
        std::mt19937_64 random(7);
        for (int second = 0; second < kDays * kDay; ++second) {
            const std::int64_t time = kStart + second * kSecond;
            history->append(id, {.time_ns = time,
                                 .previous_ns = time - kSecond,
                                 .value = static_cast<double>(200 + (random() >> 60U)) / 10});
            if (second % 20'000 == 0) commit(*history, kStart);
        }
        commit(*history, kStart);
    }
    auto reader = store::HistoryReader::open(path);
    fmt::print("\nA query for 1,000 pixels of one series at 1 Hz, the best of 5\n");
    const std::vector<std::pair<std::string, int>> ranges{{"an hour", 3600},
                                                          {"a day", kDay},
                                                          {"a week", 7 * kDay},
                                                          {"30 days", 30 * kDay},
                                                          {"100 days", kDays * kDay}};
    for (const auto& [name, seconds] : ranges) {
        double best = 1e9;
        std::size_t rolled_up = 0;
        for (int i = 0; i < 5; ++i)
            best = std::min(best, seconds_of([&] {
                                const auto picture =
                                    reader->picture(id, {kStart, kStart + seconds * kSecond}, 1000);
                                if (!picture || picture->samples != static_cast<std::uint64_t>(seconds))
                                    end("query");
                                rolled_up = picture->rolled_up;
                            }));
        fmt::print("  {:<10} {:>9} samples {:>8.1f} ms, {} roll-ups used\n", name, seconds, best * 1000,
                   rolled_up);
    }
    std::size_t count = 0;
    const double raw = seconds_of([&] {
        static_cast<void>(reader->read(id, {kStart, kStart + 10 * kDay * kSecond}, [&count](const auto&) {
            ++count;
            return true;
        }));
    });
    fmt::print("  every sample: {:.0f} million a second\n", static_cast<double>(count) / raw / 1e6);
}

}  // namespace

int main() {
    char folder[] = "/var/tmp/takt_bench_history_XXXXXX";
    if (::mkdtemp(folder) == nullptr) end("no folder");
    measure_sizes(folder);
    measure_speed(folder);
    measure_queries(folder);
    std::filesystem::remove_all(folder);
    return 0;
}
