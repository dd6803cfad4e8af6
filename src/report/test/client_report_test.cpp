// Reports of read, raw and write: tables of results, and their text and JSON.
#include "takt/report/states/client_report.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "sample.hpp"

namespace takt::report {
namespace client_report_test {

using namespace test;
using namespace std::chrono_literals;
using client::ReadValue;

const ClientRun kRun{"tcp://10.0.0.7:502", 16, 12500us, false};
const auto kTimeOut = fail(Code::timed_out, "tcp://10.0.0.7:502", 1000).error();
const auto kException = fail(Code::modbus_exception, "tcp://10.0.0.7:502", 2).error();

client::ReadSpec spec_of(wire::Area area, DataType type) {
    client::ReadSpec spec{.area = area, .start = 5, .count = 2};
    spec.layout.type = type;
    return spec;
}

ClientRun interrupted() {
    auto run = kRun;
    run.interrupted = true;
    return run;
}

TEST(ReadReport, ALineForEachValue) {
    const struct {
        DataType type;
        value::Value value;
        const char* line;
    } cases[] = {
        {DataType::boolean, true, "5 1\n"},
        {DataType::boolean, false, "5 0\n"},
        {DataType::int16, std::int64_t{-7}, "5 -7\n"},
        {DataType::uint64, std::numeric_limits<std::uint64_t>::max(), "5 18446744073709551615\n"},
        {DataType::float32, double{0.1F}, "5 0.1\n"},
        {DataType::float64, std::numeric_limits<double>::infinity(), "5 inf\n"},
        {DataType::string, std::string("Котёл 1"), "5 Котёл 1\n"},
        {DataType::string, std::string("\x1b[2J\nok 6\x07"), "5 \\u{1B}[2J\\nok 6\\u{07}\n"},
        {DataType::string, std::string(), "5 \n"},
    };
    for (const auto& [type, value, line] : cases)
        EXPECT_EQ(read_text(type, std::vector<ReadValue>{{5, value}}), line);
    EXPECT_EQ(read_text(DataType::int32,
                        std::vector<ReadValue>{{65532, std::int64_t{1}}, {65534, std::int64_t{2}}}),
              "65532 1\n65534 2\n");
    EXPECT_EQ(read_text(DataType::int16, {}), "");
}

TEST(ReadReport, JsonOfEachAreaAndType) {
    const struct {
        wire::Area area;
        DataType type;
        std::vector<ReadValue> values;
        const char* members;
    } cases[] = {
        {wire::Area::coil,
         DataType::int16,
         {{5, true}, {6, false}},
         R"("function":1,"start":5,"type":"bool","values":[true,false])"},
        {wire::Area::discrete_input,
         DataType::int16,
         {{5, true}},
         R"("function":2,"start":5,"type":"bool","values":[true])"},
        {wire::Area::holding_register,
         DataType::int16,
         {{5, std::int64_t{-1}}},
         R"("function":3,"start":5,"type":"int16","values":[-1])"},
        {wire::Area::input_register,
         DataType::float32,
         {{5, double{0.1F}}, {7, std::numeric_limits<double>::quiet_NaN()}},
         R"("function":4,"start":5,"type":"float","values":[0.1,null])"},
        {wire::Area::holding_register,
         DataType::string,
         {{5, std::string("a\"\n\x1b\xFF")}},
         R"("function":3,"start":5,"type":"string","values":["a\"\n\u001b)"
         "\xEF\xBF\xBD\"]"},
        {wire::Area::holding_register,
         DataType::uint64,
         {},
         R"("function":3,"start":5,"type":"uint64","values":[])"},
    };
    for (const auto& [area, type, values, members] : cases)
        EXPECT_EQ(
            read_json(english(), kRun, spec_of(area, type), values, {}).dump(),
            R"({"target":"tcp://10.0.0.7:502","unit":16,)" + std::string(members) + R"(,"time_ms":12.5})");
}

TEST(ReadReport, AnErrorComesWithTheValuesBeforeIt) {
    const std::vector<ReadValue> values{{5, std::int64_t{17}}};
    const auto spec = spec_of(wire::Area::holding_register, DataType::int16);
    for (const auto language : kLanguages) {
        const Texts texts(language);
        const auto json = read_json(texts, kRun, spec, values, std::unexpected(kException));
        EXPECT_EQ(at(json, "values").dump(), "[17]");
        EXPECT_JSON(at(json, "error", "code"), "modbus_exception");
        EXPECT_JSON(at(json, "error", "text"), texts.describe(kException));
        EXPECT_EQ(ended_text(texts, kRun, kException), texts.describe(kException));
    }
}

TEST(ReadReport, AnInterruptionTakesThePlaceOfItsError) {
    const auto spec = spec_of(wire::Area::coil, DataType::int16);
    for (const auto language : kLanguages) {
        const Texts texts(language);
        const auto json = read_json(texts, interrupted(), spec, {}, std::unexpected(kTimeOut));
        EXPECT_JSON(at(json, "error", "code"), "interrupted");
        EXPECT_JSON(at(json, "error", "text"), texts("app.client.interrupted"));
        EXPECT_EQ(ended_text(texts, interrupted(), kTimeOut), texts("app.client.interrupted"));
    }
    EXPECT_EQ(read_json(english(), interrupted(), spec, {}, {}).find("error"), nullptr)
        << "the signal came after the last response";
}

TEST(ReadReport, AHostileTargetIsEscapedInJson) {
    const ClientRun run{"tcp://\"\x1b\n", 0, {}, false};
    const auto text = read_json(english(), run, spec_of(wire::Area::coil, DataType::int16), {}, {}).dump();
    EXPECT_TRUE(text.starts_with(R"({"target":"tcp://\"\u001b\n","unit":0,)")) << text;
}

client::Written written(std::size_t items, Result<void> ended = {}) {
    return {.function = wire::Function::write_multiple_registers, .items = items, .ended = std::move(ended)};
}

TEST(WriteReport, JsonOfEachOutcome) {
    const auto refused = fail(Code::cannot_open, "tcp://10.0.0.7:502", 111).error();
    const struct {
        std::size_t items;
        std::optional<Error> error;
        const char* members;
    } cases[] = {
        {3, std::nullopt, R"("quantity":3,"outcome":"done","time_ms":12.5)"},
        {2, kException, R"("quantity":2,"outcome":"partly","wanted":3,"time_ms":12.5,"error")"},
        {0, kException, R"("quantity":0,"outcome":"refused","wanted":3,"time_ms":12.5,"error")"},
        {0, refused, R"("quantity":0,"outcome":"refused","wanted":3,"time_ms":12.5,"error")"},
        {0, kTimeOut, R"("quantity":0,"outcome":"unknown","wanted":3,"time_ms":12.5,"error")"},
    };
    for (const auto& [items, error, members] : cases) {
        const WriteRun write{500, 3, written(items, error ? std::unexpected(*error) : Result<void>())};
        const auto json = write_json(english(), kRun, write);
        EXPECT_TRUE(json.dump().starts_with(
            R"({"target":"tcp://10.0.0.7:502","unit":16,"function":16,"start":500,)" + std::string(members)))
            << json.dump();
        if (!error) continue;
        EXPECT_JSON(at(json, "error", "code"), name(error->code));
        EXPECT_JSON(at(json, "error", "text"), english().describe(*error));
    }
}

TEST(WriteReport, AnInterruptedWriteMayHaveBeenExecuted) {
    const WriteRun write{0, 1, written(0, std::unexpected(kTimeOut))};
    for (const auto language : kLanguages) {
        const Texts texts(language);
        const auto json = write_json(texts, interrupted(), write);
        EXPECT_JSON(at(json, "outcome"), "unknown");
        EXPECT_JSON(at(json, "error", "code"), "interrupted");
        EXPECT_JSON(at(json, "error", "text"), texts("app.client.write_interrupted"));
        EXPECT_EQ(write_ended_text(texts, interrupted(), kTimeOut), texts("app.client.write_interrupted"));
        EXPECT_EQ(write_ended_text(texts, kRun, kTimeOut), texts.describe(kTimeOut));
    }
}

TEST(WriteReport, TheCountsAreThoseOfConfirmedItems) {
    for (const auto language : kLanguages) {
        const Texts texts(language);
        EXPECT_EQ(write_text(texts, {500, 3, written(3)}),
                  texts("app.written", {{"count", "3"}, {"start", "500"}}));
        EXPECT_EQ(write_text(texts, {65400, 130, written(123, std::unexpected(kTimeOut))}),
                  texts("app.partly_written",
                        {{"count", "123"}, {"total", "130"}, {"start", "65400"}, {"next", "65523"}}));
        expect_complete(write_text(texts, {0, 1, written(0, std::unexpected(kTimeOut))}));
    }
}

TEST(RawReport, JsonOfRequestAndResponse) {
    const std::uint8_t request[] = {0x03, 0x01, 0xF4, 0x00, 0x02};
    const std::uint8_t response[] = {0x83, 0x02};
    EXPECT_EQ(raw_json(english(), kRun, request, Bytes(response)).dump(),
              R"({"target":"tcp://10.0.0.7:502","unit":16,"request":"03 01 F4 00 02","response":"83 02"})");
    EXPECT_EQ(raw_json(english(), kRun, request, Bytes()).dump(),
              R"({"target":"tcp://10.0.0.7:502","unit":16,"request":"03 01 F4 00 02","response":""})")
        << "to a broadcast";
    const auto json = raw_json(english(), kRun, request, std::unexpected(kTimeOut));
    EXPECT_EQ(json.find("response"), nullptr);
    EXPECT_JSON(at(json, "error", "code"), "timed_out");
    EXPECT_JSON(at(raw_json(english(), interrupted(), request, std::unexpected(kTimeOut)), "error", "code"),
                "interrupted");
}

}  // namespace client_report_test
}  // namespace takt::report
