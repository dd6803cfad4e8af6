// The frames of a host as a packet capture.
#pragma once

#include <bitset>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <utility>

#include "takt/capture/frame_capture.hpp"
#include "takt/capture/serial_pairing.hpp"
#include "takt/host/traffic.hpp"
#include "takt/model/line.hpp"
#include "takt/wire/line_timing.hpp"

namespace takt::report {

/// Adds records of a traffic tap to a capture::FrameCapture, with the names, addresses and framings of their
/// lines. One owner, one thread.
class TrafficCapture {
public:
    /// As host::Session::line_of().
    using LineOf = std::function<std::optional<model::Line>(const host::TrafficRecord&)>;

    /// @param overheard  this program did not send or receive the frames: they have no direction
    explicit TrafficCapture(LineOf line_of, bool overheard = false)
        : line_of_(std::move(line_of)), overheard_(overheard) {}

    /// When the last character of a frame was complete. A record has this time if it was received. If it was
    /// sent it has the time of its first character, and the others follow at the bit rate of the line.
    [[nodiscard]] Instant end_of(const host::TrafficRecord& record);

    /// @param wall_ns  the time of the frame, since 1970
    /// @param out      receives the blocks
    void add(const host::TrafficRecord& record, std::int64_t wall_ns, std::string& out);

    /// For the begin and the end of files, and for lost frames.
    [[nodiscard]] capture::FrameCapture& frames() { return frames_; }

private:
    struct Source {
        std::size_t number = 0;
        std::string name;
        wire::Framing framing{};
        wire::CharacterFormat format{.baud = 0};        // of a line with character times; baud 0: none
        std::string address;                            // of the server; empty: unknown
        std::map<std::uint8_t, std::string> devices{};  // by address
        // A server's serial line, where other slaves answer too; else none.
        std::shared_ptr<capture::SerialPairing> pairing;
        std::bitset<256> own;  // units that this program answered for
    };
    using Key = std::tuple<std::uint32_t, host::TrafficSource::Kind, std::size_t>;  // with the generation

    Source* source_of(const host::TrafficRecord& record);
    [[nodiscard]] static bool is_request(Source& source, const host::TrafficRecord& record);

    LineOf line_of_;
    bool overheard_;
    std::map<Key, Source> sources_;
    std::map<std::pair<host::TrafficSource::Kind, std::string>, std::size_t> numbers_;  // by name
    capture::FrameCapture frames_;
};

}  // namespace takt::report
