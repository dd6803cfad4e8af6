// The scan of a line, with devices that answer as a test prescribes, in virtual time.
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <map>

#include "hex.hpp"
#include "takt/bus/line_scan.hpp"
#include "takt/wire/frame.hpp"

namespace takt::bus {
namespace line_scan_test {

using namespace std::chrono_literals;
using ByteVector = std::vector<std::uint8_t>;

ByteVector bytes(std::string_view text) {
    return test::from_hex(text);
}

ByteVector frame(wire::Framing framing, std::uint8_t unit, std::uint16_t transaction, const ByteVector& pdu) {
    const auto made = wire::encode_frame(framing, UnitId{unit}, transaction, pdu);
    return {made.begin(), made.end()};
}

/// An answer, and when its last byte arrives after the request was handed to the line.
struct Reply {
    Duration after{};
    ByteVector bytes;
};
using Replies = std::vector<Reply>;

/// A line whose devices are one function: from a request (unit, PDU, its transaction id) to what comes back.
class Line {
public:
    using Devices = std::function<Replies(std::uint8_t unit, const ByteVector& pdu, std::uint16_t id)>;

    Line(const ScanConfig& config, Devices devices)
        : config_(config), devices_(std::move(devices)), scan_(config) {}

    const LineScan& run() {
        scan_.on_link(now_, true);
        send();
        while (!scan_.finished()) {
            const Instant wakeup = scan_.next_wakeup();
            const Instant next = coming_.empty() ? wakeup : std::min(wakeup, coming_.begin()->first);
            if (next == kNever) {
                ADD_FAILURE() << "it waits for nothing";
                break;
            }
            now_ = std::max(now_, next);
            if (!coming_.empty() && coming_.begin()->first <= now_) {
                const auto arrived = coming_.extract(coming_.begin());
                scan_.on_bytes(now_, arrived.mapped());
            } else {
                scan_.on_tick(now_);
            }
            send();
        }
        return scan_;
    }
    [[nodiscard]] Duration time() const { return now_ - Instant{}; }
    std::map<std::uint8_t, int> asked;  // requests by unit

private:
    void send() {
        for (Bytes out = scan_.transmit(now_); !out.empty(); out = scan_.transmit(now_)) {
            const bool tcp = config_.line.framing == wire::Framing::tcp;
            const std::size_t head = tcp ? 7 : 1;
            const std::uint8_t unit = out[head - 1];
            const auto id = static_cast<std::uint16_t>(tcp ? out[0] << 8U | out[1] : 0);
            const ByteVector pdu(out.begin() + static_cast<std::ptrdiff_t>(head), out.end() - (tcp ? 0 : 2));
            ++asked[unit];
            for (auto& reply : devices_(unit, pdu, id)) coming_.emplace(now_ + reply.after, reply.bytes);
        }
    }

