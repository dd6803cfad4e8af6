#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "generators.hpp"
#include "listener.hpp"

namespace takt::wire {
namespace framer_property_test {

using namespace std::chrono_literals;

constexpr Duration kSilence = 1750us;

struct Sent {
    FrameBytes bytes;
    std::string reports;
};

// One in 65536 beginnings has a good CRC of its own by chance; the properties are about all others.
bool has_good_beginning(const FrameBytes& frame) {
    for (std::size_t size = 4; size < frame.size(); ++size)
        if (crc16(frame.span().first(size)) == 0) return true;
    return false;
}

Sent send(Framing framing, UnitId unit, const Pdu& pdu) {
    const std::uint8_t address[] = {unit.value};
    Sent sent{encode_frame(framing, unit, any_u16(), pdu.span()),
              to_hex(address) + ": " + to_hex(pdu.span())};
    RC_PRE(framing != Framing::rtu || !has_good_beginning(sent.bytes));
    return sent;
}

Sent any_frame(Framing framing, Side side) {
    const Request request = any_request();
    const bool is_response = side == Side::master || any_bool();
    const Pdu pdu = is_response ? *encode(any_answer(request)) : *encode(request);
    return send(framing, UnitId{any_u8()}, pdu);
}

// All of `bytes` in random pieces, `gap` apart.
Instant feed(Listener& listener, Instant t, Bytes bytes, Duration gap) {
    while (!bytes.empty()) {
        const std::size_t size = any_of(1, std::min<std::size_t>(bytes.size(), any_bool() ? 3 : 400));
        listener.bytes(t += gap, bytes.first(size));
        bytes = bytes.subspan(size);
    }
    return t;
}

RC_GTEST_PROP(FramerProperty, RtuFramesBetweenSilencesAreFoundInAnyPieces, ()) {
    const Side side = any_bool() ? Side::master : Side::slave;
    Listener listener({.framing = Framing::rtu, .side = side, .silence = kSilence});
    Reports expected;
    Instant t{};
    for (int i = 0; i < 10; ++i) {
        const Sent sent = any_frame(Framing::rtu, side);
        expected.push_back(sent.reports);
        t = feed(listener, t + kSilence, sent.bytes.span(), kSilence - 1ns);
        if (any_bool()) listener.tick(t + kSilence);
    }
    listener.tick(t + kSilence);
    RC_ASSERT(listener.reports() == expected);
}

RC_GTEST_PROP(FramerProperty, AsciiAndTcpFramesAreFoundInAnyPieces, ()) {
    for (const Framing framing : {Framing::ascii, Framing::tcp}) {
        Listener listener({.framing = framing});
        Reports expected;
        ByteVector stream;
        for (int i = 0; i < 5; ++i) {
            const Sent sent = any_frame(framing, Side::slave);
            expected.push_back(sent.reports);
            stream.insert(stream.end(), sent.bytes.begin(), sent.bytes.end());
        }
        feed(listener, Instant{}, stream, 1ms);
        RC_ASSERT(listener.reports() == expected);
    }
}

// Functions whose frames have their length in their first bytes.
bool length_is_in_first_bytes(const Request& request) {
    if (std::holds_alternative<EncapsulatedRequest>(request)) return false;
    const auto* diagnostics = std::get_if<DiagnosticsRequest>(&request);
    return diagnostics == nullptr || diagnostics->data.size() == 2;
}

// Exchanges of other units and no visible silence: each frame is found, so the next own request will be too.
RC_GTEST_PROP(FramerProperty, ASlaveFollowsOtherUnitsWithoutSilences, ()) {
    Listener listener({.framing = Framing::rtu, .side = Side::slave, .silence = kSilence});
    listener.own_units_up_to(10);
    Reports expected;
    ByteVector stream;
    for (int i = 0; i < 5; ++i) {
        const Request request = any_request();
        RC_PRE(length_is_in_first_bytes(request));
        const UnitId unit{static_cast<std::uint8_t>(any_of(11, 247))};
        for (const auto& pdu : {encode(request), encode(any_answer(request))}) {
            const Sent sent = send(Framing::rtu, unit, *pdu);
            expected.push_back(sent.reports);
            stream.insert(stream.end(), sent.bytes.begin(), sent.bytes.end());
        }
    }
    feed(listener, Instant{}, stream, 1us);
    RC_ASSERT(listener.reports() == expected);
}

RC_GTEST_PROP(FramerProperty, RtuOverAStreamNeedsNoSilences, ()) {
    Listener listener({.framing = Framing::rtu, .side = Side::master, .silence = 50ms}, true);
    Reports expected;
    ByteVector stream;
    for (int i = 0; i < 5; ++i) {
        const Request request = any_request();
        RC_PRE(length_is_in_first_bytes(request));
        const Sent sent = send(Framing::rtu, UnitId{any_u8()}, *encode(any_answer(request)));
        expected.push_back(sent.reports);
        stream.insert(stream.end(), sent.bytes.begin(), sent.bytes.end());
    }
    feed(listener, Instant{}, stream, 1ms);
    RC_ASSERT(listener.reports() == expected);
}

ByteVector garbage() {
    ByteVector bytes(any_of(0, 600));
    // pieces of frames and the characters of ASCII are worse than plain noise
    const std::uint8_t tempting[] = {0x00, 0x01, 0x03, 0x10, 0x17, 0x2B, 0xFF, ':', '\r', '\n', '0', 'F'};
    for (auto& byte : bytes) byte = any_bool() ? any_u8() : tempting[any_of(0, std::size(tempting) - 1)];
    return bytes;
}

RC_GTEST_PROP(FramerProperty, AfterAnyGarbageTheNextFrameIsFound, ()) {
    for (const Framing framing : {Framing::rtu, Framing::ascii}) {
        for (const Side side : {Side::master, Side::slave}) {
            Listener listener({.framing = framing, .side = side, .silence = kSilence, .strict_pause = 750us});
            Instant t = feed(listener, Instant{}, garbage(), any_bool() ? 10us : 1ms);
            t += 2s;
            if (any_bool()) listener.tick(t - 1s);
            const Sent sent = any_frame(framing, side);
            t = feed(listener, t, sent.bytes.span(), 1us);
            listener.tick(t + kSilence);
            const Reports reports = listener.reports();
            RC_ASSERT(!reports.empty());
            RC_ASSERT(reports.back() == sent.reports);
        }
    }
}

// Noise of a line driver, arbitrary or like the beginning of the response.
ByteVector noise_like(const FrameBytes& response) {
    ByteVector noise(any_of(0, 12));
    for (auto& byte : noise) byte = any_bool() ? any_u8() : any_bool() ? 0x00 : 0xFF;
    if (any_bool()) noise.insert(noise.end(), response.begin(), response.begin() + any_of(0, 3));
    return noise;
}

RC_GTEST_PROP(FramerProperty, AMasterFindsItsResponseInNoise, ()) {
    const Request request = any_request();
    RC_PRE(length_is_in_first_bytes(request));
    const UnitId unit{static_cast<std::uint8_t>(any_of(1, 247))};
    const Pdu answer = *encode(any_answer(request));
    const Sent sent = send(Framing::rtu, unit, answer);
    const bool fixed = any_bool();
    Listener listener({.framing = Framing::rtu, .side = Side::master, .silence = 30ms}, true);
    listener.framer().expect_response({.unit = unit,
                                       .function = requested_function(answer.span()[0]),
                                       .length = fixed ? sent.bytes.size() : 0});
    const ByteVector before = any_bool() ? noise_like(sent.bytes) : ByteVector{};
    const ByteVector after = any_bool() ? noise_like(sent.bytes) : ByteVector{};
    ByteVector stream = before;
    stream.insert(stream.end(), sent.bytes.begin(), sent.bytes.end());
    stream.insert(stream.end(), after.begin(), after.end());
    const Instant end = feed(listener, Instant{} + 1s, stream, any_bool() ? 1us : 8ms);
    listener.tick(end + 30ms);
    const Reports reports = listener.reports();
    RC_ASSERT(std::ranges::count(reports, sent.reports) == 1);
    // FF FF 00 00 is a frame of a unit 255: noise alone may be one, but never a response of the unit.
    const std::string own = sent.reports.substr(0, sent.reports.find(' '));
    RC_ASSERT(std::ranges::count_if(reports, [&](const auto& report) { return report.starts_with(own); }) ==
              1);
}

// From random bytes that are no frame, the framer takes no frame except the expected response.
RC_GTEST_PROP(FramerProperty, AMasterFindsNothingElseInGarbage, ()) {
    const Request request = any_request();
    RC_PRE(length_is_in_first_bytes(request));
    const Sent sent = send(Framing::rtu, UnitId{1}, *encode(any_answer(request)));
    Listener listener({.framing = Framing::rtu, .side = Side::master, .silence = 30ms}, true);
    const bool other_unit = any_bool();
    const std::size_t length = sent.bytes.size() + (other_unit ? 0 : 1);
    listener.framer().expect_response({.unit = UnitId{static_cast<std::uint8_t>(other_unit ? 2 : 1)},
                                       .function = sent.bytes[1],
                                       .length = length});
    ByteVector stream{0xFF};
    stream.insert(stream.end(), sent.bytes.begin(), sent.bytes.end());
    const Instant end = feed(listener, Instant{} + 1s, stream, 1us);
    listener.tick(end + 30ms);
    for (const auto& report : listener.reports()) RC_ASSERT(report[0] == '!');
}

RC_GTEST_PROP(FramerProperty, TcpGarbageIsEitherFramesOrTheEnd, ()) {
    Listener listener({.framing = Framing::tcp});
    const ByteVector bytes = garbage();
    feed(listener, Instant{}, bytes, 1ms);
    const Reports reports = listener.reports();
    for (std::size_t i = 0; i + 1 < reports.size(); ++i)
        RC_ASSERT(reports[i][0] != '!' ||
                  reports[i] == reports.back());  // after the first bad header nothing but that
}

}  // namespace framer_property_test
}  // namespace takt::wire
