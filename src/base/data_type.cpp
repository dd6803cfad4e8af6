#include "takt/base/data_type.hpp"

#include <array>
#include <utility>

namespace takt {
namespace {

struct Named {
    std::string_view name;
    DataType type;
};

// The first name of a type is its own, later ones are aliases.
constexpr std::array kNames{
    Named{"bool", DataType::boolean},  Named{"int16", DataType::int16},   Named{"uint16", DataType::uint16},
    Named{"int32", DataType::int32},   Named{"uint32", DataType::uint32}, Named{"int64", DataType::int64},
    Named{"uint64", DataType::uint64}, Named{"float", DataType::float32}, Named{"double", DataType::float64},
    Named{"string", DataType::string}, Named{"int", DataType::int16},     Named{"real", DataType::float32},
};

}  // namespace

std::string_view name(DataType type) {
    for (const auto& named : kNames)
        if (named.type == type) return named.name;
    return "unknown";
}

std::optional<DataType> data_type(std::string_view name) {
    for (const auto& named : kNames)
        if (named.name == name) return named.type;
    return std::nullopt;
}

}  // namespace takt
