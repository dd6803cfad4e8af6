// The frames of a traffic tap with what a reader needs to know of them.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "live/wall_time.hpp"
#include "takt/file/json.hpp"
#include "takt/host/session.hpp"
#include "takt/report/drawing/texts.hpp"
#include "takt/wire/frame_words.hpp"
#include "takt/wire/pdu.hpp"

namespace takt::web {

struct TrafficFrame {
    host::TrafficRecord record;
    std::string line;
    std::string device;  ///< empty: a unit that is no device of the line
    bool ascii = false;
    bool mbap = false;  ///< its raw bytes begin with a transaction identifier
    bool request = false;
    std::string words;  ///< of a frame, in English

    [[nodiscard]] file::Json json(const WallTime& clock, const report::Texts& texts) const;
};

/// Reads a session with a tap. A response is described with the request before it. One thread.
class TrafficReader {
public:
    explicit TrafficReader(std::unique_ptr<host::Session> session) : session_(std::move(session)) {}

    /// The next frame; nothing: there is none now.
    [[nodiscard]] std::optional<TrafficFrame> next();
    [[nodiscard]] std::uint64_t missed() const { return session_->missed_traffic(); }

private:
    struct Source {
        std::string line;
        std::map<std::uint8_t, std::string> devices;  // by address
        wire::Framing framing{};
        wire::FrameWords words;
    };
    using Key = std::tuple<std::uint32_t, host::TrafficSource::Kind, std::size_t>;

    Source* source_of(const host::TrafficRecord& record);

    std::unique_ptr<host::Session> session_;
    std::map<Key, Source> sources_;
};

}  // namespace takt::web
