#include "codec.hpp"

namespace takt::wire::codec {

std::uint8_t Reader::u8() {
    ++needed_;
    return needed_ <= bytes_.size() ? bytes_[needed_ - 1] : 0;
}

std::uint16_t Reader::u16() {
    const unsigned high = u8();
    return static_cast<std::uint16_t>(high << 8 | u8());
}

Bytes Reader::take(std::size_t count) {
    const std::size_t first = needed_;
    needed_ += count;
    return needed_ <= bytes_.size() ? bytes_.subspan(first, count) : Bytes{};
}

Result<void> Reader::check() const {
    if (needed_ > bytes_.size())
        return fail(Code::too_short, static_cast<std::int64_t>(bytes_.size()),
                    static_cast<std::int64_t>(needed_));
    return {};
}

Result<void> Reader::finish() const {
    if (needed_ < bytes_.size())
        return fail(Code::too_long, static_cast<std::int64_t>(bytes_.size()),
                    static_cast<std::int64_t>(needed_));
    return check();
}

Writer& Writer::u8(std::size_t value) {
    pdu_.push_back(static_cast<std::uint8_t>(value));
    return *this;
}

Writer& Writer::u16(std::size_t value) {
    return u8(value >> 8).u8(value);
}

Writer& Writer::bytes(Bytes values) {
    pdu_.append(values);
    return *this;
}

Writer& Writer::registers(std::span<const std::uint16_t> values) {
    for (const std::uint16_t value : values) u16(value);
    return *this;
}

Result<void> check_range(std::size_t value, std::size_t least, std::size_t greatest) {
    if (value >= least && value <= greatest) return {};
    return fail(Code::out_of_range, static_cast<std::int64_t>(value), static_cast<std::int64_t>(least),
                static_cast<std::int64_t>(greatest));
}

Result<void> check_count(std::size_t count, std::size_t expected) {
    if (count == expected) return {};
    return fail(Code::malformed, static_cast<std::int64_t>(count), static_cast<std::int64_t>(expected));
}

}  // namespace takt::wire::codec
