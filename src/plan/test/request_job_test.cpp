// The scheduling facts of requests, typed by hand.
#include "takt/plan/request_job.hpp"

#include <gtest/gtest.h>

#include "builder.hpp"
#include "takt/plan/guarantee.hpp"

namespace takt::plan {
namespace request_job_test {

using namespace test;
using wire::Function;

constexpr Settings kOptimal{16, wire::Framing::rtu, model::Profile::generic, model::Strategy::optimal};
constexpr model::RateLimit kLimit{500ms, 2};

model::Project made(const std::vector<Item>& items) {
    auto project = test::project(kOptimal, items);
    project.locals.resize(2);
    return project;
}

/// The job of the only request of the project that has the cause.
RequestJob only_job(const model::Project& project, Cause cause) {
    const auto plan = make_plan(project);
    std::vector<RequestJob> found;
    for (const auto& request : plan.lines[0].requests)
        if (auto job = job_of(project, project.lines[0], request, cause)) found.push_back(*std::move(job));
    EXPECT_EQ(found.size(), 1U);
    return found.empty() ? RequestJob{} : found.front();
}

TEST(RequestJob, OfPolling) {
    auto project = made({int16(0).read(3).every(200ms), int16(1).read(3).every(200ms)});
    RequestJob job = only_job(project, Cause::period);
    EXPECT_EQ(job.job_class, JobClass::polled);
    EXPECT_EQ(job.period, 200ms);
    EXPECT_EQ(job.deadline, 200ms) << "the period";
    EXPECT_EQ(job.members, (std::vector<std::size_t>{0, 1}));
    EXPECT_EQ(job.function, Function::read_holding_registers);
    EXPECT_EQ(job.response_length, 2U + 2 * 2);
    EXPECT_FALSE(job.admission || job.read_before || job.read_back);
    EXPECT_EQ(job.costs.size(), 1U);
    project.lines[0].devices[0].variables[1].deadline = 70ms;
    EXPECT_EQ(only_job(project, Cause::period).deadline, 70ms) << "the least of its variables";
}

TEST(RequestJob, OfPeriodZero) {
    const auto project = made({int16(0).read(3).every(0ms)});
    const RequestJob job = only_job(project, Cause::period);
    EXPECT_EQ(job.job_class, JobClass::best_effort);
    EXPECT_EQ(job.period, 0ms);
    EXPECT_EQ(job.deadline, 0ms);
}

TEST(RequestJob, OfAReadTrigger) {
    auto project = made({int16(0).read(4).read_on(0)});
    RequestJob job = only_job(project, Cause::read_trigger);
    EXPECT_EQ(job.job_class, JobClass::best_effort) << "without a rate limit";
    EXPECT_EQ(job.deadline, std::nullopt);
    EXPECT_EQ(job.period, 0ms);
    project.locals[0].admission = kLimit;
    job = only_job(project, Cause::read_trigger);
    EXPECT_EQ(job.job_class, JobClass::triggered);
    EXPECT_EQ(job.admission, kLimit);
    EXPECT_EQ(job.period, 500ms);
    EXPECT_EQ(job.deadline, 500ms) << "the least time between two";
    project.lines[0].devices[0].variables[0].deadline = 40ms;
    EXPECT_EQ(only_job(project, Cause::read_trigger).deadline, 40ms);
}

TEST(RequestJob, OfAWrite) {
    auto project = made({int16(3).read(3).write(0x10).on_change(), int16(4).read(3).write(0x10).on_change()});
    for (auto& variable : project.lines[0].devices[0].variables) variable.admission = kLimit;
    RequestJob job = only_job(project, Cause::write);
    EXPECT_EQ(job.job_class, JobClass::command);
    EXPECT_EQ(job.members, (std::vector<std::size_t>{0, 1}));
    EXPECT_EQ(job.function, Function::write_multiple_registers);
    EXPECT_EQ(job.response_length, 5U);
    EXPECT_FALSE(job.read_before || job.read_back);
    project.lines[0].devices[0].variables[1].verify = true;
    job = only_job(project, Cause::write);
    EXPECT_EQ(job.read_back, (wire::ReadRequest{Function::read_holding_registers, DataAddress{3}, 2}));
    EXPECT_EQ(job.costs.size(), 2U) << "the write and its verification";
}

// Bits of one register without 0x16: the read comes first.
TEST(RequestJob, OfAReadModifyWrite) {
    auto project = made({boolean(7, 2).read(3).write(0x06).on_change()});
    project.lines[0].devices[0].read_modify_write = true;
    const RequestJob job = only_job(project, Cause::write);
    EXPECT_EQ(job.read_before, (wire::ReadRequest{Function::read_holding_registers, DataAddress{7}, 1}));
    EXPECT_EQ(job.function, Function::read_holding_registers);
    EXPECT_EQ(job.response_length, 4U);
    EXPECT_EQ(job.costs.size(), 1U) << "nothing goes between them";
}

TEST(RequestJob, OfCoils) {
    auto project = made({boolean(0, 1).read(1).write(0x0F).on_change()});
    project.lines[0].devices[0].variables[0].verify = true;
    const RequestJob job = only_job(project, Cause::write);
    EXPECT_EQ(job.read_back->function, Function::read_coils);
    EXPECT_EQ(job.response_length, 5U);
}

// 0x17 writes the variables of its trigger in the range that it writes, and only those.
TEST(RequestJob, OfAnExchange) {
    Request both;
    both.read = both.write = Function::read_write_multiple_registers;
    both.start = 0;
    both.quantity = 2;
    both.write_start = 20;
    both.write_quantity = 2;
    both.read_trigger = both.write_trigger = 0;
    auto project = made({int16(0).read(3).read_on(0), int16(20).write(0x10).write_on(0),
                         int16(21).write(0x10).write_on(1), int32(21).write(0x10).write_on(0)});
    both.variables = {0, 1, 2, 3};
    auto& variables = project.lines[0].devices[0].variables;
    EXPECT_FALSE(is_written(both, variables[0])) << "read only";
    EXPECT_TRUE(is_written(both, variables[1]));
    EXPECT_FALSE(is_written(both, variables[2])) << "of another trigger";
    EXPECT_FALSE(is_written(both, variables[3])) << "only half of it lies in the range";
    const auto& line = project.lines[0];
    const auto write = job_of(project, line, both, Cause::write);
    ASSERT_TRUE(write);
    EXPECT_EQ(write->members, (std::vector<std::size_t>{1}));
    EXPECT_EQ(write->function, Function::read_write_multiple_registers);
    EXPECT_EQ(write->response_length, 2U + 2 * 2);
    EXPECT_EQ(job_of(project, line, both, Cause::read_trigger)->function, Function::read_holding_registers)
        << "sent alone while values to write are missing";
    EXPECT_FALSE(job_of(project, line, both, Cause::period));
    for (auto& variable : variables) variable.verify = true;
    EXPECT_EQ(job_of(project, line, both, Cause::write)->read_back,
              (wire::ReadRequest{Function::read_holding_registers, DataAddress{20}, 2}));
    EXPECT_FALSE(is_verified(both, variables[2]));
}

// The proof judges the same deadlines and classes.
TEST(RequestJob, IsWhatTheProofUses) {
    auto project = made({int16(0).read(3).every(100ms), int16(40).read(3).every(0ms),
                         int16(1).write(0x06).on_change(), int16(60).read(4).read_on(0).every(300ms)});
    project.locals[0].admission = kLimit;
    project.lines[0].devices[0].variables[2].admission = model::RateLimit{2s, 1};
    const auto plan = make_plan(project);
    const auto& line = plan.lines[0];
    const auto proved = guarantee_line(project, line);
    ASSERT_GE(proved.jobs.size(), 5U);
    for (const auto& bound : proved.jobs) {
        const auto job = job_of(project, project.lines[0], line.requests[bound.request], bound.cause);
        ASSERT_TRUE(job);
        EXPECT_EQ(bound.limited, job->job_class != JobClass::best_effort);
        if (bound.limited) {
            EXPECT_EQ(bound.bound.deadline, job->deadline);
        }
        Duration transaction{};
        for (const auto& cost : job->costs) transaction += std::chrono::microseconds(cost.transaction);
        EXPECT_EQ(bound.bound.transaction, transaction);
    }
}

}  // namespace request_job_test
}  // namespace takt::plan