    ScanConfig config_;
    Devices devices_;
    LineScan scan_;
    Instant now_{};
    std::multimap<Instant, ByteVector> coming_;
};

ScanConfig rtu(std::uint8_t first, std::uint8_t last) {
    ScanConfig config;
    config.line.framing = wire::Framing::rtu;
    config.line.format = {.baud = 19200, .data_bits = 8, .parity = wire::Parity::none, .stop_bits = 1};
    for (int unit = first; unit <= last; ++unit)
        config.units.push_back(UnitId{static_cast<std::uint8_t>(unit)});
    return config;
}

const ByteVector kValue = bytes("03 02 12 34");
const ByteVector kNoFunction43 = bytes("AB 01");
const ByteVector kNoFunction17 = bytes("91 01");

ByteVector plain(const ByteVector& pdu) {
    return pdu[0] == 0x03 ? kValue : ByteVector{static_cast<std::uint8_t>(pdu[0] | 0x80), 0x01};
}

Replies one(Duration after, std::uint8_t unit, const ByteVector& pdu) {
    return {{after, frame(wire::Framing::rtu, unit, 0, pdu)}};
}

TEST(LineScan, FindsUnitsThatAnswerAndNoOther) {
    Line line(rtu(1, 247), [](std::uint8_t unit, const ByteVector& pdu, std::uint16_t) -> Replies {
        if (unit != 1 && unit != 17 && unit != 247) return {};
        return one(15ms, unit, plain(pdu));
    });
    const auto& scan = line.run();
    ASSERT_EQ(scan.found().size(), 3U);
    EXPECT_EQ(scan.found()[0].unit, UnitId{1});
    EXPECT_EQ(scan.found()[1].unit, UnitId{17});
    EXPECT_EQ(scan.found()[2].unit, UnitId{247});
    EXPECT_EQ(scan.found()[0].function, 3);
    EXPECT_EQ(scan.found()[0].exception, 0);
    EXPECT_FALSE(scan.found()[0].garbled || scan.found()[0].doubled || scan.found()[0].late);
    EXPECT_TRUE(scan.garbled().empty());
    EXPECT_EQ(scan.end(), ScanEnd::complete);
    EXPECT_EQ(scan.requests(), 244U + 3 * 3) << "one question each, and three to those that are there";
    // 8 characters of a request, the wait, 7 of an answer, the margin.
    EXPECT_LT(line.time(), 244 * 111ms + 1s);
}

TEST(LineScan, AnAnswerBeforeTheEndOfTheQuestionTookNoTime) {
    // A pseudo-terminal has no character times: 8 characters would take 4 ms.
    Line line(rtu(1, 1), [](std::uint8_t unit, const ByteVector& pdu, std::uint16_t) -> Replies {
        return one(1ms, unit, plain(pdu));
    });
    const auto& scan = line.run();
    ASSERT_EQ(scan.found().size(), 1U);
    EXPECT_EQ(scan.found()[0].response_time, 0ms);
}

TEST(LineScan, AnExceptionProvesADeviceToo) {
    Line line(rtu(1, 3), [](std::uint8_t unit, const ByteVector& pdu, std::uint16_t) -> Replies {
        if (unit != 2) return {};
        return one(10ms, unit, {static_cast<std::uint8_t>(pdu[0] | 0x80), 0x02});
    });
    const auto& scan = line.run();
    ASSERT_EQ(scan.found().size(), 1U);
    EXPECT_EQ(scan.found()[0].exception, 2);
}

TEST(LineScan, ReportsTheIdentificationOfADevice) {
    // Two pages of basic objects, one of regular ones.
    const auto device = [](std::uint8_t unit, const ByteVector& pdu, std::uint16_t) -> Replies {
        if (unit != 5) return {};
        if (pdu == bytes("2B 0E 01 00"))
            return one(10ms, unit, bytes("2B 0E 01 82 FF 01 01 00 04 41 63 6D 65"));
        if (pdu == bytes("2B 0E 01 01"))
            return one(10ms, unit, bytes("2B 0E 01 82 00 00 02 01 02 54 31 02 03 31 2E 30"));
        if (pdu == bytes("2B 0E 02 03")) return one(10ms, unit, bytes("2B 0E 02 82 00 00 01 05 01 4D"));
        return one(10ms, unit, plain(pdu));
    };
    Line line(rtu(5, 5), device);
    const auto& scan = line.run();
    ASSERT_EQ(scan.found().size(), 1U);
    const auto& identity = scan.found()[0].identity;
    ASSERT_NE(identity.find(0), nullptr);
    EXPECT_EQ(*identity.find(0), "Acme");
    EXPECT_EQ(*identity.find(1), "T1");
    EXPECT_EQ(*identity.find(2), "1.0");
    EXPECT_EQ(*identity.find(5), "M");
    EXPECT_EQ(identity.find(3), nullptr);
    EXPECT_TRUE(identity.server_id.empty()) << "17 is for those that do not know 43/14";
}

TEST(LineScan, MoreThatFollowsForEverIsLeft) {
    Line line(rtu(5, 5), [](std::uint8_t unit, const ByteVector& pdu, std::uint16_t) -> Replies {
        if (pdu[0] != 0x2B) return one(10ms, unit, plain(pdu));
        const auto object = pdu[3];
        return one(
            10ms, unit,
            {0x2B, 0x0E, pdu[2], 0x82, 0xFF, static_cast<std::uint8_t>(object + 1), 1, object, 1, 'x'});
    });
    const auto& scan = line.run();
    ASSERT_EQ(scan.found().size(), 1U);
    EXPECT_LE(scan.found()[0].identity.objects.size(), 20U);
    EXPECT_LT(scan.requests(), 30U);
}

TEST(LineScan, AsksForTheServerIdWhereThereIsNoDeviceId) {
    Line line(rtu(9, 9), [](std::uint8_t unit, const ByteVector& pdu, std::uint16_t) -> Replies {
        if (pdu[0] == 0x11) return one(10ms, unit, bytes("11 03 4B 43 FF"));
        return one(10ms, unit, plain(pdu));
    });
    const auto& scan = line.run();
    ASSERT_EQ(scan.found().size(), 1U);
    EXPECT_EQ(scan.found()[0].identity.server_id, bytes("4B 43 FF"));
}

TEST(LineScan, ADeviceThatSaysNothingToWhatItDoesNotKnowIsFoundAllTheSame) {
    Line line(rtu(9, 9), [](std::uint8_t unit, const ByteVector& pdu, std::uint16_t) -> Replies {
        return pdu[0] == 0x03 ? one(10ms, unit, kValue) : Replies{};
    });
    EXPECT_EQ(line.run().found().size(), 1U);
}

TEST(LineScan, OneFrameAloneProvesNothing) {
    int frames = 0;
    Line line(rtu(1, 20), [&](std::uint8_t unit, const ByteVector&, std::uint16_t) -> Replies {
        return unit == 7 && ++frames == 1 ? one(10ms, unit, kValue) : Replies{};
    });
    const auto& scan = line.run();
    EXPECT_TRUE(scan.found().empty());
    EXPECT_EQ(frames, 1 + 2 + 3 + 1) << "43/14, 17, the question again; and once more at the end";
}

TEST(LineScan, NoiseIsNoDevice) {
    // A bus without termination reflects the tail of the request, damaged.
    Line line(rtu(1, 30), [](std::uint8_t unit, const ByteVector&, std::uint16_t) -> Replies {
        return unit % 3 == 0 ? Replies{{4ms, {0xFF, 0x00, 0xFE}}} : Replies{};
    });
    const auto& scan = line.run();
    EXPECT_TRUE(scan.found().empty());
    EXPECT_EQ(scan.end(), ScanEnd::complete);
}

TEST(LineScan, TwoDevicesAtOneAddressAreReported) {
    // Their answers overlap: never a frame that checks.
    Line line(rtu(1, 9), [](std::uint8_t unit, const ByteVector&, std::uint16_t) -> Replies {
        return unit == 4 ? Replies{{14ms, bytes("04 03 02 FF B6 11 92")}} : Replies{};
    });
    const auto& scan = line.run();
    EXPECT_TRUE(scan.found().empty());
    EXPECT_EQ(scan.garbled(), (std::vector<GarbledUnit>{{UnitId{4}, {}}}));
}

TEST(LineScan, ResponsesThatAreCutShortAreReported) {
    Line line(rtu(1, 9), [](std::uint8_t unit, const ByteVector&, std::uint16_t) -> Replies {
        return unit == 4 ? Replies{{14ms, bytes("04 03 02 FF B6")}} : Replies{};
    });
    EXPECT_EQ(line.run().garbled(),
              (std::vector<GarbledUnit>{{UnitId{4}, Mismatch{Mismatch::Part::length, 5, 7}}}));
}

TEST(LineScan, ASecondAnswerBehindTheFirstIsReported) {
    Line line(rtu(1, 3), [](std::uint8_t unit, const ByteVector& pdu, std::uint16_t) -> Replies {
        if (unit == 1) return one(12ms, unit, plain(pdu));
        if (unit != 2) return {};
        Replies both = one(12ms, unit, plain(pdu));
        both.push_back(one(30ms, unit, plain(pdu))[0]);
        return both;
    });
    const auto& scan = line.run();
    ASSERT_EQ(scan.found().size(), 2U);
    EXPECT_FALSE(scan.found()[0].doubled);
    EXPECT_TRUE(scan.found()[1].doubled);
}

TEST(LineScan, NoiseOfALineDriverIsNoSecondAnswer) {
    Line line(rtu(1, 9), [](std::uint8_t unit, const ByteVector& pdu, std::uint16_t) -> Replies {
        Replies replies = one(12ms, unit, plain(pdu));
        replies[0].bytes.insert(replies[0].bytes.begin(), 0x00);
        replies.push_back({20ms, {0xFF}});
        return replies;
    });
    const auto& scan = line.run();
    ASSERT_EQ(scan.found().size(), 9U);
    for (const auto& found : scan.found()) EXPECT_FALSE(found.doubled || found.garbled);
}

TEST(LineScan, AnAnswerThatIsLateLosesNoDevice) {
    // 180 ms, where the wait is 100 ms: the answer comes while the next unit is asked.
    Line line(rtu(1, 10), [](std::uint8_t unit, const ByteVector& pdu, std::uint16_t) -> Replies {
        return unit == 4 ? one(180ms, unit, plain(pdu)) : Replies{};
    });
    const auto& scan = line.run();
    ASSERT_EQ(scan.found().size(), 1U);
    EXPECT_EQ(scan.found()[0].unit, UnitId{4});
    EXPECT_TRUE(scan.found()[0].late);
    EXPECT_GE(scan.found()[0].response_time, 170ms);
}

TEST(LineScan, TheLastAnswerMayBeLateToo) {
    Line line(rtu(4, 4), [](std::uint8_t unit, const ByteVector& pdu, std::uint16_t) -> Replies {
        return one(300ms, unit, plain(pdu));
    });
    EXPECT_EQ(line.run().found().size(), 1U);
    Line silent(rtu(4, 4), [](std::uint8_t, const ByteVector&, std::uint16_t) -> Replies { return {}; });
    EXPECT_TRUE(silent.run().found().empty());
    EXPECT_LT(silent.time(), 520ms);
}

TEST(LineScan, ALateAnswerDuringTheNextRequestLosesNoDevice) {
    Line line(rtu(1, 10), [](std::uint8_t unit, const ByteVector& pdu, std::uint16_t) -> Replies {
        if (unit == 5) return {{3ms, {0x04, 0x91, 0x02}}};  // the rest of the answer of 4
        static int asked = 0;
        return unit == 4 && ++asked > 1 ? one(180ms, unit, plain(pdu)) : Replies{};
    });
    const auto& scan = line.run();
    ASSERT_EQ(scan.found().size(), 1U);
    EXPECT_EQ(scan.found()[0].unit, UnitId{4});
}

TEST(LineScan, ALineThatNeverFallsSilentEndsIt) {
    auto config = rtu(1, 247);
    LineScan scan(config);
    Instant t{};
    scan.on_link(t, true);
    const ByteVector noise(4, 0x55);
    for (int i = 0; i < 20'000 && !scan.finished(); ++i) {
        t += 1ms;
        scan.on_bytes(t, noise);
        scan.on_tick(t);
        (void)scan.transmit(t);
    }
    EXPECT_TRUE(scan.finished());
    EXPECT_EQ(scan.end(), ScanEnd::line_busy);
    EXPECT_TRUE(scan.found().empty());
}

TEST(LineScan, OtherMastersDevicesAreStrangers) {
    Line line(rtu(1, 3), [](std::uint8_t, const ByteVector&, std::uint16_t) -> Replies {
        return one(8ms, 77, bytes("04 02 00 01"));
    });
    const auto& scan = line.run();
    EXPECT_TRUE(scan.found().empty());
    EXPECT_GT(scan.foreign_frames(), 0U);
}

TEST(LineScan, ThoroughAsksBeyondHoldingRegisters) {
    const auto only_coils = [](std::uint8_t unit, const ByteVector& pdu, std::uint16_t) -> Replies {
        return unit == 2 && pdu[0] == 0x01 ? one(10ms, unit, bytes("01 01 01")) : Replies{};
    };
    Line quick(rtu(1, 3), only_coils);
    EXPECT_TRUE(quick.run().found().empty());
    auto config = rtu(1, 3);
    config.thorough = true;
    Line thorough(config, only_coils);
    const auto& scan = thorough.run();
    ASSERT_EQ(scan.found().size(), 1U);
    EXPECT_EQ(scan.found()[0].function, 1);
}

ScanConfig tcp(std::uint8_t first, std::uint8_t last) {
    auto config = rtu(first, last);
    config.line = {};
    config.line.framing = wire::Framing::tcp;
    config.line.format.baud = 0;
    return config;
}

TEST(LineScan, AGatewaysExceptionForAnAbsentUnitIsNoDevice) {
    Line line(tcp(1, 5), [](std::uint8_t unit, const ByteVector& pdu, std::uint16_t id) -> Replies {
        const ByteVector none{static_cast<std::uint8_t>(pdu[0] | 0x80), 0x0B};
        return {{200us, frame(wire::Framing::tcp, unit, id, unit == 3 ? plain(pdu) : none)}};
    });
    const auto& scan = line.run();
    ASSERT_EQ(scan.found().size(), 1U);
    EXPECT_EQ(scan.found()[0].unit, UnitId{3});
    EXPECT_TRUE(scan.gateway());
    EXPECT_LT(line.time(), 10ms) << "no time-out was needed";
}

TEST(LineScan, ALostLinkIsAskedOverAgainOnce) {
    auto config = tcp(1, 3);
    LineScan scan(config);
    Instant t{};
    int sent = 0;
    for (int i = 0; i < 50 && !scan.finished(); ++i) {
        scan.on_link(t, true);
        t += 1ms;
        if (!scan.transmit(t).empty()) ++sent;
        scan.on_link(t, false);  // a server that hangs up at every question
    }
    EXPECT_TRUE(scan.finished());
    EXPECT_EQ(sent, 6);
    EXPECT_TRUE(scan.found().empty());
}

/// All units of a host, as takt scan asks them.
ScanConfig adaptive() {
    auto config = tcp(1, 247);
    config.wait = 1s;
    config.retry_wait = 4s;
    config.adaptive = true;
    return config;
}

Replies answer(Duration after, std::uint8_t unit, const ByteVector& pdu, std::uint16_t id) {
    return {{after, frame(wire::Framing::tcp, unit, id, plain(pdu))}};
}

TEST(LineScan, TheWaitFollowsTheResponses) {
    Line line(adaptive(), [](std::uint8_t unit, const ByteVector& pdu, std::uint16_t id) -> Replies {
        if (unit != 1) return {};
        return answer(2ms, unit, pdu, id);
    });
    const auto& scan = line.run();
    ASSERT_EQ(scan.found().size(), 1U);
    EXPECT_LT(line.time(), 20s) << "50 ms and four responses for each unit, and a check; not 246 s";
    EXPECT_EQ(line.asked[1], 3 + 246) << "each short wait is checked by the unit that answers";

    auto fixed = adaptive();
    fixed.adaptive = false;
    Line slow(fixed, [](std::uint8_t unit, const ByteVector& pdu, std::uint16_t id) -> Replies {
        if (unit != 1) return {};
        return answer(2ms, unit, pdu, id);
    });
    EXPECT_EQ(slow.run().found().size(), 1U);
    EXPECT_GT(slow.time(), 246s);
}

TEST(LineScan, AnAdaptedWaitLosesNoSlowUnit) {
    // Unit 9 takes 300 ms, which does not hold up the others.
    Line line(adaptive(), [](std::uint8_t unit, const ByteVector& pdu, std::uint16_t id) -> Replies {
        if (unit == 9) return answer(300ms, unit, pdu, id);
        if (unit != 1) return {};
        return answer(2ms, unit, pdu, id);
    });
    const auto& scan = line.run();
    ASSERT_EQ(scan.found().size(), 2U);
    EXPECT_EQ(scan.found()[1].unit, UnitId{9});
    EXPECT_TRUE(scan.found()[1].late);
    EXPECT_LT(line.time(), 120s) << "the wait grows to what was seen, not for good to the longest";
}

TEST(LineScan, AGatewayThatWaitsForAbsentUnitsLosesNone) {
    // It works on one request at a time and waits 800 ms in silence for a unit that is not there.
    const Line* made = nullptr;
    Duration free{};
    Line line(adaptive(), [&](std::uint8_t unit, const ByteVector& pdu, std::uint16_t id) -> Replies {
        const bool present = unit == 1 || unit == 7 || unit == 120 || unit == 247;
        free = std::max(free, made->time()) + (present ? 10ms : 800ms);
        if (!present) return {};
        return answer(free - made->time(), unit, pdu, id);
    });
    made = &line;
    const auto& scan = line.run();
    std::vector<int> units;
    for (const auto& found : scan.found()) units.push_back(found.unit.value);
    std::ranges::sort(units);
    EXPECT_EQ(units, (std::vector{1, 7, 120, 247}));
}

}  // namespace line_scan_test
}  // namespace takt::bus
