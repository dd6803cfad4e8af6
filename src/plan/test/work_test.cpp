// Planning n times as many lines takes about n times as much work; variables likewise. Work is counted in
// bytes of allocated memory, which does not depend on the machine.
#include <gtest/gtest.h>

#include <string>

#include "allocations.hpp"
#include "takt/plan/applied_measures.hpp"
#include "takt/plan/compare.hpp"
#include "takt/plan/proof.hpp"

namespace takt::plan {
namespace work_test {

using namespace std::chrono_literals;

constexpr std::size_t kTimes = 4;
constexpr double kTolerance = 1.1;

struct Shape {
    std::size_t lines = 1;
    std::size_t devices = 2;
    std::size_t variables = 5;
    Duration period = 20ms;
    model::Gaps gaps = model::Gaps::always;
    model::Strategy strategy = model::Strategy::classic;
};

model::Project project_of(const Shape& shape) {
    model::Project made;
    for (std::size_t l = 0; l < shape.lines; ++l) {
        auto& line = made.lines.emplace_back();
        line.name = "line " + std::to_string(l);
        line.format = {2400, 8, wire::Parity::none, 1};
        for (std::size_t d = 0; d < shape.devices; ++d) {
            auto& device = line.devices.emplace_back();
            device.name = "device " + std::to_string(d);
            device.address = UnitId{static_cast<std::uint8_t>(d + 1)};
            device.group_requests = true;
            device.strategy = shape.strategy;
            device.gaps = shape.gaps;
            device.turnaround = 2ms;
            for (std::size_t v = 0; v < shape.variables; ++v) {
                auto& variable = device.variables.emplace_back();
                variable.name = "variable " + std::to_string(v);
                variable.read = wire::Function::read_holding_registers;
                variable.area = wire::Area::holding_register;
                variable.register_number = static_cast<std::uint16_t>(3 * v);
                variable.registers = 1;
                variable.period = shape.period;
            }
            made.locals.emplace_back().name = device.name + " in " + line.name;
        }
    }
    return made;
}

template <class Work>
std::size_t work_of(const Work& work) {
    const takt::test::CountingAllocations counting;
    const std::size_t before = takt::test::allocations().bytes;
    work();
    return takt::test::allocations().bytes - before;
}

void expect_at_most(const char* what, std::size_t of_few, std::size_t of_many, double times) {
    EXPECT_GT(of_few, 0U) << what;
    EXPECT_LE(static_cast<double>(of_many), times * static_cast<double>(of_few)) << what;
}

/// @param times  the most work of `many`, compared with `few`
void expect_work(const model::Project& few, const model::Project& many, double times) {
    Proof proof_of_few, proof_of_many;
    expect_at_most("prove", work_of([&] { proof_of_few = prove(few, false, true); }),
                   work_of([&] { proof_of_many = prove(many, false, true); }), times);
    expect_at_most("apply", work_of([&] { (void)apply_measures(few, proof_of_few, false); }),
                   work_of([&] { (void)apply_measures(many, proof_of_many, false); }), times);
    expect_at_most("compare", work_of([&] { (void)compare(few, proof_of_few.plan); }),
                   work_of([&] { (void)compare(many, proof_of_many.plan); }), times);
}

void expect_linear_in_lines(Shape shape) {
    const auto few = project_of(shape);
    shape.lines *= kTimes;
    expect_work(few, project_of(shape), kTolerance * kTimes);
}

TEST(PlanningWork, GrowsWithTheNumberOfLinesWhereAllHold) {
    expect_linear_in_lines({.lines = 10, .period = 10s});
}

TEST(PlanningWork, GrowsWithTheNumberOfLinesWhereNoneHolds) {
    expect_linear_in_lines({.lines = 3});
    expect_linear_in_lines({.lines = 3, .strategy = model::Strategy::optimal});
}

TEST(PlanningWork, GrowsWithTheNumberOfLinesThatLearn) {
    expect_linear_in_lines({.lines = 2, .gaps = model::Gaps::learn, .strategy = model::Strategy::optimal});
}

// n log n, and vectors that grow to the next power of two.
TEST(PlanningWork, GrowsLittleFasterThanTheNumberOfVariables) {
    for (const auto strategy : {model::Strategy::classic, model::Strategy::optimal})
        for (const Duration period : {Duration(1000s), Duration(100ms)}) {
            Shape shape{.variables = 1000, .period = period, .strategy = strategy};
            const auto few = project_of(shape);
            shape.variables *= kTimes;
            const auto many = project_of(shape);
            // Without measures: how many trials a line needs depends on its variables.
            expect_at_most("prove", work_of([&] { (void)prove(few, false, false); }),
                           work_of([&] { (void)prove(many, false, false); }), 1.5 * kTimes);
            expect_at_most("compare", work_of([&] { (void)compare(few, make_plan(few)); }),
                           work_of([&] { (void)compare(many, make_plan(many)); }), 1.5 * kTimes);
        }
}

}  // namespace work_test
}  // namespace takt::plan
