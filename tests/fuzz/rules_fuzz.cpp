// Random access rules and random requests to an endpoint: the frames on the lines behind it are exactly those
// that the rules allow, as an oracle of the test says (tests/support/rules_world.hpp).
#include <array>
#include <string>
#include <utility>
#include <vector>

#include "input.hpp"
#include "rules_world.hpp"

namespace takt::fuzz {
namespace {

using test::RuleText;

template <class List>
const auto& pick(Input& input, const List& list) {
    return list[input.byte() % std::size(list)];
}

// Numbers near each other and near the end, so that rules and requests meet.
int place(Input& input) {
    const std::uint8_t what = input.byte();
    if (what < 128) return what % 16;
    return what < 224 ? 65536 - 1 - what % 16 : input.word();
}

RuleText rule(Input& input) {
    static const std::vector<std::string> kPeers{"192.0.2.7",     "192.0.2.0/24", "::ffff:192.0.2.0/120",
                                                 "2001:db8::/32", "::/0",         "serial"};
    static const std::vector<std::string> kRules{"allow", "read_only", "deny", "allow"};
    RuleText made;
    const std::uint8_t has = input.byte();
    made.rule = pick(input, kRules);
    if ((has & 1) != 0) made.peers = {pick(input, kPeers)};
    for (int i = (has >> 1) % 4; i > 0; --i) {
        const int first = input.byte();
        made.units.emplace_back(first, std::min(255, first + input.byte() % 40));
    }
    for (int i = (has >> 3) % 4; i > 0; --i) {
        const int code = input.byte();
        made.functions.push_back(code < 64 ? "read" : code < 128 ? "write" : std::to_string(1 + code % 127));
    }
    if ((has & 32) != 0) {
        made.area = input.byte() % 4;
        for (int i = (has >> 6) % 4; i > 0; --i) {
            const int first = place(input);
            made.items.emplace_back(first, std::min(65535, first + input.byte() % 8));
        }
    }
    if ((has & 64) != 0) made.rate = 1 + input.byte() % 5;
    return made;
}

// A function with a fitting form more often than chance has it.
test::Pdu request(Input& input) {
    static constexpr std::array<std::uint8_t, 19> kFunctions{1,  2,  3,  4,  5,  6,  7,  8,  11, 12,
                                                             15, 16, 17, 20, 21, 22, 23, 24, 43};
    const std::uint8_t what = input.byte();
    test::Pdu pdu{what < 200 ? kFunctions[what % kFunctions.size()]
                             : static_cast<std::uint8_t>(input.byte())};
    const auto put = [&pdu](int value) {
        pdu.push_back(static_cast<std::uint8_t>(value >> 8));
        pdu.push_back(static_cast<std::uint8_t>(value));
    };
    const int count = 1 + input.byte() % 12;
    const auto values = [&](int bytes) {
        pdu.push_back(static_cast<std::uint8_t>(bytes));
        for (int i = 0; i < bytes; ++i) pdu.push_back(input.byte());
    };
    switch (pdu[0]) {
        case 1:
        case 2:
        case 3:
        case 4:
            put(place(input));
            put(count);
            break;
        case 5:
            put(place(input));
            put(0xFF00);
            break;
        case 6:
            put(place(input));
            put(count);
            break;
        case 8:
            put(input.byte() % 24);
            put(0);
            break;
        case 15:
            put(place(input));
            put(count);
            values((count + 7) / 8);
            break;
        case 16:
            put(place(input));
            put(count);
            values(2 * count);
            break;
        case 22:
            put(place(input));
            put(1);
            put(2);
            break;
        case 23:
            put(place(input));
            put(count);
            put(place(input));
            put(count);
            values(2 * count);
            break;
        case 24: put(place(input)); break;
        case 43:
            pdu.push_back(input.byte() % 2 == 0 ? 14 : input.byte());
            put(0x0100);
            break;
        default: break;
    }
    if (what % 8 == 7)
        for (const std::uint8_t byte : input.bytes(input.byte() % 8)) pdu.push_back(byte);
    if (what % 16 == 8 && pdu.size() > 1) pdu.pop_back();
    return pdu;
}

void play(Input input) {
    test::RulesWorld world;
    std::vector<RuleText> rules;
    for (int i = input.byte() % 6; i > 0; --i) rules.push_back(rule(input));
    if (!world.set(rules)) return;
    for (int i = 0; i < 60 && !input.empty(); ++i) {
        const std::size_t client = input.byte() % test::clients().size();
        const int unit = pick(input, test::RulesWorld::kUnits);
        const test::Pdu pdu = request(input);
        const auto result = world.ask(client, unit, pdu);
        require(result.seen == result.expected);
        const bool broadcast = test::clients()[client].peer[0] == '/' && unit == 0;
        require(test::RulesWorld::answered_right(result, pdu, broadcast));
    }
}

}  // namespace
}  // namespace takt::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    takt::fuzz::play(takt::fuzz::Input({data, size}));
    return 0;
}
