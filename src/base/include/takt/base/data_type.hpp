// The types of values and how they lie in registers.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace takt {

/// Types of a variable (docs/specification.md, section 2). In project files `int` is int16, and `real` and
/// `float` are float32.
enum class DataType : std::uint8_t {
    boolean,
    int16,
    uint16,
    int32,
    uint32,
    int64,
    uint64,
    float32,
    float64,
    string
};

/// Name in project files: bool int16 uint16 int32 uint32 int64 uint64 float double string.
std::string_view name(DataType type);

/// The type of a name in a project file, the aliases `int` and `real` included.
std::optional<DataType> data_type(std::string_view name);

constexpr bool is_integer(DataType type) {
    return type >= DataType::int16 && type <= DataType::uint64;
}

/// Registers of a value: 1, 2 or 4; for a string the length of the variable; for a bool (part of) one.
constexpr int register_count(DataType type, int string_registers = 1) {
    switch (type) {
        case DataType::boolean:
        case DataType::int16:
        case DataType::uint16: return 1;
        case DataType::int32:
        case DataType::uint32:
        case DataType::float32: return 2;
        case DataType::int64:
        case DataType::uint64:
        case DataType::float64: return 4;
        case DataType::string: return string_registers;
    }
    return 1;
}

/// Order of the bytes of a value (docs/specification.md, section 2). The default is `2 1 4 3`: low register
/// first, high byte first.
struct ByteOrder {
    bool high_byte_first = true;
    bool high_register_first = false;
    friend constexpr bool operator==(ByteOrder, ByteOrder) = default;
};

}  // namespace takt
