#include "takt/client/background_load.hpp"

#include <cstddef>
#include <cstdint>

namespace takt::client {

BackgroundLoad::BackgroundLoad(unsigned threads) {
    threads_.reserve(threads);
    try {
        for (unsigned i = 0; i < threads; ++i) threads_.emplace_back([this] { work(); });
    } catch (...) {
        end();
        throw;
    }
}

BackgroundLoad::~BackgroundLoad() {
    end();
}

void BackgroundLoad::end() {
    ended_ = true;
    for (auto& thread : threads_) thread.join();
}

void BackgroundLoad::work() const {
    constexpr std::size_t kBytes = std::size_t{16} << 20;
    constexpr std::size_t kCacheLine = 64;
    std::vector<std::uint8_t> memory(kBytes);
    std::uint8_t value = 0;
    while (!ended_) {
        ++value;
        for (std::size_t i = 0; i < kBytes; i += kCacheLine)
            memory[i] = static_cast<std::uint8_t>(memory[i] + value);
    }
}

}  // namespace takt::client
