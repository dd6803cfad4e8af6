// A bounded ring of events for any number of streams, each with its own cursor.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <string>

#include "takt/base/time.hpp"
#include "takt/text/language.hpp"

namespace takt::web {

/// Of a stream without events: then a comment is sent, so that a lost connection is noticed.
inline constexpr Duration kKeepAliveInterval = std::chrono::seconds(10);

using SharedText = std::shared_ptr<const std::string>;

/// An event in each language; nullptr: nothing in that language.
using FrameTexts = std::array<SharedText, text::kLanguages.size()>;

/// The owner guards it.
class EventFrames {
public:
    EventFrames(std::size_t most_frames, std::size_t most_bytes)
        : most_frames_(most_frames), most_bytes_(most_bytes) {}

    /// The position of a reader.
    struct Cursor {
        std::uint64_t frame = 0;
        std::uint64_t items = 0;  ///< that were in all frames before
    };

    /// Drops the oldest frames beyond the limits; the new one stays.
    /// @param items  how many things the frame reports; counted in cursors
    void push(FrameTexts texts, std::size_t items = 0);
    /// The same in all languages.
    void push(std::string text, std::size_t items = 0);
    void clear();

    [[nodiscard]] const Cursor& begin() const { return begin_; }
    [[nodiscard]] const Cursor& end() const { return end_; }

    /// Appends frames from the cursor on, about 64 KiB at most, and advances it.
    /// @returns false, and appends nothing: frames that the cursor needs were dropped
    [[nodiscard]] bool read(Cursor& cursor, text::Language language, std::string& out) const;

private:
    struct Frame {
        FrameTexts texts;
        std::size_t items = 0;
    };

    std::size_t most_frames_;
    std::size_t most_bytes_;
    std::deque<Frame> frames_;
    Cursor begin_;
    Cursor end_;
    std::size_t bytes_ = 0;
};

}  // namespace takt::web
