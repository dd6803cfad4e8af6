#include "tables/cell_words.hpp"

#include <gtest/gtest.h>

#include <set>

#include "tables/headings.hpp"
#include "takt/file/table.hpp"
#include "takt/model/fields.hpp"

namespace takt::file {
namespace words_test {

using Word = std::optional<std::string>;

struct Case {
    std::string_view text;
    Word word;
};

TEST(Words, Types) {
    const Case cases[] = {
        {"Логический", "bool"},
        {"логічний", "bool"},
        {"BOOL", "bool"},
        {"Булевский", "bool"},
        {"Целочисленный", "int16"},
        {"INT", "int16"},
        {"целочисленный (2 регистра)", "int32"},
        {"2-register int", "int32"},
        {"INT, 2 registers", "int32"},
        {"Цілочисельний 2 регістри", "int32"},
        {"Двухрегистровый целочисленный", "int32"},
        {"двохрегістровий", std::nullopt},
        {"uint (4 registers)", "uint64"},
        {"UDINT", "uint32"},
        {"Беззнаковое целое", "uint16"},
        {"Целое без знака (2 регистра)", "uint32"},
        {"Ціле без знака", "uint16"},
        {"Беззнакове ціле", "uint16"},
        {"Целое со знаком", "int16"},
        {"Unsigned integer", "uint16"},
        {"BYTE", std::nullopt},  // half a register
        {"WORD", "uint16"},
        {"С плавающей запятой", "float"},
        {"з рухомою комою", "float"},
        {"REAL", "float"},
        {"LREAL", "double"},
        {"Float 32", "float"},
        {"float, 4 registers", "double"},
        {"Вещественный", "float"},
        {"Строка", "string"},
        {"bool, 2 registers", std::nullopt},
        {"float", std::nullopt},  // as it is
        {"int", std::nullopt},
        {"colour", std::nullopt},
        {"", std::nullopt},
    };
    for (const auto& [text, word] : cases) EXPECT_EQ(type_word(text), word) << text;
    for (const auto type : model::kTypes) EXPECT_EQ(type_word(type), Word()) << type;
}

TEST(Words, Functions) {
    const Case cases[] = {
        {"03 (0x03) Read Holding Registers", "0x03"},
        {"Read Holding Registers", "0x03"},
        {"read input registers (4)", "0x04"},
        {"FC3", "0x03"},
        {"03", "0x03"},
        {"03h", "0x03"},
        {"10h", "0x10"},
        {"0F", "0x0F"},
        {"16 (0x10) Preset Multiple Registers", "0x10"},
        {"06 – Запись одного регистра", "0x06"},
        {"Запис декількох регістрів", "0x10"},
        {"-", "none"},
        {"нет", "none"},
        {"Немає", "none"},
        {"None", "none"},
        {"3", std::nullopt},  // as it is
        {"0x10", std::nullopt},
        {"none", std::nullopt},
        {"03 (0x04)", std::nullopt},  // what does it mean?
        {"03 Read Input Registers", std::nullopt},
        {"reading", std::nullopt},
        {"99999999999999999999", std::nullopt},
    };
    for (const auto& [text, word] : cases) EXPECT_EQ(function_word(text), word) << text;
}

TEST(Words, OtherCells) {
    for (const auto text : {"Да", "yes", "1", "x", "Х", "✓", "ИСТИНА", "Так", "+"})
        EXPECT_EQ(boolean_word(text), Word("true")) << text;
    for (const auto text : {"Нет", "no", "0", "-", "ЛОЖЬ", "Ні", "хибність"})
        EXPECT_EQ(boolean_word(text), Word("false")) << text;
    for (const auto text : {"true", "False", "maybe", ""}) EXPECT_EQ(boolean_word(text), Word()) << text;
    EXPECT_EQ(area_word("Holding Registers"), Word("holding_register"));
    EXPECT_EQ(area_word("Регистры хранения"), Word("holding_register"));
    EXPECT_EQ(area_word("coil"), Word());
    EXPECT_EQ(address_word("10h", false), Word("0x10"));
    EXPECT_EQ(address_word("00FFH", false), Word("0xFF"));
    EXPECT_EQ(address_word("1F", true), Word("0x1F"));
    for (const auto text : {"16", "0x10", "h", "1F", ""})
        EXPECT_EQ(address_word(text, false), Word()) << text;
    EXPECT_EQ(reference_word("108"), Word("00108"));
    EXPECT_EQ(reference_word("40108"), Word());
    EXPECT_EQ(duration_word("100", "ms", false), Word("100ms"));
    EXPECT_EQ(duration_word("100 мс", "", false), Word("100ms"));
    EXPECT_EQ(duration_word("1,5 сек.", "", true), Word("1.5s"));
    for (const auto text : {"100", "1s", "1,5s", "soon", "1 fortnight"})
        EXPECT_EQ(duration_word(text, "", false), Word()) << text;
    EXPECT_EQ(number_word("-1,5"), Word("-1.5"));
    for (const auto text : {"1.5", "1,000,000", "1,2.3", ",", "a,b"})
        EXPECT_EQ(number_word(text), Word()) << text;
}

TEST(Words, OrdersOfBytes) {
    EXPECT_EQ(byte_order_word("Float: 2 1 4 3"), Word("2143"));
    EXPECT_EQ(byte_order_word("☒ Старшим байтом вперед ☐ Старшим регистром вперед"), Word("2143"));
    EXPECT_EQ(byte_order_word("☑ Старшим регистром вперёд; □ Старшим байтом вперёд."), Word("3412"));
    EXPECT_EQ(byte_order_word("[x] High byte first [x] High register first"), Word("4321"));
    EXPECT_EQ(byte_order_word("☐ Старшим байтом вперед"), Word("1234"));
    for (const auto* const text :
         {"2143", "", "☒", "☒ Старшим", "Старшим байтом вперед", "☒ Старшим байтом вперед Комментарий"})
        EXPECT_EQ(byte_order_word(text), Word()) << text;
}

TEST(Headings, EveryKeyOfAVariableHasThemInEveryLanguage) {
    for (const auto& field : model::fields(model::Object::variable)) {
        EXPECT_TRUE(has_headings(field.key)) << field.key;
        std::set<std::string> different;
        for (const auto language :
             {Headings::keys, Headings::english, Headings::russian, Headings::ukrainian})
            EXPECT_EQ(read_heading(heading(field.key, language)).key, field.key)
                << heading(field.key, language);
    }
}

TEST(Headings, AreThoseOfTheIde) {
    constexpr std::string_view kKeys[] = {"name", "type", "read", "write", "register", "bit", "comment"};
    constexpr std::string_view kRussian[] = {"Имя переменной", "Тип переменной", "Функция чтения",
                                             "Функция записи", "Адрес регистра", "Адрес бита",
                                             "Комментарий"};
    constexpr std::string_view kUkrainian[] = {"Ім'я змінної",   "Тип змінної",     "Функція читання",
                                               "Функція запису", "Адреса регістра", "Адреса біта",
                                               "Коментар"};
    constexpr std::string_view kEnglish[] = {"Variable name",  "Variable type",    "Read function",
                                             "Write function", "Register address", "Bit address",
                                             "Comment"};
    for (std::size_t i = 0; i < std::size(kKeys); ++i) {
        EXPECT_EQ(heading(kKeys[i], Headings::russian), kRussian[i]);
        EXPECT_EQ(heading(kKeys[i], Headings::ukrainian), kUkrainian[i]);
        EXPECT_EQ(heading(kKeys[i], Headings::english), kEnglish[i]);
    }
}

TEST(Headings, AreReadInAnySpelling) {
    struct Heading {
        std::string_view text;
        std::string_view key;
        std::string_view unit;
        bool hexadecimal = false;
    };
    constexpr Heading kCases[] = {
        {"ИМЯ  ПЕРЕМЕННОЙ", "name", ""},
        {"Ім’я змінної", "name", ""},
        {"Імʼя змінної", "name", ""},
        {"Имя\nпеременнои\xCC\x86", "name", ""},  // й in two characters
        {"Register_Address", "register", ""},
        {"Address (hex)", "register", "", true},
        {"WriteOnChange", "write_on_change", ""},
        {"Период опроса, мс", "period", "ms"},
        {"Period [s]", "period", "s"},
        {"Deadline (us)", "deadline", "us"},
        {"Ед. изм.", "unit", ""},
        {"Количество регистров", "registers", ""},
        {"Comment, ms", "", ""},
        {"Colour", "", ""},
        {"", "", ""},
        {"\xD0", "", ""},
    };
    for (const auto& [text, key, unit, hexadecimal] : kCases) {
        const auto parts = read_heading(text);
        EXPECT_EQ(parts.key, key) << text;
        EXPECT_EQ(parts.unit, unit) << text;
        EXPECT_EQ(parts.hexadecimal, hexadecimal) << text;
    }
    EXPECT_EQ(likely_heading("Адрес рег").key, "register");
    EXPECT_TRUE(likely_heading("Тип переменой").typing_mistake);
    EXPECT_FALSE(likely_heading("Цвет").typing_mistake);
}

}  // namespace words_test
}  // namespace takt::file
