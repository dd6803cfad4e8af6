// The names of a project for the exchanges of a line.
#include "takt/report/times/heard_names.hpp"

#include <gtest/gtest.h>

#include <string>

#include "hex.hpp"
#include "takt/host/project_file.hpp"

namespace takt::report {
namespace heard_names_test {

using capture::Outcome;

constexpr const char* kProject = R"(takt: 1
lines:
  - {name: net, transport: tcp, host: 127.0.0.1, devices: [{name: N, address: 1, variables: []}]}
  - name: other
    transport: serial
    port: /dev/ttyS0
    devices: [{name: Other, address: 1, variables: []}]
  - name: line
    transport: serial
    port: /dev/ttyS1
    devices:
      - name: Boiler
        address: 1
        variables:
          - {name: Flow, type: float, register: 2, read: 0x03, write: 0x10, unit: m3/h,
             high_register_first: true}
          - {name: Level, type: int16, register: 1, read: 0x03, scale: 0.1}
          - {name: Pump, type: bool, coil: 17, read: 0x01, write: 0x05}
          - {name: Alarm, type: bool, register: 1, bit: 2, read: 0x04}
)";

class Names : public testing::Test {
protected:
    Names() : loaded_(host::load_project_text("test", kProject)) { EXPECT_FALSE(loaded_.has_errors()); }

    [[nodiscard]] std::string values(std::string_view request, std::string_view response,
                                     Outcome outcome = Outcome::answered) const {
        const HeardNames names(loaded_.project, "/dev/ttyS1");
        capture::SeenRequest seen{.unit = 1};
        seen.pdu.assign(takt::test::from_hex(request));
        const auto bytes = takt::test::from_hex(response);
        std::string text;
        for (const auto& value : names.values({.request = seen, .outcome = outcome, .response = bytes}))
            text += value.variable->name + "=" + value.text + " ";
        return text;
    }
    host::LoadedProject loaded_;
};

TEST_F(Names, AreThoseOfTheLineWithThePort) {
    EXPECT_EQ(HeardNames(loaded_.project, "/dev/ttyS1").device(1)->name, "Boiler");
    EXPECT_EQ(HeardNames(loaded_.project, "/dev/ttyS9").device(1)->name, "Other");
    EXPECT_EQ(HeardNames(loaded_.project, "/dev/ttyS0", "line").device(1)->name, "Boiler") << "its name";
    EXPECT_EQ(HeardNames(loaded_.project, "a.pcapng", "net").device(1)->name, "Other") << "Modbus TCP";
    EXPECT_EQ(HeardNames(loaded_.project, "/dev/ttyS1").device(2), nullptr);
    EXPECT_FALSE(HeardNames().has_line());
    EXPECT_FALSE(HeardNames(model::Project{}, "x").has_line());
}

TEST_F(Names, OfReadValues) {
    EXPECT_EQ(values("03 0001 0003", "03 06 0019 3F800000"), "Flow=1 m3/h Level=2.5 ");
    EXPECT_EQ(values("03 0002 0001", "03 02 3F80"), "") << "a part of the value";
    EXPECT_EQ(values("01 0010 0003", "01 01 02"), "Pump=true ");
    EXPECT_EQ(values("04 0001 0001", "04 02 0004"), "Alarm=true ");
    EXPECT_EQ(values("03 0001 0001", "83 02", Outcome::exception), "");
    EXPECT_EQ(values("03 0001 0001", "03 04 00000000"), "") << "it does not answer the request";
}

TEST_F(Names, OfWrittenValues) {
    EXPECT_EQ(values("05 0011 FF00", "05 0011 FF00"), "Pump=true ");
    EXPECT_EQ(values("0F 0010 0003 01 02", "0F 0010 0003"), "Pump=true ");
    EXPECT_EQ(values("06 0001 000A", "06 0001 000A"), "Level=1 ");
    EXPECT_EQ(values("10 0002 0002 04 3F800000", "10 0002 0002"), "Flow=1 m3/h ");
    EXPECT_EQ(values("16 0001 0001 0001", "16 0001 0001 0001"), "");
    EXPECT_EQ(values("17 0001 0001 0002 0002 04 00000000", "17 02 0019"), "Level=2.5 ");
    EXPECT_EQ(values("07", "07 55"), "");
}

}  // namespace heard_names_test
}  // namespace takt::report
