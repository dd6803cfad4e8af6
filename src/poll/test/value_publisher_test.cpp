// What responses do to the values of a line, without a line.
#include "reads/value_publisher.hpp"

#include <gtest/gtest.h>

#include "bench.hpp"
#include "line/transfer.hpp"

namespace takt::poll::test {
namespace value_publisher_test {

using value::Quality;
using value::Reason;

/// A device with the registers a 10, b 11 (default 7), c 12 (hold_last); w 13 is only written; d at 20 and 21
/// is read in two parts. Request 0 reads 10..12, request 1 reads 20, request 2 reads 21.
struct Published {
    Published()
        : described(project({device(1, {int16("a", 10).read(3), int16("b", 11).read(3).defaults_to(7),
                                        int16("c", 12).read(3).holding(), int16("w", 13).write(6),
                                        item("d", DataType::int32, 20).read(3)})})),
          slots(described),
          store(value::slot_infos(described)),
          written(store),
          schedule({variables, devices, requests}, arrivals),
          publisher({variables, devices, requests}, schedule, written, store) {
        const auto& models = described.lines[0].devices[0].variables;
        for (std::size_t v = 0; v < models.size(); ++v)
            variables.push_back({.model = &models[v], .slot = slots.variable({0, 0, v})});
        written.add(3, models[3], variables[3].slot);
        devices.resize(1);
        requests.resize(3);
        plans.resize(3);
        add_read(0, 10, 3, {0, 1, 2});
        add_read(1, 20, 1, {4});
        add_read(2, 21, 1, {4});
        publisher.set_requests();
    }
    void add_read(std::size_t r, int start, int quantity, std::vector<std::size_t> members) {
        requests[r].plan = &plans[r];
        requests[r].variables = std::move(members);
        requests[r].read = ReadJob{.request = read(start, quantity), .polled = true};
        schedule.add(r, 100ms, std::nullopt);
    }
    static wire::PreparedRead read(int start, int quantity) {
        return prepared({Function::read_holding_registers, DataAddress{static_cast<std::uint16_t>(start)},
                         static_cast<std::uint16_t>(quantity)});
    }
    /// The device answers a read of `quantity` registers from `start` on, each with its address.
    void take(std::size_t request, int start, int quantity) {
        const auto sent = read(start, quantity);
        std::vector<std::uint8_t> pdu{0x03, static_cast<std::uint8_t>(2 * quantity)};
        for (int address = start; address < start + quantity; ++address) {
            pdu.push_back(0);
            pdu.push_back(static_cast<std::uint8_t>(address));
        }
        const auto response = wire::decode_response(sent.shape(), sent.pdu(), pdu);
        ASSERT_TRUE(response);
        publisher.take({.response = *response, .sent_at = now, .ended_at = now}, request, sent.shape(),
                       schedule.round(request));
    }
    /// "10 11? !": good, uncertain, bad; without a value "-".
    [[nodiscard]] std::string shown(std::size_t variable) const {
        const auto& slot = store[variables[variable].slot];
        const auto* number = std::get_if<std::int64_t>(&slot.value);
        const char* quality = slot.quality == Quality::good ? "" : slot.quality == Quality::bad ? "!" : "?";
        return (number ? std::to_string(*number) : "-") + quality;
    }

