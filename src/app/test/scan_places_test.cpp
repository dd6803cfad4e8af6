#include "takt/app/scan_places.hpp"

#include <gtest/gtest.h>

#include "takt/app/option_error.hpp"
#include "takt/app/progress.hpp"
#include "takt/model/target_url.hpp"

namespace takt::app {
namespace {

using Numbers = std::vector<std::uint32_t>;

TEST(ScanPlaces, ListsOfNumbers) {
    EXPECT_EQ(parse_numbers("--units", "1-3,16,2", 1, 247), (Numbers{1, 2, 3, 16}));
    EXPECT_EQ(parse_numbers("--units", "247", 1, 247), (Numbers{247}));
    for (const char* text : {"", ",", "1,", "3-1", "-3", "1-", "x", "0x10", "1 2", "99999999999"}) {
        const auto read = parse_numbers("--units", text, 1, 247);
        ASSERT_FALSE(read) << text;
        EXPECT_EQ(read.error().code, Code::syntax) << text;
        EXPECT_TRUE(read.error().subject.view().starts_with("--units ")) << read.error().subject.view();
    }
    const auto beyond = parse_numbers("--units", "1,300", 1, 247);
    ASSERT_FALSE(beyond);
    EXPECT_EQ(beyond.error(), fail(Code::out_of_range, "--units", 300, 1, 247).error());
    EXPECT_EQ(parse_numbers("--bauds", "50-4000000", 50, 4'000'000).error().code, Code::too_long);
}

TEST(ScanPlaces, AllSettingsOfAPortTheLikelyOnesFirst) {
    const auto places = scan_places("rtu:///dev/ttyUSB0", {});
    ASSERT_TRUE(places);
    ASSERT_EQ(places->size(), 1U);
    const auto& settings = (*places)[0].settings;
    ASSERT_EQ(settings.size(), 15U);
    EXPECT_EQ(model::settings_text(settings[0].as_line()), "19200 8E1") << "the specification's own";
    EXPECT_EQ(model::settings_text(settings[1].as_line()), "9600 8N1");
    EXPECT_EQ(settings.back().format.parity, wire::Parity::odd);
}

TEST(ScanPlaces, WhatTheTargetSaysHoldsUnlessAListSaysMore) {
    const auto said = scan_places("rtu:///dev/ttyUSB0?baud=4800&parity=odd&stop_bits=2", {});
    ASSERT_TRUE(said);
    ASSERT_EQ((*said)[0].settings.size(), 1U);
    EXPECT_EQ(model::settings_text((*said)[0].settings[0].as_line()), "4800 8O2");
    const auto listed =
        scan_places("rtu:///dev/ttyUSB0?parity=odd", {.bauds = {1200, 9600}, .stop_bits = {1, 2}});
    ASSERT_TRUE(listed);
    ASSERT_EQ((*listed)[0].settings.size(), 4U);
    EXPECT_EQ(model::settings_text((*listed)[0].settings[0].as_line()), "9600 8O1");
}

TEST(ScanPlaces, RangesOfHosts) {
    const auto hosts = [](std::string_view url) {
        std::vector<std::string> urls;
        const auto places = scan_places(url, {});
        for (const auto& place : places.value()) urls.push_back(model::url_of(place.settings[0].as_line()));
        return urls;
    };
    using Urls = std::vector<std::string>;
    EXPECT_EQ(hosts("tcp://10.0.0.254-10.0.1.1:1502"), (Urls{"tcp://10.0.0.254:1502", "tcp://10.0.0.255:1502",
                                                             "tcp://10.0.1.0:1502", "tcp://10.0.1.1:1502"}));
    EXPECT_EQ(hosts("tcp://10.0.0.8-9"), (Urls{"tcp://10.0.0.8:502", "tcp://10.0.0.9:502"}));
    EXPECT_EQ(hosts("tcp://10.0.0.9/30"), (Urls{"tcp://10.0.0.9:502", "tcp://10.0.0.10:502"}));
    EXPECT_EQ(hosts("tcp://10.0.0.9/32"), (Urls{"tcp://10.0.0.9:502"}));
    EXPECT_EQ(hosts("tcp://my-gateway:1502"), (Urls{"tcp://my-gateway:1502"}));
    EXPECT_EQ(hosts("tcp://[::1]:1502"), (Urls{"tcp://[::1]:1502"}));
    EXPECT_EQ(scan_places("tcp://10.0.0.0/8", {}).error().code, Code::out_of_range);
    for (const char* url : {"tcp://10.0.0.9-1", "tcp://10.0.0.9-256", "tcp://10.0.0.9/33", "tcp://10.0.0.9/"})
        EXPECT_EQ(scan_places(url, {}).error().code, Code::syntax) << url;
}

TEST(ScanPlaces, AUrlNamesTheSameTarget) {
    for (const char* url : {"rtu:///dev/ttyS1?baud=9600&parity=none&stop_bits=2",
                            "ascii:///dev/ttyS1?baud=9600&parity=even&stop_bits=1&data_bits=7",
                            "rtu:///dev/ttyS1?baud=9600&parity=none&stop_bits=1&rs485=rts",
                            "rtu+tcp://host:4001", "tcp://host:502"})
        EXPECT_EQ(model::url_of(line::parse_target(url).value().as_line()), url);
}

TEST(Progress, BarAndTime) {
    EXPECT_EQ(bar(0, 10, 4), "[----]");
    EXPECT_EQ(bar(5, 10, 4), "[##--]");
    EXPECT_EQ(bar(12, 10, 4), "[####]");
    EXPECT_EQ(bar(0, 0, 4), "[----]");
    EXPECT_EQ(rough_time(std::chrono::seconds(59)), "59 s");
    EXPECT_EQ(rough_time(std::chrono::seconds(185)), "3 min 5 s");
    EXPECT_EQ(rough_time(std::chrono::minutes(130)), "2 h 10 min");
}

TEST(OptionError, KnownWordsAreTranslatedAndOthersKept) {
    const Texts texts(text::Language::russian);
    const auto told = option_error(texts, "--unit: Value 256 not in range 0 to 255");
    EXPECT_NE(told.find("256"), std::string::npos);
    EXPECT_NE(told.find("0..255"), std::string::npos);
    EXPECT_NE(told.find("допустимо"), std::string::npos);
    EXPECT_EQ(option_error(texts, "words: nobody knows"), "words: nobody knows");
}

}  // namespace
}  // namespace takt::app
