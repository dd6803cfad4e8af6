// The observer of the devices reports what they really did.
#include "takt/sim/device_observer.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "support.hpp"
#include "takt/sim/devices.hpp"

namespace takt::sim {
namespace device_observer_test {

using namespace std::chrono_literals;
using wire::Area;

struct Diary final : DeviceObserver {
    struct Entry {
        std::string what;
        Instant time;
        Area area;
        std::uint16_t start;
        std::vector<std::uint16_t> values;
        friend bool operator==(const Entry&, const Entry&) = default;
    };
    void note(std::string what, const DeviceItems& items) {
        entries.push_back({std::move(what),
                           items.time,
                           items.area,
                           items.start,
                           {items.values.begin(), items.values.end()}});
    }
    void on_read(const DeviceItems& items) override { note("read", items); }
    void on_write(const DeviceItems& items) override { note(items.broadcast ? "broadcast" : "write", items); }
    void on_change(const DeviceItems& items) override { note("change", items); }
    std::vector<Entry> entries;
};

struct Rig {
    explicit Rig(Fill fill = Fill::zero) : devices(UnitId{1}, fill) { devices.set_observer(&diary); }
    wire::Pdu ask(Duration since_start, const wire::Pdu& pdu, bool broadcast = false) {
        return devices.handle({at(since_start), UnitId{1}, broadcast, {}, {}}, wire::RequestView(pdu.span()))
            .pdu;
    }
    Devices devices;
    Diary diary;
};

TEST(DeviceObserver, IsNotifiedOfReadsWritesAndChanges) {
    Rig rig(Fill::ramp);
    rig.ask(1ms, {0x03, 0x01, 0x00, 0x00, 0x02});
    rig.ask(2ms, {0x01, 0x00, 0x07, 0x00, 0x03});
    rig.ask(3ms, {0x06, 0x01, 0x01, 0xAB, 0xCD});
    rig.ask(4ms, {0x0F, 0x00, 0x08, 0x00, 0x02, 0x01, 0x02});
    rig.ask(5ms, {0x16, 0x01, 0x01, 0xFF, 0x00, 0x00, 0x12});
    rig.ask(6ms, {0x17, 0x01, 0x00, 0x00, 0x02, 0x01, 0x00, 0x00, 0x01, 0x02, 0x00, 0x05});
    rig.ask(7ms, {0x06, 0x00, 0x00, 0x00, 0x09}, true);
    const std::uint16_t three[] = {3};
    EXPECT_TRUE(rig.devices[0].change(at(8ms), Area::input_register, 4, three));
    const std::vector<Diary::Entry> expected{{"read", at(1ms), Area::holding_register, 0x100, {0x100, 0x101}},
                                             {"read", at(2ms), Area::coil, 7, {1, 0, 1}},
                                             {"write", at(3ms), Area::holding_register, 0x101, {0xABCD}},
                                             {"write", at(4ms), Area::coil, 8, {0, 1}},
                                             {"write", at(5ms), Area::holding_register, 0x101, {0xAB12}},
                                             {"write", at(6ms), Area::holding_register, 0x100, {5}},
                                             {"read", at(6ms), Area::holding_register, 0x100, {5, 0xAB12}},
                                             {"broadcast", at(7ms), Area::holding_register, 0, {9}},
                                             {"change", at(8ms), Area::input_register, 4, {3}}};
    EXPECT_EQ(rig.diary.entries, expected);
}

TEST(DeviceObserver, IsNotNotifiedOfRefusedRequests) {
    Rig rig;
    rig.ask(1ms, {0x03, 0xFF, 0xFF, 0x00, 0x02});
    rig.ask(2ms, {0x05, 0x00, 0x00, 0x12, 0x34});
    rig.devices[0].behaviour.refuses_all = wire::ExceptionCode::server_device_busy;
    rig.ask(3ms, {0x06, 0x00, 0x00, 0x00, 0x01});
    rig.devices[0].behaviour.dead = true;
    rig.ask(4ms, {0x03, 0x00, 0x00, 0x00, 0x01});
    EXPECT_TRUE(rig.diary.entries.empty());
}

TEST(DeviceObserver, AValueThatMovesIsReportedWhenItIsFoundMoved) {
    model::Device described;
    described.address = UnitId{1};
    model::Variable variable;
    variable.name = "level";
    variable.type = DataType::int16;
    variable.area = Area::holding_register;
    variable.register_number = 7;
    described.variables.push_back(variable);
    Device device(described);
    Diary diary;
    device.set_observer(&diary);
    serve::Unit unit = device.unit();
    const wire::Pdu read{0x03, 0x00, 0x07, 0x00, 0x01};
    (void)serve::respond(unit, {at(10s), UnitId{1}, false, {}, {}}, wire::RequestView(read.span()));
    ASSERT_EQ(diary.entries.size(), 1u);
    EXPECT_EQ(diary.entries[0].what, "change");
    const auto moved = diary.entries[0].values;
    const std::uint16_t held[] = {1234};
    ASSERT_TRUE(device.change(at(11s), Area::holding_register, 7, held));
    (void)serve::respond(unit, {at(20s), UnitId{1}, false, {}, {}}, wire::RequestView(read.span()));
    EXPECT_EQ(diary.entries.size(), 2u) << "what was set does not move";
    device.forget(at(21s));
    EXPECT_EQ(diary.entries.back().values, std::vector<std::uint16_t>{0});
    (void)serve::respond(unit, {at(10s), UnitId{1}, false, {}, {}}, wire::RequestView(read.span()));
    EXPECT_EQ(diary.entries.back().values, moved) << "it moves again";
    const std::uint16_t two[] = {1, 2};
    EXPECT_FALSE(device.change(at(22s), Area::holding_register, 7, two)) << "8 does not exist";
}

}  // namespace device_observer_test
}  // namespace takt::sim
