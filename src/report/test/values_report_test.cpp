#include "takt/report/values_report.hpp"

#include <gtest/gtest.h>

#include "host_sample.hpp"
#include "takt/report/text_table.hpp"

namespace takt::report {
namespace {

using namespace test;
using namespace std::chrono_literals;

host::Snapshot snapshot() {
    auto made = snapshot_of(plant());
    made.values[slot_of("Level").value] = {
        .value = std::int64_t{17}, .quality = value::Quality::good, .good_at = made.t - 1500ms};
    made.values[slot_of("Speed").value] = {.value = 2.5,
                                           .quality = value::Quality::bad,
                                           .reason = value::Reason::timeout,
                                           .good_at = made.t - 60s};
    made.values[slot_of("Pump").value].reason = value::Reason::ok;
    made.values[slot_of("Tag").value] = {
        .value = std::string("T-1"), .quality = value::Quality::good, .good_at = made.t + 1s};
    made.values[slot_of("go").value] = {.value = true, .quality = value::Quality::good, .good_at = made.t};
    return made;
}

/// The row of that name, without the blanks between its columns.
std::string row_of(const std::vector<std::string>& lines, const std::string& name) {
    for (const auto& line : lines) {
        if (line.find(name) == std::string::npos) continue;
        std::string row;
        for (const char c : line)
            if (c != ' ' || !row.ends_with(' ')) row += c;
        return row;
    }
    return {};
}

TEST(ValuesReport, ARowForEachValueInEveryLanguage) {
    for (const auto language : kLanguages) {
        const Texts texts(language);
        const auto lines = values_table(texts, snapshot(), {24, 100});
        ASSERT_EQ(lines.size(), 6U);
        for (const auto& line : lines) expect_complete(line);
        expect_contains(lines[0], texts("app.variable"));
        EXPECT_EQ(row_of(lines, "Level"), "Котёл Level 17 мм 1500 ms");
        EXPECT_EQ(row_of(lines, "Speed"),
                  "Котёл Speed 2.5 60000 ms " + texts.quality(value::Quality::bad, value::Reason::timeout));
        EXPECT_EQ(row_of(lines, "Pump"),
                  "Котёл Pump – " + texts.quality(value::Quality::never_read, value::Reason::ok))
            << "never read";
        EXPECT_EQ(row_of(lines, "Tag"), "Котёл Tag T-1 0.00 ms") << "an age is never negative";
        EXPECT_EQ(row_of(lines, "go"), " go true") << "a local has no device and no age";
    }
}

TEST(ValuesReport, RowsBeyondTheScreenAreCounted) {
    std::string yaml = kPlant;
    for (int i = 0; i < 95; ++i) yaml += "  - {name: local" + std::to_string(i) + ", type: bool}\n";
    const auto many = snapshot_of(configuration_of(project_of(yaml)));
    const struct {
        std::size_t rows, lines;
        const char* hidden;  // nullptr: none
    } cases[] = {{24, 22, "80"}, {103, 101, nullptr}, {102, 100, "2"}, {1, 4, "98"}, {0, 4, "98"}};
    for (const auto& [rows, count, hidden] : cases) {
        const auto lines = values_table(english(), many, {rows, 80});
        EXPECT_EQ(lines.size(), count) << rows << " rows";
        if (hidden)
            EXPECT_EQ(lines.back(), english()("app.more_rows", {{"count", hidden}}));
        else
            EXPECT_NE(lines.back().find("Tag"), std::string::npos) << "the last value";
    }
}

TEST(ValuesReport, ATextOfADeviceIsEscaped) {
    auto hostile = snapshot();
    hostile.values[slot_of("Tag").value].value = kHostile;
    expect_contains(row_of(values_table(english(), hostile, {24, 100}), "Tag"), kHostileLine);
}

TEST(ValuesReport, LinesFitTheScreen) {
    auto wide = snapshot();
    wide.values[slot_of("Tag").value].value = std::string(300, 'x');
    wide.values[slot_of("Speed").value].quality = value::Quality::uncertain;
    for (const auto& line : values_table(english(), wide, {24, 400})) EXPECT_LT(display_width(line), 400U);
}

}  // namespace
}  // namespace takt::report
