#include "takt/report/drawing/texts.hpp"

#include <gtest/gtest.h>

#include <cerrno>

#include "sample.hpp"
#include "takt/bus/transaction.hpp"
#include "takt/text/catalogue.hpp"

namespace takt::report {
namespace texts_test {

using namespace test;

TEST(Texts, FillsPlaceholders) {
    EXPECT_EQ(
        english()("app.checked", {{"file", "a.yaml"}, {"errors", "1"}, {"warnings", "0"}, {"notes", "2"}}),
        "a.yaml: errors: 1, warnings: 0, notes: 2");
    EXPECT_EQ(
        english()("app.checked", {{"file", "{errors}"}, {"errors", "1"}, {"warnings", "0"}, {"notes", "2"}}),
        "{errors}: errors: 1, warnings: 0, notes: 2")
        << "an argument is not filled again";
}

TEST(Texts, AnUnknownCodeIsItsOwnText) {
    EXPECT_EQ(english()("no.such.code"), "no.such.code");
}

TEST(Texts, TheLogNamesEachFailureOfAnExchange) {
    for (auto i = static_cast<int>(bus::Status::exception); i <= static_cast<int>(bus::Status::cancelled);
         ++i)
        for (const auto language : kLanguages) {
            const auto code = "log.why." + std::string(bus::name(static_cast<bus::Status>(i)));
            EXPECT_NE(Texts(language)(code), code);
        }
}

TEST(Texts, EachLanguageHasItsOwn) {
    EXPECT_NE(english()("app.error"), Texts(text::Language::russian)("app.error"));
    EXPECT_EQ(Texts(text::Language::ukrainian).language(), text::Language::ukrainian);
}

TEST(Texts, FindingsWithFieldValueAndLimits) {
    model::Finding finding;
    finding.code = "field.range";
    finding.path = "lines[0].baud";
    finding.value = "7";
    finding.allowed = "50..4000000";
    for (const auto language : kLanguages) {
        const auto message = Texts(language).message(finding);
        expect_contains(message, "7");
        expect_contains(message, "50..4000000");
        EXPECT_EQ(message.find('{'), std::string::npos) << message;
    }
    finding.path = "baud";
    EXPECT_EQ(english().message(finding).find('{'), std::string::npos) << "a path of one part";
}

TEST(Texts, ArgumentsOfAFindingHoldBeforeItsValue) {
    model::Finding finding;
    finding.code = "no.such.code";
    finding.value = "of the value";
    finding.arguments = {{"value", "of the arguments"}};
    EXPECT_LT(english().message(finding).find("of the arguments"), english().message(finding).size());
}

TEST(Texts, OnlyTimesOfAFindingHaveTheLocalUnit) {
    const Texts russian(text::Language::russian);
    model::Finding finding;
    finding.code = "guarantee.late";
    finding.arguments = {{"variable", "2 min"},
                         {"device", "500 h"},
                         {"response", "117.721 ms"},
                         {"over", "17.721 ms"},
                         {"deadline", "100 ms"}};
    const auto message = russian.message(finding);
    for (const auto* const part : {"2 min", "500 h", "117.721 мс", "17.721 мс", "100 мс"})
        expect_contains(message, part);
    finding = {};
    finding.code = "field.out_of_range";
    finding.path = "lines[0].baud";
    finding.value = "500 h";
    finding.allowed = "2 min";
    expect_contains(russian.message(finding), "500 h");
    finding.code = "guarantee.response_measured";
    finding.arguments = {
        {"line", "1 s"}, {"devices", "5 ms"}, {"count", "300"}, {"one_in", "100"}, {"longest", "7.5 ms"}};
    for (const auto* const part : {"1 s", "5 ms", "7.5 мс"}) expect_contains(russian.message(finding), part);
}

TEST(Texts, AdviceOnlyWhereTheCodeHasIt) {
    model::Finding finding;
    finding.code = "no.such.code";
    EXPECT_EQ(english().advice(finding), "");
    for (const auto code : text::codes(text::Language::english)) {
        if (!code.ends_with(".advice")) continue;
        finding.code = code.substr(0, code.rfind('.'));
        for (const auto language : kLanguages) EXPECT_NE(Texts(language).advice(finding), "") << code;
    }
}

TEST(Texts, QualityAndReason) {
    using value::Quality;
    using value::Reason;
    for (const auto language : kLanguages) {
        const Texts texts(language);
        EXPECT_EQ(texts.quality(Quality::good, Reason::ok), texts("app.quality.good"));
        for (const auto quality : {Quality::never_read, Quality::uncertain, Quality::bad})
            for (const auto reason :
                 {Reason::timeout, Reason::bad_checksum, Reason::unexpected_reply, Reason::link_lost,
                  Reason::switched_off, Reason::not_answering, Reason::differs, Reason::superseded,
                  Reason::stale, Reason::never_connected})
                expect_complete(texts.quality(quality, reason));
        for (const int code : {2, 0, 200})
            expect_contains(
                texts.quality(Quality::bad, value::exception_reason(static_cast<std::uint8_t>(code))),
                texts("app.reason.exception", {{"code", std::to_string(code)}}));
    }
}

TEST(Texts, FilesThatAreNotWritten) {
    for (const auto language : kLanguages) {
        const Texts texts(language);
        const auto exists = fail(Code::cannot_open, "a.yaml", EEXIST).error();
        EXPECT_EQ(unwritten_text(texts, "a.yaml", exists), texts("app.convert.exists", {{"file", "a.yaml"}}));
        const auto full = fail(Code::io_failed, "a.yaml", ENOSPC).error();
        EXPECT_EQ(unwritten_text(texts, "a.yaml", full), texts.describe(full));
    }
}

TEST(Texts, SentencesThatGoOn) {
    EXPECT_EQ(without_stop("A sentence."), "A sentence");
    EXPECT_EQ(without_stop("A sentence"), "A sentence");
    EXPECT_EQ(without_stop("One. Two."), "One. Two");
    EXPECT_EQ(without_stop(""), "");
}

}  // namespace texts_test
}  // namespace takt::report