    model::Project described;
    value::ProjectSlots slots;
    value::Store store;
    WrittenValues written;
    std::vector<plan::Request> plans;
    std::vector<VariableRun> variables;
    std::vector<DeviceRun> devices;
    std::vector<RequestRun> requests;
    ArrivalCounter arrivals;
    ReadSchedule schedule;
    ValuePublisher publisher;
    Instant now = at(1s);
};

TEST(ValuePublisher, AResponseHasTheValuesOfItsRequest) {
    Published line;
    line.take(0, 10, 3);
    EXPECT_EQ(line.shown(0) + " " + line.shown(1) + " " + line.shown(2), "10 11 12");
    EXPECT_EQ(line.publisher.updates().size(), 3U);
    const auto batch = [&](std::size_t v) { return line.store[line.variables[v].slot].batch; };
    EXPECT_TRUE(batch(0) == batch(1) && batch(1) == batch(2)) << "they change together";
}

TEST(ValuePublisher, AWiderReadBeginsAtAnotherAddress) {
    Published line;
    line.take(0, 8, 6);
    EXPECT_EQ(line.shown(0) + " " + line.shown(1) + " " + line.shown(2), "10 11 12");
}

TEST(ValuePublisher, APartOfAReadHasOnlyItsOwnValues) {
    Published line;
    line.take(0, 11, 1);
    EXPECT_EQ(line.publisher.updates().size(), 1U);
    EXPECT_EQ(line.shown(1), "11");
    EXPECT_NE(line.shown(0), "10");
}

TEST(ValuePublisher, PartsOfALongValueAreShownTogether) {
    Published line;
    EXPECT_TRUE(line.publisher.splits().has(4));
    line.take(1, 20, 1);
    EXPECT_TRUE(line.publisher.updates().empty());
    line.take(2, 21, 1);
    EXPECT_EQ(line.publisher.updates().size(), 1U);
    EXPECT_EQ(line.store[line.variables[4].slot].quality, Quality::good);
    line.take(1, 20, 1);
    line.publisher.forget_parts(line.requests[1].variables);
    line.take(2, 21, 1);
    EXPECT_TRUE(line.publisher.updates().empty());
}

TEST(ValuePublisher, ValuesThatWereNotReadAreDegraded) {
    Published line;
    line.take(0, 10, 3);
    line.publisher.degrade(line.now, line.requests[0].variables, Quality::uncertain, Reason::timeout,
                           Shown::last);
    EXPECT_EQ(line.shown(0) + " " + line.shown(1) + " " + line.shown(2), "10? 11? 12?");
    line.publisher.degrade(line.now, line.requests[0].variables, Quality::bad, Reason::not_answering,
                           Shown::initial);
    EXPECT_EQ(line.shown(0) + " " + line.shown(1) + " " + line.shown(2), "10! 7! 12!");
    line.publisher.degrade(line.now, line.requests[0].variables, Quality::uncertain, Reason::timeout,
                           Shown::last);
    EXPECT_EQ(line.shown(0), "10!") << "bad stays bad";
}

TEST(ValuePublisher, OnlyVariablesThatNothingReadsShowWhatWasWritten) {
    Published line;
    const std::vector<std::size_t> all{0, 3};
    line.written.note_sent(3, value::Value(std::int64_t{5}));
    line.publisher.show_written(line.now, all);
    EXPECT_EQ(line.publisher.updates().size(), 1U);
    EXPECT_EQ(line.shown(3), "5");
}

TEST(ValuePublisher, VariablesThatNothingReadsKeepTheirQualityWhileTheirDeviceDoesNotAnswer) {
    Published line;
    const std::vector<std::size_t> all{0, 3};
    line.take(0, 10, 3);
    line.written.note_sent(3, value::Value(std::int64_t{5}));
    line.publisher.show_written(line.now, all);
    line.publisher.degrade(line.now, all, Quality::bad, Reason::not_answering, Shown::initial);
    EXPECT_EQ(line.shown(0) + " " + line.shown(3), "10! 5");
}

TEST(ValuePublisher, AValueReadBackIsShownUnlessItIsReadInParts) {
    Published line;
    line.publisher.begin(Instant{});
    line.publisher.read_back(0, Function::read_holding_registers, value::Value(std::int64_t{3}));
    line.publisher.read_back(3, Function::read_holding_registers, value::Value(std::int64_t{4}));
    line.publisher.read_back(4, Function::read_holding_registers, value::Value(std::int64_t{5}));
    line.publisher.publish(line.now);
    EXPECT_EQ(line.shown(0) + " " + line.shown(3), "3 4");
    EXPECT_EQ(line.publisher.updates().size(), 2U);
}

}  // namespace value_publisher_test
}  // namespace takt::poll::test
