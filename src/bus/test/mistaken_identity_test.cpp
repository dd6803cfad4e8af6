// The guarantee behind late responses: with any delays of a device, no request is given another one's
// data.
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <map>

#include "rig.hpp"

namespace takt::bus {
namespace mistaken_identity_test {

using namespace test;

constexpr Duration kWait = 20ms;

/// The response of the device: each register holds its own address; from 0x100 on there are none.
std::vector<std::uint8_t> answer_of(const std::vector<std::uint8_t>& request) {
    const auto quantity = request[5];
    wire::Pdu pdu;
    if (request[2] != 0) {
        pdu = {static_cast<std::uint8_t>(request[1] | 0x80U), 2};
    } else {
        pdu = {request[1], static_cast<std::uint8_t>(2 * quantity)};
        for (std::uint8_t i = 0; i < quantity; ++i) {
            pdu.push_back(0);
            pdu.push_back(static_cast<std::uint8_t>(request[3] + i));
        }
    }
    const auto frame = wire::encode_frame(wire::Framing::rtu, UnitId{request[0]}, 0, pdu.span());
    return {frame.begin(), frame.end()};
}

/// Asks one request after the other; each answer is complete `delay` after its request, and at the latest
/// when the late limit allows. In order: not before the answers to earlier requests.
struct SlowLine {
    bool in_order = true;
    Instant last = Instant::min();
    Rig rig;
    std::multimap<Instant, std::vector<std::uint8_t>> coming;
    std::size_t answered = 0;

    void run_until(Instant end) {
        while (!coming.empty() && coming.begin()->first <= end) {
            rig.run_until(std::max(rig.now, coming.begin()->first));
            rig.receive(rig.now, coming.begin()->second);
            coming.erase(coming.begin());
        }
        rig.run_until(end);
    }

    void ask(const Transaction& asked, int delay_percent) {
        const auto sent_before = rig.sent.size();
        const auto ended_before = rig.outcomes.size();
        rig.submit(rig.now, asked);
        while (rig.sent.size() == sent_before) run_until(rig.now + 1ms);
        const auto& request = rig.sent.back();
        const auto answer = answer_of(request);
        const Duration latest =
            2 * kWait + wire::transmission_time(kLine.format, answer.size()) + kLine.margin;
        Instant complete = rig.sent_at.back() + kRequest + latest * delay_percent / 100 - 1ns;
        if (in_order) complete = last = std::max(last, complete);
        coming.emplace(complete, answer);
        while (rig.outcomes.size() == ended_before) run_until(rig.now + 1ms);
    }
};

RC_GTEST_PROP(TransactionEngine, NeverGivesARequestTheDataOfAnother, ()) {
    SlowLine line;
    line.in_order = *rc::gen::arbitrary<bool>();
    const auto count = *rc::gen::inRange(10, 60);
    for (int i = 0; i < count; ++i) {
        const auto unit = *rc::gen::element<std::uint8_t>(1, 1, 2);
        const auto function = *rc::gen::element<std::uint8_t>(3, 3, 3, 4);
        const auto page = *rc::gen::arbitrary<bool>() ? std::uint8_t{1} : std::uint8_t{0};
        const auto start = *rc::gen::inRange<std::uint8_t>(0, 200);
        const auto quantity = *rc::gen::inRange<std::uint8_t>(1, 3);
        Transaction asked{.id = static_cast<TransactionId>(i), .unit = UnitId{unit}, .wait = kWait};
        asked.in_order = line.in_order;
        asked.request = wire::Pdu{function, page, start, 0, quantity};
        line.ask(asked, *rc::gen::inRange(5, 101));
        const auto& outcome = line.rig.last();
        RC_ASSERT(outcome.id == asked.id);
        if (outcome.status != Status::ok) continue;
        RC_ASSERT(page == 0);
        for (std::uint8_t k = 0; k < quantity; ++k) RC_ASSERT(outcome.response.registers()[k] == start + k);
    }
}

}  // namespace mistaken_identity_test
}  // namespace takt::bus
