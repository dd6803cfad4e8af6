#include "devices/statuses.hpp"

#include <gtest/gtest.h>

#include "bench.hpp"
#include "line/transfer.hpp"

namespace takt::poll::test {
namespace statuses_test {

wire::PreparedRead a_read() {
    return prepared({Function::read_holding_registers, DataAddress{0}, 1});
}

using value::Reason;

constexpr auto kException = value::exception_reason(2);
constexpr model::LocalIndex kA = 0;       // of the variables 0 and 1
constexpr model::LocalIndex kB = 1;       // of the variable 2
constexpr model::LocalIndex kDevice = 2;  // of the device

/// A device with two requests: 0 polls the variables 0 and 1, 1 writes the variable 2.
struct Shown {
    Shown()
        : described(project({with_status(device(1, {int16("a", 0).read(3).reports_to(kA),
                                                    int16("b", 1).read(3).reports_to(kA),
                                                    int16("c", 2).write(6).reports_to(kB)}))},
                            {local("sa", DataType::int16), local("sb", DataType::int16),
                             local("device", DataType::int16)})),
          slots(described),
          store(value::slot_infos(described)),
          statuses({variables, devices, requests}, slots, store) {
        const auto& model = described.lines[0].devices[0];
        devices.resize(1);
        devices[0].model = &model;
        devices[0].requests = {0, 1};
        devices[0].health.set_reads(true);
        for (const auto& variable : model.variables) variables.push_back({.model = &variable});
        requests.resize(2);
        requests[0].variables = {0, 1};
        requests[0].read = ReadJob{.request = a_read(), .polled = true};
        requests[1].variables = {2};
        statuses.set_requests();
    }
    static model::Device with_status(model::Device device) {
        device.status = kDevice;
        return device;
    }
    /// The locals, as "a b device".
    [[nodiscard]] std::string shown() const {
        std::string text;
        for (const auto local : {kA, kB, kDevice}) {
            const auto& value = store[slots.local(local)].value;
            text += (text.empty() ? "" : " ") + std::to_string(std::get<std::int64_t>(value));
        }
        return text;
    }

    model::Project described;
    value::ProjectSlots slots;
    value::Store store;
    std::vector<VariableRun> variables;
    std::vector<DeviceRun> devices;
    std::vector<RequestRun> requests;
    Statuses statuses;
    Instant now = at(1s);
};

TEST(LineStatuses, AReadShowsItsResultInTheLocalsOfItsVariables) {
    Shown line;
    EXPECT_EQ(line.shown(), "0 0 0");
    line.statuses.read_ended(line.now, 0, kException);
    EXPECT_EQ(line.shown(), "2 0 2");
    line.statuses.read_ended(line.now, 0, Reason::ok);
    EXPECT_EQ(line.shown(), "0 0 0");
}

TEST(LineStatuses, ADeviceShowsItsFirstRequestThatIsNotOk) {
    Shown line;
    line.statuses.write_ended(line.now, 1, line.requests[1].variables, Reason::timeout);
    EXPECT_EQ(line.shown(), "0 100 100");
    line.statuses.read_ended(line.now, 0, kException);
    EXPECT_EQ(line.shown(), "2 100 2");
    line.statuses.read_ended(line.now, 0, Reason::ok);
    EXPECT_EQ(line.shown(), "0 100 100");
    EXPECT_EQ(line.statuses.of_requests(), (std::vector{Reason::ok, Reason::timeout}));
    line.statuses.restart(0);
    EXPECT_EQ(line.statuses.of_request(1), Reason::ok);
}

TEST(LineStatuses, AWriteSetsOnlyTheVariablesThatItWrites) {
    Shown line;
    const std::size_t kOne[] = {2};
    line.statuses.write_ended(line.now, 0, kOne, kException);
    EXPECT_EQ(line.shown(), "0 2 2");
}

// A command has no request.
TEST(LineStatuses, ACommandSetsItsVariableAlone) {
    Shown line;
    line.statuses.write_ended(line.now, std::size_t{2}, kException);
    EXPECT_EQ(line.shown(), "0 2 0");
}

TEST(LineStatuses, WhileADeviceIsAwayItsVariablesShowWhy) {
    Shown line;
    line.statuses.write_ended(line.now, std::size_t{2}, kException);
    line.devices[0].health.enable(false);
    line.statuses.device_away(line.now, 0, Reason::switched_off);
    EXPECT_EQ(line.shown(), "104 104 104");
    line.statuses.write_ended(line.now, std::size_t{2}, Reason::timeout);
    EXPECT_EQ(line.shown(), "104 104 104") << "the result is noted, not shown";
    line.devices[0].health.enable(true);
    line.statuses.device_back(line.now, 0);
    EXPECT_EQ(line.shown(), "104 100 104") << "what is polled waits for its next read";
    line.statuses.read_ended(line.now, 0, Reason::ok);
    line.statuses.restart(0);
    EXPECT_EQ(line.shown(), "0 100 104");
}

TEST(LineStatuses, AFailureIsNotedUntilItsDeviceIsShown) {
    Shown line;
    line.statuses.note_failed(0, Reason::timeout);
    EXPECT_EQ(line.shown(), "0 0 0");
    EXPECT_EQ(line.statuses.of_request(0), Reason::ok);
}

TEST(LineStatuses, StaleValuesAreShown) {
    Shown line;
    const std::size_t kVariables[] = {0};
    const std::size_t kRequests[] = {0};
    line.statuses.values_stale(line.now, kVariables, kRequests);
    const auto stale = std::to_string(value::status_code(Reason::stale));
    EXPECT_EQ(line.shown(), stale + " 0 " + stale);
}

TEST(LineStatuses, NewRequestsAreOkAndVariablesKeepTheirResults) {
    Shown line;
    line.statuses.write_ended(line.now, std::size_t{2}, kException);
    line.statuses.read_ended(line.now, 0, kException);
    line.statuses.set_requests();
    EXPECT_EQ(line.statuses.of_request(0), Reason::ok);
    line.statuses.carry(0, Reason::timeout);
    EXPECT_EQ(line.statuses.of_request(0), Reason::timeout);
    line.statuses.show_unavailable(line.now, 2, Reason::not_answering);
    line.statuses.device_back(line.now, 0);
    EXPECT_EQ(line.shown(), "2 2 2") << "as before its device was away";
}

TEST(LineStatuses, AnUnusedVariableShowsNothing) {
    Shown line;
    model::Variable unused = *line.variables[2].model;
    unused.used = false;
    line.variables[2].model = &unused;
    line.statuses.write_ended(line.now, std::size_t{2}, kException);
    EXPECT_EQ(line.shown(), "0 0 0");
}

}  // namespace statuses_test
}  // namespace takt::poll::test
