#include "takt/report/plans/table_report.hpp"

#include <gtest/gtest.h>

#include "sample.hpp"
#include "takt/plan/plan.hpp"
#include "takt/poll/line_poller.hpp"
#include "takt/table/build.hpp"

namespace takt::report {
namespace table_report_test {

using namespace test;
using namespace std::chrono_literals;

table::Image image_of(const model::Project& project, bool names = true) {
    table::BuildOptions options{.names = names};
    for (const auto& line : project.lines) options.lines.push_back(poll::line_config(project, line));
    return table::build(project, plan::make_plan(project), options).value();
}

table::OwenTable owen_sample() {
    table::OwenTable made;
    made.places = 40;
    made.masters = {{.framing = 1,
                     .parity = 2,
                     .data_bits = 7,
                     .stop_bits = 1,
                     .baud = 19200,
                     .request_gap_us = 12000,
                     .device_count = 1}};
    made.devices = {{.unit = 16,
                     .orders = 1,
                     .period_ms = 500,
                     .timeout_ms = 100,
                     .attempts = 3,
                     .status = 7,
                     .entry_count = 3}};
    made.entries = {{.type_and_bit = table::OwenEntry::kDoubleWord,
                     .read = 3,
                     .write = 16,
                     .flags = 5,
                     .quantity = 2,
                     .start = 0,
                     .data = 10},
                    {.type_and_bit = 0x30,
                     .read = 1,
                     .flags = 1,
                     .quantity = 1,
                     .start = 3,
                     .data = 14,
                     .period_ms = 1000},
                    {.type_and_bit = table::OwenEntry::kWord,
                     .write = 6,
                     .quantity = 1,
                     .start = 9,
                     .data = 15,
                     .write_trigger = 1}};
    return made;
}

TEST(TableReport, ATableInEveryLanguage) {
    const auto image = image_of(project_of(kBoiler));
    const auto view = table::View::open(image).value();
    for (const auto language : kLanguages) {
        const Texts texts(language);
        const auto text = table_text(texts, view);
        expect_complete(text);
        expect_contains(text, "rs485-1 (rtu, 19200 bit/s)\n");
        expect_contains(text, "Supply@");
        expect_contains(text, "Котёл");
        expect_contains(text, texts("app.table.entry"));
        expect_contains(text, texts("app.when.change"));
        EXPECT_EQ(count_of(text, "  0x0"), view.entry_count());
    }
}

TEST(TableReport, WithoutNamesItemsAreNumbered) {
    const auto image = image_of(project_of(kBoiler), false);
    const auto view = table::View::open(image).value();
    expect_contains(table_text(english(), view), "item");
    EXPECT_EQ(table_text(english(), view).find("Supply"), std::string::npos);
    EXPECT_JSON(at(table_json(view), "lines", 0, "name"), "");
}

TEST(TableReport, JsonOfLinesDevicesAndEntries) {
    const auto image = image_of(project_of(kBoiler));
    const auto view = table::View::open(image).value();
    const auto json = table_json(view);
    EXPECT_JSON(at(json, "format"), "takt");
    EXPECT_JSON(at(json, "length"), static_cast<std::uint32_t>(image.size()));
    const auto& line = at(json, "lines", 0);
    EXPECT_JSON(at(line, "transport"), "serial");
    EXPECT_JSON(at(line, "baud"), 19200U);
    const auto& device = at(line, "devices", 0);
    EXPECT_JSON(at(device, "unit"), 16U);
    EXPECT_JSON(at(device, "period_ms"), 500.0);
    EXPECT_JSON(at(device, "status"), file::Json());
    ASSERT_EQ(size_of(at(device, "entries")), view.entry_count());
    const auto& first = at(device, "entries", 1);
    EXPECT_JSON(at(first, "function"), 3);
    EXPECT_JSON(at(first, "write_function"), file::Json());
    EXPECT_JSON(at(first, "quantity"), 6U);
    EXPECT_EQ(at(first, "variables").dump(), R"(["Supply","Return","Setpoint"])");
    EXPECT_JSON(at(first, "period_ms"), 500.0);
}

TEST(TableReport, JsonOfItems) {
    const auto image = image_of(project_of(kBoiler));
    const auto json = table_json(table::View::open(image).value());
    const auto& items = at(json, "items");
    ASSERT_EQ(size_of(items), 7U) << "six variables and a local";
    std::size_t locals = 0;
    for (std::size_t i = 0; i < 7; ++i) {
        const auto& item = at(items, i);
        if (at(item, "device") == file::Json()) {
            ++locals;
            EXPECT_EQ(item.find("area"), nullptr) << "a local has no address";
        } else if (at(item, "name") == file::Json("Pump")) {
            EXPECT_JSON(at(item, "type"), "bool");
            EXPECT_JSON(at(item, "area"), "coil");
            EXPECT_JSON(at(item, "start"), 3U);
            EXPECT_NE(at(item, "write_place"), file::Json());
        } else if (at(item, "name") == file::Json("Return")) {
            EXPECT_JSON(at(item, "write_place"), file::Json());
        }
    }
    EXPECT_EQ(locals, 1U);
}

TEST(TableReport, TheTableOfAController) {
    const auto table = owen_sample();
    const auto image = table::write_owen(table);
    for (const auto language : kLanguages) {
        const Texts texts(language);
        const auto text = table_text(texts, table, image);
        expect_complete(text);
        expect_contains(text, "ascii, 19200 bit/s\n");
        expect_contains(text, "double word  0x03+0x10 0 × 2");
        expect_contains(text, "bit 3");
        expect_contains(text, texts.duration(1s));
        expect_contains(text, "– / 1");
    }
}

TEST(TableReport, JsonOfTheTableOfAController) {
    const auto table = owen_sample();
    const auto image = table::write_owen(table);
    const auto json = table_json(table, image);
    EXPECT_JSON(at(json, "format"), "owen-kc1");
    EXPECT_JSON(at(json, "places"), 40U);
    const auto& line = at(json, "lines", 0);
    EXPECT_JSON(at(line, "parity"), "odd");
    EXPECT_JSON(at(line, "request_gap_us"), 12000U);
    const auto& device = at(line, "devices", 0);
    EXPECT_JSON(at(device, "status"), 7U);
    EXPECT_JSON(at(device, "poll_enable"), file::Json());
    EXPECT_JSON(at(device, "high_byte_first"), true);
    EXPECT_JSON(at(device, "high_register_first"), false);
    const auto& entries = at(device, "entries");
    EXPECT_JSON(at(entries, 0, "bit"), file::Json());
    EXPECT_JSON(at(entries, 0, "period_ms"), 500U) << "that of the device";
    EXPECT_JSON(at(entries, 1, "bit"), 3);
    EXPECT_JSON(at(entries, 1, "period_ms"), 1000U);
    EXPECT_JSON(at(entries, 2, "function"), file::Json());
    EXPECT_JSON(at(entries, 2, "period_ms"), file::Json()) << "it is not polled";
    EXPECT_JSON(at(entries, 2, "write_trigger"), 1U);
}

TEST(TableReport, AnEmptyTableOfAController) {
    const table::OwenTable empty;
    const auto image = table::write_owen(empty);
    EXPECT_EQ(count_of(table_text(english(), empty, image), "\n"), 1U) << "its heading alone";
    EXPECT_EQ(at(table_json(empty, image), "lines").dump(), "[]");
}

TEST(TableReport, WhyAFileIsNoTable) {
    const struct {
        Error error;
        const char* code;
        bool advice;
    } cases[] = {
        {fail(Code::malformed, "magic").error(), "app.table.foreign", false},
        {fail(Code::unsupported, "version", 7, 2).error(), "app.table.newer", true},
        {fail(Code::unsupported, "version", 1, 2).error(), "app.table.older", true},
        {fail(Code::too_short, "x", 10, 64).error(), "app.table.truncated", true},
        {fail(Code::too_long, "x", 100, 64).error(), "app.table.followed", true},
        {fail(Code::bad_checksum, "x").error(), "app.table.corrupt", true},
        {fail(Code::malformed, "entry", 3).error(), "app.table.inconsistent", true},
    };
    for (const auto language : kLanguages) {
        const Texts texts(language);
        for (const auto& [error, code, advice] : cases) {
            const auto text = table_error_text(texts, "a.table", error);
            expect_complete(text);
            EXPECT_EQ(count_of(text, "\n"), advice ? 2U : 1U) << code;
            const auto what = texts(code, {{"file", "a.table"}});
            EXPECT_TRUE(text.starts_with(what.substr(0, what.find('{')))) << text;
        }
    }
}

TEST(TableReport, BytesOfEveryErrorOfTheReader) {
    const auto image = image_of(project_of(kBoiler));
    for (const std::size_t size : {std::size_t{0}, std::size_t{4}, image.size() - 1}) {
        const auto opened = table::View::open(Bytes(image.data(), size));
        ASSERT_FALSE(opened);
        expect_complete(table_error_text(english(), "cut.table", opened.error()));
    }
}

}  // namespace table_report_test
}  // namespace takt::report
