#include "takt/bus/outcome_status.hpp"

#include <gtest/gtest.h>

namespace takt::bus {
namespace outcome_status_test {

// The numbers are those of docs/specification.md, section 7.
TEST(OutcomeStatus, OfEveryOutcome) {
    struct Row {
        Status status;
        std::uint8_t exception;
        unsigned number;
        bool answered;
        bool busy;
    };
    const Row rows[] = {
        {Status::ok, 0, 0, true, false},
        {Status::exception, 1, 1, true, false},
        {Status::exception, 5, 5, true, true},
        {Status::exception, 6, 6, true, true},
        {Status::exception, 0x0A, 10, false, false},
        {Status::exception, 0x0B, 11, false, false},
        {Status::exception, 99, 99, true, false},
        {Status::exception, 0, 256, true, false},
        {Status::exception, 100, 356, true, false},
        {Status::exception, 255, 511, true, false},
        {Status::timeout, 0, 100, false, false},
        {Status::line_busy, 0, 100, false, false},
        {Status::bad_checksum, 0, 101, false, false},
        {Status::unexpected_reply, 0, 102, false, false},
        {Status::ambiguous, 0, 110, true, false},
        {Status::link_lost, 0, 103, false, false},
        {Status::cancelled, 0, 103, false, false},
    };
    for (const auto& row : rows) {
        Outcome outcome;
        outcome.status = row.status;
        outcome.exception = row.exception;
        const OutcomeStatus status = status_of(outcome);
        EXPECT_EQ(number(status.status), row.number);
        EXPECT_EQ(status.answered, row.answered) << row.number;
        EXPECT_EQ(status.busy, row.busy) << row.number;
    }
}

TEST(OutcomeStatus, AttemptsAreLeftLongerWhereTheResponseIsInDoubt) {
    struct Row {
        StatusCode status;
        int again;  // times, with three attempts
    };
    for (const auto& row : {Row{StatusCode::timeout, 2}, Row{StatusCode::ambiguous, 4}}) {
        std::uint16_t failures = 0;
        int again = 0;
        while (attempts_left(row.status, 3, failures)) ++again;
        EXPECT_EQ(again, row.again) << number(row.status);
    }
    std::uint16_t failures = 2;
    EXPECT_TRUE(attempts_left(StatusCode::link_lost, 3, failures));
    EXPECT_EQ(failures, 2U);
}

}  // namespace outcome_status_test
}  // namespace takt::bus
