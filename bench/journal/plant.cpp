#include "plant.hpp"

#include <fmt/format.h>

namespace takt::bench {

std::string_view name(Kind kind) {
    switch (kind) {
        case Kind::floating: return "float";
        case Kind::integer: return "int16";
        case Kind::boolean: return "bool";
    }
    return "";
}

Plant::Plant(std::size_t variables, Kind kind) : kind_(kind), read_ns_(variables) {
    constexpr DataType kTypes[] = {DataType::float32, DataType::int16, DataType::boolean};
    for (std::size_t i = 0; i < variables; ++i)
        series_.push_back({.variable = fmt::format("Power-{}", i % 10),
                           .device = fmt::format("Meter-{:03}", i / 10),
                           .line = fmt::format("line-{}", i / 100),
                           .unit = "kW",
                           .type = kTypes[static_cast<std::size_t>(kind)]});
}

// xorshift64 (G. Marsaglia, 2003): the numbers must not cost more than the samples.
value::Value Plant::next_value() {
    random_ ^= random_ << 13U;
    random_ ^= random_ >> 7U;
    random_ ^= random_ << 17U;
    switch (kind_) {
        case Kind::floating: return static_cast<double>(230.0F + static_cast<float>(random_ >> 40U) / 1e6F);
        case Kind::integer: return static_cast<std::int64_t>(random_ >> 52U);
        case Kind::boolean: return (random_ >> 63U) != 0;
    }
    return {};
}

void Plant::collect(std::size_t count, std::int64_t from_ns, std::int64_t to_ns, const Sink& sink) {
    const std::int64_t step = (to_ns - from_ns) / static_cast<std::int64_t>(count);
    publish::Sample sample;
    for (std::size_t i = 0; i < count; ++i) {
        sample.series = static_cast<std::uint32_t>(next_);
        sample.value = next_value();
        sample.wall_ns = from_ns + static_cast<std::int64_t>(i) * step;
        std::int64_t& read_ns = read_ns_[next_];
        sample.previous_wall_ns.reset();
        if (read_ns != 0) sample.previous_wall_ns = read_ns;
        read_ns = sample.wall_ns;
        if (!payload_.add(series_[next_], sample)) {
            finish_payload(sink);
            (void)payload_.add(series_[next_], sample);
        }
        next_ = (next_ + 1) % series_.size();
    }
    finish_payload(sink);
}

void Plant::finish_payload(const Sink& sink) {
    const std::size_t samples = payload_.samples();
    sink(payload_.take(), samples);
}

}  // namespace takt::bench
