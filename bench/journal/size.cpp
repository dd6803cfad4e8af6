#include "size.hpp"

#include <algorithm>

#include "takt/store/journal_record.hpp"

namespace takt::bench {
namespace {

constexpr std::int64_t kStart = 1'700'000'000'000'000'000;
constexpr std::int64_t kSecond = 1'000'000'000;

struct Case {
    const char* name;
    std::size_t variables;
    std::size_t collected;  // samples that are collected together
    std::size_t per_second;
};

constexpr Case kCases[] = {
    {"1,000 variables, 200,000 samples/s", 1000, 10'000, 200'000},
    {"5,000 variables each second", 5000, 250, 5000},
    {"500 variables each second", 500, 25, 500},
    {"10 variables each second, one by one", 10, 1, 10},
    {"10 variables each second, together", 10, 10, 10},
};

double bytes_of_sample(const Case& of, Kind kind, double& samples_a_record) {
    Plant plant(of.variables, kind);
    std::vector<std::uint8_t> records;
    std::size_t samples = 0;
    std::size_t count = 0;
    const auto length = static_cast<std::int64_t>(of.collected * kSecond / of.per_second);
    const std::size_t rounds = std::max<std::size_t>(20, 20 * of.variables / of.collected);
    std::int64_t time = kStart;
    for (std::size_t i = 0; i < rounds; ++i, time += length)
        plant.collect(of.collected, time, time + length, [&](const auto& payload, std::uint64_t of_record) {
            store::encode_record({.samples = of_record}, payload, records);
            samples += of_record;
            ++count;
        });
    samples_a_record = static_cast<double>(samples) / static_cast<double>(count);
    return static_cast<double>(records.size()) / static_cast<double>(samples);
}

}  // namespace

std::vector<Size> measure_sizes() {
    std::vector<Size> sizes;
    for (const Case& of : kCases) {
        Size size{.plant = of.name};
        for (const Kind kind : {Kind::floating, Kind::integer, Kind::boolean})
            size.bytes.push_back(bytes_of_sample(of, kind, size.samples_a_record));
        sizes.push_back(std::move(size));
    }
    return sizes;
}

}  // namespace takt::bench
