// The words of cells: what spreadsheets and other tools write where a project file has words of its own.
// Each gives nothing for what it does not know, and for what is already as a project file has it.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace takt::file {

/// Stands for nothing: `-`, `none`, `нет`, `немає`.
bool means_nothing(std::string_view text);

/// `Логический`, `REAL`, `2-register int`, `DINT`: a word of model::kTypes.
std::optional<std::string> type_word(std::string_view text);

/// The type with another number of registers: int16 in 2 registers is int32. Nothing where there is none.
std::optional<std::string_view> type_of_registers(std::string_view type, int registers);

/// `03 (0x03) Read Holding Registers`, `FC3`, `03h`, `нет`: `0x03`, `none`. Nothing also where number and
/// name do not agree.
std::optional<std::string> function_word(std::string_view text);

/// `Да`, `нет`, `1`, `x`, `ИСТИНА`: `true`, `false`.
std::optional<std::string> boolean_word(std::string_view text);

/// `Coils`, `Holding Registers`, `Регистры хранения`: a word of model::kAreas.
std::optional<std::string> area_word(std::string_view text);

/// `10h`, `10H`: `0x10`. @param hexadecimal  the column is; then `10` too
std::optional<std::string> address_word(std::string_view text, bool hexadecimal);

/// `00108` where a spreadsheet has made `108` of it.
std::optional<std::string> reference_word(std::string_view text);

/// `100 мс`, `1,5 s`; with the unit of the column also `100`.
std::optional<std::string> duration_word(std::string_view text, std::string_view unit, bool decimal_comma);

/// `1,5`: `1.5`.
std::optional<std::string> number_word(std::string_view text);

}  // namespace takt::file
