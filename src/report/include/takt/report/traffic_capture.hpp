// The frames of a host as a packet capture.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <utility>

#include "takt/capture/frame_capture.hpp"
#include "takt/host/traffic.hpp"
#include "takt/model/line.hpp"

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

    /// @param wall_ns  the time of the record, since 1970
    /// @param out      receives the blocks
    void add(const host::TrafficRecord& record, std::int64_t wall_ns, std::string& out);

    /// For the begin and the end of files, and for lost frames.
    [[nodiscard]] capture::FrameCapture& frames() { return frames_; }

private:
    struct Source {
        std::size_t number = 0;
        std::string name;
        wire::Framing framing{};
        std::string address;                            // of the server; empty: unknown
        std::map<std::uint8_t, std::string> devices{};  // by address
    };
    using Key = std::tuple<std::uint32_t, host::TrafficSource::Kind, std::size_t>;  // with the generation

    const Source* source_of(const host::TrafficRecord& record);

    LineOf line_of_;
    bool overheard_;
    std::map<Key, Source> sources_;
    std::map<std::pair<host::TrafficSource::Kind, std::string>, std::size_t> numbers_;  // by name
    capture::FrameCapture frames_;
};

}  // namespace takt::report
