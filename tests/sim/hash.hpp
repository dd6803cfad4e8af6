// A fingerprint of a run: all bytes, times and values.
#pragma once

#include <bit>
#include <cstdint>
#include <span>
#include <string>

#include "takt/base/time.hpp"
#include "takt/value/value.hpp"

namespace takt::simtest {

class Hash {
public:
    void add(std::uint64_t number) {
        state_ = (state_ ^ number) * 0x9E3779B97F4A7C15;
        state_ ^= state_ >> 29U;
    }
    void add(Instant t) { add(static_cast<std::uint64_t>(t.time_since_epoch().count())); }
    void add(std::span<const std::uint8_t> bytes) {
        std::uint64_t word = bytes.size();
        for (std::size_t i = 0; i < bytes.size(); ++i) {
            word = word << 8U | bytes[i];
            if (i % 8 == 7) add(std::exchange(word, 0));
        }
        add(word);
    }
    void add(const value::Value& value) {
        add(value.index());
        if (const auto* b = std::get_if<bool>(&value)) add(std::uint64_t{*b});
        if (const auto* i = std::get_if<std::int64_t>(&value)) add(static_cast<std::uint64_t>(*i));
        if (const auto* u = std::get_if<std::uint64_t>(&value)) add(*u);
        if (const auto* d = std::get_if<double>(&value)) add(std::bit_cast<std::uint64_t>(*d));
        if (const auto* s = std::get_if<std::string>(&value))
            add({reinterpret_cast<const std::uint8_t*>(s->data()), s->size()});
    }
    [[nodiscard]] std::uint64_t value() const { return state_; }

private:
    std::uint64_t state_ = 0xCBF29CE484222325;
};

}  // namespace takt::simtest
