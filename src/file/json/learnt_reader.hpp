// Reads the file of learnt results (format: takt/file/learnt.hpp).
#pragma once

#include <array>
#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "takt/file/json.hpp"
#include "takt/model/device.hpp"

namespace takt::file {

using Seconds = std::chrono::sys_seconds;

inline constexpr std::int64_t kLearntVersion = 2;
inline constexpr std::int64_t kOldestLearntVersion = 1;
/// A longer time is not kept.
inline constexpr std::chrono::hours kLongestLearntTime{1};
inline constexpr std::array kLearntAreas{wire::Area::coil, wire::Area::discrete_input,
                                         wire::Area::input_register, wire::Area::holding_register};

/// Reads the tree. The first invalid element ends it and is reported with its path.
class LearntReader {
public:
    explicit LearntReader(Seconds now) : now_(now) {}

    struct Known {
        std::string line;
        std::string device;
        std::uint8_t address = 0;
        model::Learnt learnt;
        model::LearntTimes times;
    };
    [[nodiscard]] bool read(const Json& root);
    [[nodiscard]] std::vector<Known> take() { return std::move(known_); }
    [[nodiscard]] const std::vector<std::string>& lines_with_lengths_off() const { return lengths_off_; }
    [[nodiscard]] const std::string& fault() const { return fault_; }

private:
    bool read_lengths_off(const Json& json, const std::string& line, const std::string& path);
    bool read_device(const Json& json, const std::string& line, const std::string& path);
    bool read_area(const Json& json, const std::string& path, model::Learnt& learnt);
    bool read_times(const Json& json, const std::string& path, model::LearntTimes& times);
    bool read_next_latest(const Json& json, const std::string& path, model::MeasuredTimes& measured);
    bool read_counts(const Json& json, const std::string& path, model::LearntTimes& times);
    bool read_duration(const Json& json, const std::string& path, const char* key, Duration& time);
    bool read_number(const Json& json, const std::string& path, const char* key, std::uint64_t& number);
    bool read_refused(const Json& json, const std::string& path, std::vector<model::RefusedItems>& refused);
    bool read_time(const Json& json, const std::string& path, const char* key, Duration& age);
    std::optional<model::ItemRange> range(const Json* json, const std::string& path);
    const Json::Array* list(const Json& json, const std::string& path, const char* key);
    const std::string* text(const Json& json, const std::string& path, const char* key);
    std::optional<std::int64_t> number(const Json* json, const std::string& path, std::int64_t least,
                                       std::int64_t most);
    bool bad(const std::string& path) {
        fault_ = path;
        return false;
    }

    Seconds now_;
    std::vector<Known> known_;
    std::vector<std::string> lengths_off_;  // names of lines
    std::string fault_;
};

}  // namespace takt::file
