// Misbehaving clients that run while a good one is measured.
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <thread>
#include <vector>

namespace bench {

/// The behaviour of each of some clients. A client that is disconnected connects again.
struct Attack {
    std::string_view name;
    std::size_t clients = 1;
    std::vector<std::uint8_t> bytes;    ///< sent again and again
    std::size_t at_once = 0;            ///< bytes of it at a time; 0: all
    std::chrono::microseconds every{};  ///< from one piece to the next; zero: once a connection
    bool reads = true;                  ///< it takes its answers
};

/// The bad clients that are measured: of docs/hostile-inputs.md, cases 6, 8, 9, 13, 15, 16, 17 and 27.
std::span<const Attack> attacks();

/// The attack at work on a thread of its own, as long as this lives.
class Attackers {
public:
    Attackers(const Attack& attack, std::uint16_t port);
    ~Attackers();
    Attackers(const Attackers&) = delete;
    Attackers& operator=(const Attackers&) = delete;

private:
    std::atomic<bool> stop_ = false;
    std::thread thread_;
};

}  // namespace bench
