// A history in a folder of its own, and times for its samples.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <vector>

#include "directory.hpp"
#include "takt/store/history.hpp"
#include "takt/store/history_reader.hpp"

namespace takt::store::history_rig {

inline constexpr std::int64_t kSecond = 1'000'000'000;
inline constexpr std::int64_t kHour = 3600 * kSecond;
/// The time of the first samples.
inline constexpr std::int64_t kStart = 500'000 * kHour;
/// Holds all samples of the tests.
inline const HistoryRange kAll{kStart - 1000 * kHour, kStart + 1000 * kHour};
inline const HistorySeries kLevel{"tank.level", "tank", DataType::int16, true, "m"};

class HistoryInDirectory : public InDirectory {
protected:
    const std::string path_ = directory_ / "plant.history.db";

    /// What a reader returns of one variable, and the damage that it met.
    struct Read {
        std::vector<HistorySample> samples;
        std::vector<HistoryDamage> damage;
    };
    /// Empty without a file, or without the variable.
    [[nodiscard]] Read read(const HistorySeries& wanted = kLevel) const {
        Read read;
        auto reader = HistoryReader::open(path_);
        if (!reader) return read;
        const auto all = reader->series().value();
        for (const auto& info : all) {
            if (info.series.name != wanted.name) continue;
            EXPECT_TRUE(reader->read(info.id, kAll, [&](const HistorySample& sample) {
                read.samples.push_back(sample);
                return true;
            }));
        }
        read.damage = reader->damage();
        return read;
    }
};

}  // namespace takt::store::history_rig
