// IP datagrams from their fragments (RFC 791, RFC 8200 section 4.5).
#pragma once

#include <cstddef>
#include <cstdint>
#include <list>
#include <optional>
#include <utility>
#include <vector>

#include "takt/capture/segment.hpp"

namespace takt::capture {

/// Collects fragments that come in any order, also twice. Of bytes that come twice the first ones are kept.
///
/// Bounded: at most kMost incomplete datagrams; the oldest is given up for another one, and after kTimeout.
/// Allocates. One owner, one thread.
class FragmentTable {
public:
    static constexpr std::size_t kMost = 64;
    static constexpr Duration kTimeout = std::chrono::seconds(30);

    /// @returns the payload of the datagram that this fragment completes; valid until the next call
    [[nodiscard]] std::optional<Bytes> add(const Fragment& fragment, std::int64_t time_ns);
    /// Nothing more comes.
    void end();

    /// Fragments of datagrams that were given up.
    [[nodiscard]] std::uint64_t lost() const { return lost_; }

private:
    struct Datagram {
        IpAddress source;
        IpAddress destination;
        std::uint32_t identification = 0;
        std::uint8_t protocol = 0;
        std::int64_t begun_ns = 0;
        std::uint64_t fragments = 0;
        std::optional<std::uint32_t> length{};
        std::vector<std::uint8_t> bytes{};
        std::vector<std::pair<std::uint32_t, std::uint32_t>> holes{{0, 0xFFFFFFFF}};  // begin, end
    };

    [[nodiscard]] Datagram& find(const Fragment& fragment, std::int64_t time_ns);
    static void fill(Datagram& datagram, const Fragment& fragment);
    void give_up_oldest();

    std::list<Datagram> datagrams_;  // the oldest first
    std::vector<std::uint8_t> complete_;
    std::uint64_t lost_ = 0;
};

}  // namespace takt::capture
