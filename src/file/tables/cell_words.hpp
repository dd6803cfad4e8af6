// Parses the words that spreadsheets and other tools write in cells. Every function returns nothing for
// unknown words and for words that are already those of a project file.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace takt::file {

/// Whether the text is the entry "none chosen" of an IDE's list: `< не выбрана >`, in any brackets, also cut:
/// `‹ не выбр...`.
bool is_placeholder(std::string_view text);

/// Whether the word means "none": `-`, `none`, `нет`, `немає`.
bool means_nothing(std::string_view text);

/// `Логический`, `REAL`, `2-register int`, `DINT`, `С плавающей запя...`: a word of model::kTypes.
std::optional<std::string> type_word(std::string_view text);

/// The type with that number of registers: int16 in 2 registers is int32. Nothing if there is none.
std::optional<std::string_view> type_of_registers(std::string_view type, int registers);

/// `03 (0x03) Read Holding Registers`, `FC3`, `03h`, `нет`: `0x03`, `none`. Nothing if number and name
/// disagree.
std::optional<std::string> function_word(std::string_view text);

/// `Да`, `нет`, `1`, `x`, `ИСТИНА`: `true`, `false`.
std::optional<std::string> boolean_word(std::string_view text);

/// A check box of a window with the text beside it: `☒ Старшим байтом вперед`, `[ ] High register first`.
struct LabelledBox {
    std::string_view state;  ///< `true` or `false`
    std::string_view label;
};
std::optional<LabelledBox> split_box(std::string_view text);

/// `Float: 2 1 4 3`, `☒ Старшим байтом вперед ☐ Старшим регистром вперед`: `2143`.
std::optional<std::string> byte_order_word(std::string_view text);

/// `Coils`, `Holding Registers`, `Регистры хранения`: a word of model::kAreas.
std::optional<std::string> area_word(std::string_view text);

/// `10h`, `10H`: `0x10`. @param hexadecimal  the column's numbers are hexadecimal: also `10`
std::optional<std::string> address_word(std::string_view text, bool hexadecimal);

/// `00108` for `108`: spreadsheets drop leading zeros.
std::optional<std::string> reference_word(std::string_view text);

/// `100 мс`, `1,5 s`; with a unit in the heading also `100`.
std::optional<std::string> duration_word(std::string_view text, std::string_view unit, bool decimal_comma);

/// `1,5`: `1.5`.
std::optional<std::string> number_word(std::string_view text);

/// `1 000 ms`: `1000 ms`. The blanks between groups of three digits may be those that do not break.
std::optional<std::string> ungrouped_word(std::string_view text);

}  // namespace takt::file
