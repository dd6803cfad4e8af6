#include "takt/firmware/slave_frame.hpp"

#include <algorithm>

#include "takt/base/assert.hpp"
#include "takt/wire/frame.hpp"

namespace takt::firmware {
namespace {

constexpr std::size_t kUnitAndFunction = 2;
constexpr std::size_t kCrc = 2;
constexpr std::size_t kLrc = 1;

// @param request, response  unit and PDU, without checksum
std::size_t respond(serve::Server& server, Bytes request, std::span<std::uint8_t> response) {
    serve::Context context;
    context.unit = UnitId{request[0]};
    context.broadcast = context.unit == kBroadcast;
    if (!context.broadcast && !server.serves(context.unit)) return 0;
    serve::Answer answer;
    server.handle(context, wire::RequestView(request.subspan(1)), answer);
    if (answer.kind != serve::Answer::Kind::response) return 0;
    response[0] = context.unit.value;
    std::ranges::copy(answer.pdu, response.begin() + 1);
    return 1 + answer.pdu.size();
}

bool note(serve::Server& server, bool good) {
    server.on_line_event(good ? serve::LineEvent::message : serve::LineEvent::error);
    return good;
}

}  // namespace

std::size_t respond_rtu(serve::Server& server, Bytes request, std::span<std::uint8_t> response) {
    TAKT_ASSERT(response.size() >= wire::kMaxRtuFrame);
    const bool fits = request.size() >= kUnitAndFunction + kCrc && request.size() <= wire::kMaxRtuFrame;
    if (!note(server, fits && wire::crc16(request) == 0)) return 0;
    const std::size_t size = respond(server, request.first(request.size() - kCrc), response);
    if (size == 0) return 0;
    const std::uint16_t crc = wire::crc16(response.first(size));
    response[size] = static_cast<std::uint8_t>(crc);
    response[size + 1] = static_cast<std::uint8_t>(crc >> 8);
    return size + kCrc;
}

std::size_t respond_ascii(serve::Server& server, Bytes request, std::span<std::uint8_t> response) {
    TAKT_ASSERT(response.size() >= wire::kMaxRtuFrame);
    const bool fits = request.size() >= kUnitAndFunction + kLrc && request.size() <= 1 + wire::kMaxPdu + kLrc;
    if (!note(server, fits && wire::lrc(request) == 0)) return 0;
    const std::size_t size = respond(server, request.first(request.size() - kLrc), response);
    if (size == 0) return 0;
    response[size] = wire::lrc(response.first(size));
    return size + kLrc;
}

}  // namespace takt::firmware
