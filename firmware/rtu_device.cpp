#include "takt/firmware/rtu_device.hpp"

#include <algorithm>

#include "takt/base/assert.hpp"
#include "takt/wire/frame.hpp"

namespace takt::firmware {
namespace {

constexpr std::size_t kLeastFrame = 4;
constexpr std::size_t kCrc = 2;

bool good(Bytes frame) {
    return frame.size() >= kLeastFrame && frame.size() <= wire::kMaxRtuFrame && wire::crc16(frame) == 0;
}

}  // namespace

std::size_t process(serve::Server& server, Bytes request, std::span<std::uint8_t> response) {
    TAKT_ASSERT(response.size() >= wire::kMaxRtuFrame);
    server.on_line_event(good(request) ? serve::LineEvent::message : serve::LineEvent::error);
    if (!good(request)) return 0;
    serve::Context context;
    context.unit = UnitId{request[0]};
    context.broadcast = context.unit == kBroadcast;
    if (!context.broadcast && !server.serves(context.unit)) return 0;
    serve::Answer answer;
    server.handle(context, wire::RequestView(request.subspan(1, request.size() - 1 - kCrc)), answer);
    if (answer.kind != serve::Answer::Kind::response) return 0;
    response[0] = context.unit.value;
    std::ranges::copy(answer.pdu, response.begin() + 1);
    const std::size_t size = 1 + answer.pdu.size();
    const std::uint16_t crc = wire::crc16(response.first(size));
    response[size] = static_cast<std::uint8_t>(crc);
    response[size + 1] = static_cast<std::uint8_t>(crc >> 8);
    return size + kCrc;
}

}  // namespace takt::firmware
