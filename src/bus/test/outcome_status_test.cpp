#include "takt/bus/outcome_status.hpp"

#include <gtest/gtest.h>

namespace takt::bus {
namespace {

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

}  // namespace
}  // namespace takt::bus
