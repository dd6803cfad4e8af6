#include <gtest/gtest.h>
#include <netdb.h>

#include <cerrno>

#include "takt/text/catalogue.hpp"

namespace takt::text {
namespace errors_test {

constexpr Code kCodes[] = {
    Code::out_of_range, Code::malformed,    Code::too_short,        Code::too_long,         Code::unsupported,
    Code::not_found,    Code::overflow,     Code::not_writable,     Code::queue_full,       Code::syntax,
    Code::cannot_open,  Code::busy,         Code::connection_lost,  Code::timed_out,        Code::io_failed,
    Code::replaced,     Code::bad_checksum, Code::modbus_exception, Code::unexpected_reply, Code::not_modbus,
    Code::misdirected,  Code::tls_failed,
};

TEST(Errors, EveryFaultOfTlsHasAText) {
    for (const auto language : kLanguages)
        for (std::size_t fault = 0; fault < kTlsFaults; ++fault) {
            const Error error{Code::tls_failed, "plc:802", {static_cast<std::int64_t>(fault)}};
            EXPECT_EQ(describe(language, error).find("tls_failed"), std::string::npos) << fault;
            EXPECT_EQ(advice(language, error).empty(), fault == 0) << fault;
        }
}

constexpr std::int64_t number(HeaderFault fault) {
    return static_cast<std::int64_t>(fault);
}

TEST(Errors, EveryCodeHasATextWithAndWithoutNumbers) {
    for (const auto language : kLanguages)
        for (const auto code : kCodes)
            for (const Error& error : {Error{code, "X", {}}, Error{code, "X", {2, 3, 9}}}) {
                const auto text = describe(language, error);
                EXPECT_TRUE(text.starts_with("X: ")) << text;
                EXPECT_EQ(text.find("error."), std::string::npos) << text;
                EXPECT_EQ(text.find('{'), std::string::npos) << text;
            }
}

TEST(Errors, SayWhatHappened) {
    struct Case {
        Error error;
        std::string_view english;
    };
    const Case cases[] = {
        {{Code::out_of_range, "", {300, 1, 247}}, "the value 300 is out of range, allowed: 1..247"},
        {{Code::out_of_range, "burst", {0}}, "burst: the value 0 is out of range"},
        {{Code::too_short, "", {2, 4}}, "too short: 2 bytes, needed: 4"},
        {{Code::queue_full, "", {64}}, "the queue is full, allowed entries: 64"},
        {{Code::timed_out, "unit 16", {100}}, "unit 16: no answer within 100 ms"},
        {{Code::timed_out, "tcp://plc", {100, 148, 300}},
         "tcp://plc: no answer within 100 ms; it came after 148 ms"},
        {{Code::modbus_exception, "", {2}}, "the device answers with exception 2: illegal data address"},
        {{Code::modbus_exception, "", {127}}, "the device answers with exception 127: not defined by Modbus"},
        {{Code::cannot_open, "/dev/ttyUSB0", {}}, "/dev/ttyUSB0: cannot be opened"},
        {{Code::cannot_open, "/dev/ttyUSB0", {EACCES}}, "/dev/ttyUSB0: cannot be opened: permission denied"},
        {{Code::connection_lost, "a:502", {ECONNRESET}},
         "a:502: the connection is lost: reset by the other end"},
        {{Code::not_modbus, "a:22", {0x5353'482D'0D00}}, "a:22: the peer does not speak Modbus TCP"},
        {{Code::not_modbus, "a:22", {0x5353'482D'0D00, 6}},
         "a:22: the peer does not speak Modbus TCP: received 53 53 48 2D 0D 00 (SSH-..)"},
        {{Code::not_modbus, "a:22", {0x5353'482D'0D00, 6, number(HeaderFault::protocol)}},
         "a:22: the peer does not speak Modbus TCP: received 53 53 48 2D 0D 00 (SSH-..), expected the "
         "protocol identifier 00 00 as bytes 3 and 4"},
        {{Code::not_modbus, "a:22", {0x0001'0000'0001, 6, number(HeaderFault::length)}},
         "a:22: the peer does not speak Modbus TCP: received 00 01 00 00 00 01 (......), expected a length "
         "of 2..254 as bytes 5 and 6"},
        {{Code::not_modbus, "a:22", {0x28B8'0000'0004'0183, 8, number(HeaderFault::off_by_one)}},
         "a:22: the length in the header of a response, bytes 5 and 6, differs by one from the response: "
         "received 28 B8 00 00 00 04 01 83 ((.......)"},
        {misdirected("tcp://plc", {Mismatch::Part::unit, 1, 5}),
         "tcp://plc: a response of unit 1 came, unit 5 was asked"},
        {misdirected("tcp://plc", {Mismatch::Part::transaction, 7, 8}),
         "tcp://plc: a response with transaction id 7 came, 8 was asked"},
        {misdirected("tcp://plc", {Mismatch::Part::length, 9, 11}),
         "tcp://plc: 9 of 11 bytes of the response came"},
        {{Code::io_failed, "x", {EFBIG}}, "x: reading or writing failed: File too large"},
    };
    for (const auto& [error, english] : cases) EXPECT_EQ(what(Language::english, error), english);
    EXPECT_EQ(what(Language::russian, {Code::cannot_open, "a:502", {ECONNREFUSED}}),
              "a:502: не удаётся открыть: в соединении отказано");
    EXPECT_EQ(what(Language::ukrainian, {Code::cannot_open, "a:502", {EAI_NONAME}}),
              "a:502: не вдається відкрити: ім'я вузла не вдається перетворити на адресу (Name or service "
              "not known)");
}

TEST(Errors, AdviseByWhatTheyAreAbout) {
    struct Case {
        Error error;
        std::string_view key;
    };
    const Case cases[] = {
        {{Code::cannot_open, "/dev/ttyUSB0", {EACCES}}, "advice.dialout"},
        {{Code::cannot_open, "0.0.0.0:502", {EACCES}}, "advice.low_port"},
        {{Code::cannot_open, "./boiler.yaml", {EACCES}}, "advice.file_rights"},
        {{Code::cannot_open, "/dev/ttyUSB0", {ENOENT}}, "advice.no_device"},
        {{Code::cannot_open, "boiler.yaml", {ENOENT}}, "advice.no_file"},
        {{Code::cannot_open, "eth7", {ENODEV}}, "advice.no_interface"},
        {{Code::cannot_open, "/dev/ttyUSB0", {ENODEV}}, "advice.no_device"},
        {{Code::cannot_open, "h:502", {ECONNREFUSED}}, "advice.refused"},
        {{Code::cannot_open, "h:502", {EAI_AGAIN}}, "advice.host_name"},
        {{Code::modbus_exception, "", {2}}, "advice.exception.2"},
        {{Code::timed_out, "", {}}, "advice.timed_out"},
        {{Code::bad_checksum, "rtu:///dev/ttyS0", {}}, "advice.bad_checksum"},
        {{Code::bad_checksum, "rtu+tcp://gateway:4001", {}}, "advice.bad_checksum.tcp"},
        {{Code::not_modbus, "a:22", {}}, "advice.not_modbus"},
        {{Code::not_modbus, "a:22", {0, 8, number(HeaderFault::off_by_one)}}, "advice.not_modbus.length"},
    };
    for (const auto& [error, key] : cases) {
        EXPECT_TRUE(has(Language::english, key)) << key;
        EXPECT_EQ(advice(Language::english, error), message(Language::english, key));
        EXPECT_EQ(describe(Language::english, error),
                  what(Language::english, error) + ". " + message(Language::english, key));
    }
    EXPECT_NE(advice(Language::english, {Code::busy, "/dev/ttyS0", {}}).find("fuser -v /dev/ttyS0"),
              std::string::npos);
    for (const Error& error : {Error{Code::malformed, "", {}}, Error{Code::modbus_exception, "", {4}},
                               Error{Code::cannot_open, "lo", {EPERM}}})
        EXPECT_EQ(advice(Language::english, error), "");
}

}  // namespace errors_test
}  // namespace takt::text
