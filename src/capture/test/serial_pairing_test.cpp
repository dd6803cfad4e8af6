// Requests and responses by order, shape and time, also with several masters on a line.
#include "takt/capture/serial_pairing.hpp"

#include <gtest/gtest.h>

#include <string>

#include "capture_bytes.hpp"

namespace takt::capture {
namespace serial_pairing_test {

using namespace test;
using namespace std::chrono_literals;

/// What the frames became: Q request, B broadcast, S stray, A<n> response to request n, U<n> given up.
class Line {
public:
    void frame(std::uint8_t unit, std::string_view pdu, Duration at, Sender sender = Sender::unknown) {
        const auto outcome = pairing_.on_frame(at.count(), unit, hex(pdu), sender);
        note(outcome.given_up);
        switch (outcome.role) {
            case SerialPairing::Role::request:
            case SerialPairing::Role::broadcast:
                numbers_[outcome.slot] = ++requests_;
                text += outcome.role == SerialPairing::Role::request ? "Q" : "B";
                if (outcome.overlaps) text += '!';
                if (outcome.repeats) text += '=';
                break;
            case SerialPairing::Role::response: text += "A" + std::to_string(numbers_[outcome.slot]); break;
            case SerialPairing::Role::stray: text += "S"; break;
        }
        text += ' ';
    }
    void expire(Duration at) { note(pairing_.expire(at.count())); }
    void end() { note(pairing_.end()); }
    std::string text;

private:
    void note(const SerialPairing::Slots& slots) {
        for (const auto slot : slots) text += "U" + std::to_string(numbers_[slot]) + ' ';
    }
    SerialPairing pairing_{1s};
    int requests_ = 0;
    std::array<int, SerialPairing::kSlots> numbers_{};
};

TEST(SerialPairing, AKnownSenderDecides) {
    Line line;
    line.frame(1, "06 0001 0002", 0ms, Sender::master);
    line.frame(1, "06 0001 0002", 5ms, Sender::master);  // repeated
    line.frame(1, "06 0001 0002", 900ms, Sender::slave);
    line.frame(1, "06 0001 0002", 910ms, Sender::slave);
    line.frame(1, "03 0000 0001", 920ms, Sender::slave);
    EXPECT_EQ(line.text, "Q U1 Q= A2 S S ");
}

TEST(SerialPairing, KeepsRequestsOfTwoMastersWhileTheirResponsesAreDue) {
    Line line;
    line.frame(1, "03 0000 0001", 0ms);
    line.frame(1, "03 02 0007", 20ms);
    line.frame(2, "03 0000 0001", 100ms);
    line.frame(2, "03 02 0007", 120ms);
    line.frame(1, "03 0000 0001", 200ms);
    line.frame(2, "03 0000 0001", 205ms);
    line.frame(1, "03 02 0007", 221ms);
    line.frame(2, "03 02 0007", 240ms);
    EXPECT_EQ(line.text, "Q A1 Q A2 Q Q! A3 A4 ");
}

TEST(SerialPairing, WaitsAlsoForAUnitThatHasNotRespondedBefore) {
    Line line;
    line.frame(1, "03 0000 0001", 0ms);
    line.frame(2, "03 0000 0001", 2ms);
    line.frame(1, "03 02 0007", 5ms);
    line.frame(2, "03 02 0007", 9ms);
    line.frame(3, "03 0000 0001", 100ms);
    line.frame(1, "03 0000 0001", 1101ms);
    EXPECT_EQ(line.text, "Q Q A1 A2 Q U3 Q ");
}

TEST(SerialPairing, GivesTheOldestRequestTheFirstOfTwoEqualResponses) {
    Line line;
    line.frame(1, "03 0000 0001", 0ms);
    line.frame(1, "03 02 0007", 20ms);
    line.frame(1, "03 0000 0001", 100ms);
    line.frame(1, "03 0010 0001", 105ms);
    line.frame(1, "03 02 0007", 121ms);
    line.frame(1, "03 02 0008", 140ms);
    EXPECT_EQ(line.text, "Q A1 Q Q! A2 A3 ");
}

TEST(SerialPairing, TheNewestRequestOfAMasterThatGaveUpGetsTheResponse) {
    Line line;
    line.frame(1, "03 0000 0001", 0ms);
    line.frame(1, "03 02 0007", 5ms);
    line.frame(1, "03 0000 0001", 100ms);
    line.frame(1, "03 0010 0001", 150ms);
    line.frame(1, "03 02 0007", 155ms);
    EXPECT_EQ(line.text, "Q A1 Q Q A3 ");
}

// One slow response, and later a lost one: the master has given its request up.
TEST(SerialPairing, ALostResponseDoesNotShiftThoseAfterIt) {
    for (const Duration slow : {Duration(5ms), Duration(900ms), Duration(40s)}) {
        Line line;
        line.frame(1, "03 0000 0001", 0ms);
        line.frame(1, "03 02 0001", slow);
        for (int i = 0; i < 20; ++i) {
            const auto at = slow + 100ms * (i + 1);
            line.frame(1, i % 2 == 0 ? "03 0001 0001" : "03 0002 0001", at);
            if (i != 10) line.frame(1, "03 02 0001", at + 5ms);
        }
        line.end();
        EXPECT_NE(line.text.find("A21 "), std::string::npos) << line.text;
        EXPECT_EQ(line.text.find("A12 "), std::string::npos) << "the lost one: " << line.text;
    }
}

TEST(SerialPairing, ARepetitionIsARequest) {
    Line line;
    line.frame(1, "03 0000 0001", 0ms);
    line.frame(1, "03 0000 0001", 300ms);
    line.frame(1, "01 0300 0018", 600ms);
    line.frame(1, "01 0300 0018", 700ms);
    EXPECT_EQ(line.text, "Q U1 Q= Q U3 Q= ") << "the last one has the shape of a response to itself";
}

TEST(SerialPairing, ARepeatedWriteIsNoResponseWhereTheUnitRespondsSooner) {
    Line line;
    line.frame(1, "03 0000 0001", 0ms);
    line.frame(1, "03 02 0007", 5ms);
    line.frame(1, "06 0000 0001", 100ms);
    line.frame(1, "06 0000 0001", 190ms);
    line.frame(1, "06 0000 0001", 300ms);
    line.frame(1, "06 0000 0001", 500ms);
    line.frame(1, "06 0000 0001", 505ms);
    EXPECT_EQ(line.text, "Q A1 Q A2 Q U3 Q= A4 ");
}

TEST(SerialPairing, ExpiresAndEnds) {
    Line line;
    line.frame(1, "03 0000 0001", 0ms);
    line.expire(999ms);
    EXPECT_EQ(line.text, "Q ");
    line.expire(1s);
    line.frame(1, "03 02 0007", 1200ms);
    line.frame(0, "06 0000 0001", 1300ms);
    line.frame(1, "03 0000 0001", 1400ms);
    line.end();
    EXPECT_EQ(line.text, "Q U1 S B Q U3 ");
}

TEST(SerialPairing, HoldsAtMostFourRequests) {
    Line line;
    for (std::uint8_t unit = 1; unit <= 6; ++unit) {
        line.frame(unit, "03 0000 0001", 0ms);
        line.frame(unit, "03 02 0007", 50ms);
    }
    line.text.clear();
    for (std::uint8_t unit = 1; unit <= 6; ++unit) line.frame(unit, "03 0000 0001", 100ms);
    line.end();
    EXPECT_EQ(line.text, "Q Q! Q! Q! U7 Q! U8 Q! U9 U10 U11 U12 ");
}

}  // namespace serial_pairing_test
}  // namespace takt::capture
