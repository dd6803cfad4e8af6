// No English is left in the words of traffic for a reader of another language.
#include "takt/report/states/traffic_text.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include "hex.hpp"
#include "takt/text/frame_text.hpp"
#include "takt/wire/frame_words.hpp"

namespace takt::report {
namespace traffic_text_test {

using namespace std::chrono_literals;
using text::frame_text;
using text::Language;

/// The first word of Latin letters; names in quotes and hexadecimal digits are none.
std::string english_word(std::string_view text) {
    std::string word;
    for (bool quoted = false; const char c : text) {
        if (c == '"') quoted = !quoted;
        if (!quoted && c >= 'a' && c <= 'z') {
            word += c;
        } else if (word.size() > 1) {
            return word;
        } else {
            word.clear();
        }
    }
    return word.size() > 1 ? word : "";
}

/// The words of requests and responses of every function, sub-function, exception and error.
std::vector<std::string> every_words() {
    std::vector<std::string> all;
    const auto request = [&](std::vector<std::uint8_t> pdu) {
        all.push_back(wire::describe_request(UnitId{16}, pdu));
    };
    const auto response = [&](std::vector<std::uint8_t> pdu) {
        all.push_back(wire::describe_response(UnitId{16}, pdu));
    };
    for (unsigned code = 0; code < 0x80; ++code) {
        const auto function = static_cast<std::uint8_t>(code);
        request({function});
        request({function, 0, 1, 0xFF, 0});
        request({function, 0, 1, 0, 1, 0, 1, 0, 1, 0, 1, 0, 1});
        response({function, 2, 0, 1});
        response({function, 0, 1, 0, 1});
        for (std::uint8_t exception = 0; exception < 13; ++exception)
            response({static_cast<std::uint8_t>(function | 0x80), exception});
    }
    for (std::uint8_t sub = 0; sub < 22; ++sub) request({8, 0, sub, 0, 0});
    for (std::uint8_t code = 0; code < 6; ++code) request({0x2B, 0x0E, code, 0});
    for (const auto* pdu :
         {"030000007E", "05 00AC FF00", "05 00AC 0000", "0F 0013 000A 02 CD01", "10 0001 0002 04 000A 0102",
          "14 0E 06 0004 0001 0002 06 0003 0009 0001", "15 0D 06 0004 0007 0003 06AF 04BE 100D",
          "16 0004 00F2 0025", "17 0003 0006 000E 0003 06 00FF 00FF 00FF", "18 04DE", "2B 0D 01 02"})
        request(test::from_hex(pdu));
    for (const auto* pdu : {"01 01 05", "03 04 0000 3F80", "07 6D", "0B FFFF 0108",
                            "0C 08 0000 0108 0121 20 00", "0F 0013 000A", "14 0A 05 06 0DFE 0020 03 06 33CD",
                            "15 09 06 0004 0007 0001 06AF", "18 0006 0002 01B8 1284", "18 0002 0000",
                            "2B 0E 01 01 FF 02 02 00 02 4142 01 02 430A", "2B 0E 01 01 00 00 00", "2B 0D 07"})
        response(test::from_hex(pdu));
    const wire::Request read = wire::ReadRequest{wire::Function::read_holding_registers, {500}, 2};
    all.push_back(wire::describe_response(UnitId{16}, test::from_hex("04 04 0000 3F80"), &read));
    return all;
}

TEST(TrafficText, HasNoEnglishWords) {
    EXPECT_EQ(english_word("0x6D \"on\" 04 FF"), "");
    EXPECT_EQ(english_word("адрес 16 read"), "read");
    for (const auto language : {Language::russian, Language::ukrainian}) {
        for (const auto& words : every_words())
            EXPECT_EQ(english_word(frame_text(language, words)), "") << words;
        const Texts texts(language);
        for (const auto incident :
             {wire::Incident::no_response, wire::Incident::late_response, wire::Incident::surplus_response,
              wire::Incident::connected, wire::Incident::disconnected})
            EXPECT_EQ(english_word(incident_text(texts, incident, 5ms, {})), "");
        for (const auto incident : {wire::Incident::no_response, wire::Incident::surplus_response})
            for (const auto part : {Mismatch::Part::unit, Mismatch::Part::function,
                                    Mismatch::Part::transaction, Mismatch::Part::length})
                EXPECT_EQ(english_word(incident_text(texts, incident, 5ms, {{part, 1, 5}})), "");
        for (int fault = 1; fault <= static_cast<int>(wire::FrameFault::too_slow); ++fault)
            EXPECT_EQ(english_word(fault_text(texts, static_cast<wire::FrameFault>(fault))), "") << fault;
    }
}

TEST(TrafficText, IsInTheLanguageOfTheReader) {
    const struct {
        std::string_view words;
        std::string_view russian;
    } cases[] = {
        {"unit 16 read holding registers 0..9", "адрес 16 чтение регистров хранения 0..9"},
        {"unit 16 read coils 0..1 → 2 values: 0 1",
         "адрес 16 чтение дискретных выходов 0..1 → 2 значения: 0 1"},
        {"unit 1 write single coil 5 = on", "адрес 1 запись дискретного выхода 5 = вкл."},
        {"unit 1 read/write multiple registers read 1, write 2 = 3",
         "адрес 1 чтение и запись регистров чтение 1, запись 2 = 3"},
        {"unit 1 read coils 0 → exception 2 illegal data address",
         "адрес 1 чтение дискретных выходов 0 → исключение 2 недопустимый адрес данных"},
        {"unit 2 write single register (too short, 5 of 6 bytes) 06 00",
         "адрес 2 запись регистра (слишком коротко, 5 из 6 байт) 06 00"},
        {"unit 1 → 0 \"read on \", 1 \"X", "адрес 1 → 0 \"read on \", 1 \"X"},
        {"readers on-line, 1 value: 5", "readers вкл.-line, 1 значение: 5"},
        {"", ""},
    };
    for (const auto& [words, russian] : cases) {
        EXPECT_EQ(frame_text(Language::russian, words), russian);
        EXPECT_EQ(frame_text(Language::english, words), words);
    }
}

TEST(TrafficText, IncidentsHaveTheirTimes) {
    const Texts english(Language::english);
    const Texts russian(Language::russian);
    EXPECT_EQ(incident_text(english, wire::Incident::no_response, 500ms, {}), "no response within 500 ms");
    EXPECT_EQ(incident_text(english, wire::Incident::late_response, 230ms, {}),
              "late response: late by 230 ms");
    EXPECT_EQ(incident_text(russian, wire::Incident::late_response, 230ms, {}),
              "поздний ответ: опоздал на 230 мс");
    EXPECT_EQ(incident_text(english, wire::Incident::no_response, 500ms, {{Mismatch::Part::length, 6, 9}}),
              "no response within 500 ms: 6 of 9 bytes of the response came");
    const auto surplus = [&](Mismatch::Part part) {
        return incident_text(english, wire::Incident::surplus_response, {}, Mismatch{part, 1, 5});
    };
    EXPECT_EQ(incident_text(english, wire::Incident::surplus_response, {}, {}), "surplus response");
    EXPECT_EQ(surplus(Mismatch::Part::unit), "surplus response: a response of unit 1 came, unit 5 was asked");
    EXPECT_EQ(surplus(Mismatch::Part::function),
              "surplus response: a response to function 1 came, function 5 was asked");
    EXPECT_EQ(surplus(Mismatch::Part::transaction),
              "surplus response: a response with transaction id 1 came, 5 was asked");
    EXPECT_EQ(incident_text(english, wire::Incident::disconnected, {}, {}), "disconnected");
    EXPECT_EQ(fault_text(english, wire::FrameFault::checksum), "checksum wrong");
}

}  // namespace traffic_text_test
}  // namespace takt::report
