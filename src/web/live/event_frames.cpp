#include "live/event_frames.hpp"

#include <utility>

namespace takt::web {
namespace {

constexpr std::size_t kReadAtOnce = std::size_t{64} << 10;

std::size_t size_of(const FrameTexts& texts) {
    std::size_t size = 0;
    const std::string* before = nullptr;
    for (const auto& text : texts) {
        if (text && text.get() != before) size += text->size();
        before = text.get();
    }
    return size;
}

}  // namespace

void EventFrames::push(FrameTexts texts, std::size_t items) {
    bytes_ += size_of(texts);
    frames_.push_back({std::move(texts), items});
    ++end_.frame;
    end_.items += items;
    while (frames_.size() > 1 && (frames_.size() > most_frames_ || bytes_ > most_bytes_)) {
        bytes_ -= size_of(frames_.front().texts);
        ++begin_.frame;
        begin_.items += frames_.front().items;
        frames_.pop_front();
    }
}

void EventFrames::push(std::string text, std::size_t items) {
    FrameTexts texts;
    texts.fill(std::make_shared<const std::string>(std::move(text)));
    push(std::move(texts), items);
}

void EventFrames::clear() {
    begin_ = end_;
    frames_.clear();
    bytes_ = 0;
}

bool EventFrames::read(Cursor& cursor, text::Language language, std::string& out) const {
    if (cursor.frame < begin_.frame) return false;
    const auto before = out.size();
    while (cursor.frame < end_.frame && out.size() - before < kReadAtOnce) {
        const auto& frame = frames_[cursor.frame - begin_.frame];
        if (const auto& text = frame.texts[static_cast<std::size_t>(language)]) out += *text;
        ++cursor.frame;
        cursor.items += frame.items;
    }
    return true;
}

}  // namespace takt::web
