// What the tests of writing on a bench share.
#pragma once

#include <cstdint>
#include <vector>

#include "bench.hpp"

namespace takt::poll::test {

/// The writes among the requests sent since the last call.
inline std::vector<Sent> writes(Bench& bench) {
    auto news = bench.news();
    std::erase_if(news, [](const Sent& request) { return request.function < 5; });
    return news;
}

inline value::Value number(std::int64_t value) {
    return value;
}

inline model::Device pair_on_change() {
    return device(
        1, {int16("a", 0).read(3).write(0x10).on_change(), int16("b", 1).read(3).write(0x10).on_change()});
}

}  // namespace takt::poll::test
