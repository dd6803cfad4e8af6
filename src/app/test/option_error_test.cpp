#include "options/option_error.hpp"

#include <gtest/gtest.h>

#include <array>
#include <string_view>
#include <utility>

namespace takt::app {
namespace option_error_test {

TEST(OptionError, NamesAndValuesAreTakenFromTheWordsOfTheParser) {
    EXPECT_EQ(option_error("START is required"), (OptionError{"app.option.required", {{"option", "START"}}}));
    EXPECT_EQ(option_error("--fill excludes FILE"),
              (OptionError{"app.option.excludes", {{"option", "--fill"}, {"other", "FILE"}}}));
    EXPECT_EQ(option_error("--unit: 1 required 0..255 missing"),
              (OptionError{"app.option.no_value", {{"option", "--unit"}}}));
}

TEST(OptionError, ATargetIsNamedWithTheReason) {
    const Error port{Code::out_of_range, "port", {99999, 1, 65535}};
    EXPECT_EQ(
        option_error_text(Texts(text::Language::english), target_error("TARGET", "tcp://h:99999", port)),
        "TARGET tcp://h:99999: port: the value 99999 is out of range, allowed: 1..65535");
    const Error scheme{Code::syntax, "h:502 → tcp://h:502", {}};
    EXPECT_EQ(option_error_text(Texts(text::Language::english), target_error("--target", "h:502", scheme)),
              "--target h:502: 'h:502' is not valid, correct form: tcp://h:502");
}

TEST(OptionError, AnOptionOfOtherToolsIsNamed) {
    constexpr std::array<std::string_view, 4> kOptions{"--version", "--for", "--unit", "--realtime"};
    for (const auto& [name, meant] : {std::pair{"--duration", "--for"},
                                      {"--time", "--for"},
                                      {"--slave", "--unit"},
                                      {"--slave-id", "--unit"},
                                      {"--Unit-ID", "--unit"},
                                      {"--versoin", "--version"}})
        EXPECT_EQ(unknown_option(name, kOptions),
                  (OptionError{"app.option.unknown", {{"value", name}, {"nearest", meant}}}));
    constexpr std::array<std::string_view, 1> kOthers{"--version"};
    EXPECT_EQ(unknown_option("--seconds", kOthers).code, "app.option.unknown.unlike");
}

TEST(OptionError, AnOptionLeadsToTheArgumentTheTargetOrTheProject) {
    constexpr std::array<std::string_view, 7> kRead{"TARGET", "AREA",      "START",     "COUNT",
                                                    "--unit", "--timeout", "--attempts"};
    constexpr std::array<std::string_view, 2> kScan{"TARGET", "--parities"};
    constexpr std::array<std::string_view, 5> kServe{"FILE", "--fill", "--fault", "--port", "--lang"};
    const struct {
        std::span<const std::string_view> options;
        const char* name;
        const char* code;
        const char* meant;
    } cases[] = {
        {kRead, "--register", "app.option.unknown.argument", "START"},
        {kRead, "--count", "app.option.unknown.argument", "COUNT"},
        {kRead, "--fc", "app.option.unknown.argument", "AREA"},
        {kRead, "--retries", "app.option.unknown", "--attempts"},
        {kRead, "--address", "app.option.unknown.address", "--address"},
        {kRead, "--baud", "app.option.unknown.target",
         "rtu:///dev/ttyUSB0?baud=19200&parity=even&stop_bits=1"},
        {kRead, "--host", "app.option.unknown.target", "tcp://host:502"},
        {kScan, "--parity", "app.option.unknown", "--parities"},
        {kServe, "--delay", "app.option.unknown", "--fault"},
        {kServe, "--baudrate", "app.option.unknown.target",
         "rtu:///dev/ttyUSB0?baud=19200&parity=even&stop_bits=1"},
        {kServe, "--range", "app.option.unknown.key", "servers[].units[].banks[].items"},
        {kServe, "--read-only", "app.option.unknown.key", "servers[].units[].banks[].read_only"},
        {kServe, "--limit", "app.option.unknown.key", "servers[].units[].limits"},
        {kServe, "--overlay", "app.option.unknown.key", "servers[].units[].banks[].overlay"},
        {kServe, "--object", "app.option.unknown.key", "servers[].units[].identification"},
        {kServe, "--server-id", "app.option.unknown.key", "servers[].units[].server_id"},
        {kServe, "--file", "app.option.unknown.key", "servers[].units[].files"},
        {kServe, "--fifo", "app.option.unknown.key", "servers[].units[].fifos"},
        {kServe, "--exception-coils", "app.option.unknown.key", "servers[].units[].exception_coils"},
        {kServe, "--allow-restart", "app.option.unknown.key", "servers[].units[].restart"},
        {kServe, "--allow-listen-only", "app.option.unknown.key", "servers[].units[].listen_only"},
        {kServe, "--retain", "app.option.unknown.key", "servers[].units[].banks[].retain"},
        {kServe, "--state", "app.option.unknown.key", "servers[].units[].state"},
        {kServe, "--durability", "app.option.unknown.key", "servers[].units[].durability"},
    };
    for (const auto& [options, name, code, meant] : cases) {
        const auto error = unknown_option(name, options);
        EXPECT_EQ(error.code, code) << name;
        EXPECT_EQ(error.arguments.back().second, meant) << name;
    }
}

TEST(OptionError, OtherWordsAreKept) {
    EXPECT_EQ(option_error("words: unknown"),
              (OptionError{"app.option.other", {{"words", "words: unknown"}}}));
}

}  // namespace option_error_test
}  // namespace takt::app
