// The area and address of a variable, from any of the three notations.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "reading/reader.hpp"
#include "servers/interpretation.hpp"
#include "takt/model/project.hpp"

namespace takt::model {

/// A one-based number with its area: "40108" is {holding_register, 107}.
struct Reference {
    wire::Area area = wire::Area::holding_register;
    std::uint16_t number = 0;  ///< zero-based
    friend bool operator==(const Reference&, const Reference&) = default;
};

/// Five digits (1..9999 in the area) or six (1..65536); the first one is the area.
std::optional<Reference> parse_reference(std::string_view text);

/// The reference as which a user may have meant the decimal number in `register` or `coil`: `40001` in an
/// area of that digit, or in an unknown one.
std::optional<Reference> like_reference(const Reader& reader, std::string_view key,
                                        std::optional<wire::Area> area);

/// Notes an address of a variable that looks like a reference. A list of variables has one finding for all of
/// them.
void note_like_reference(Interpretation& state, const Reader& reader, const Variable& variable);

/// Reports the addresses that were noted since the last call.
void report_like_references(Interpretation& state);

/// The word of an area in project files: "coil".
std::string area_name(wire::Area area);

/// Functions of an area as text: "0x01"; "0x05, 0x0F".
std::string read_functions(wire::Area area);
std::string write_functions(wire::Area area);

/// Determines area, functions, register, bit and number of registers. Needs `read` and `write` as in the
/// file.
/// @param type  nothing if unknown; rules that depend on it are then skipped
void settle_address(Reader& reader, Variable& variable, std::optional<DataType> type);

}  // namespace takt::model
