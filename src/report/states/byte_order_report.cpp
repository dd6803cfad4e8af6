#include "states/byte_order_report.hpp"

#include <fmt/format.h>

#include <set>
#include <string_view>
#include <vector>

#include "takt/model/byte_order.hpp"

namespace takt::report {
namespace {

constexpr int kTwoRegisters = 2;
constexpr std::size_t kMostListedNames = 4;

bool in_bits(const model::Variable& variable) {
    return variable.area == wire::Area::coil || variable.area == wire::Area::discrete_input;
}

bool differs(const model::Variable& variable, ByteOrder order) {
    return !in_bits(variable) && model::byte_order_text(variable.order, variable.type) !=
                                     model::byte_order_text(order, variable.type);
}

void append_limited(std::string& list, std::size_t number, const std::string& text) {
    if (number < kMostListedNames) list += (number == 0 ? "" : ", ") + text;
    if (number == kMostListedNames) list += ", …";
}

}  // namespace

file::Json byte_order_json(const model::Variable& variable) {
    if (in_bits(variable)) return {};
    return model::byte_order_text(variable.order, variable.type);
}

file::Json byte_orders_json(const model::Project& project) {
    auto devices = file::Json::array();
    for (const auto& line : project.lines)
        for (const auto& device : line.devices) {
            auto object = file::Json::object();
            object.set("line", line.name);
            object.set("name", device.name);
            object.set("unit", device.address.value);
            object.set("byte_order", model::byte_order_text(device.order, kTwoRegisters));
            auto others = file::Json::array();
            for (const auto& variable : device.variables) {
                if (!differs(variable, device.order)) continue;
                auto other = file::Json::object();
                other.set("name", variable.name);
                other.set("byte_order", byte_order_json(variable));
                others.push_back(std::move(other));
            }
            object.set("variables", std::move(others));
            devices.push_back(std::move(object));
        }
    return devices;
}

std::string byte_order_names(const model::Line& line) {
    std::set<std::string_view> used;
    for (const auto& device : line.devices) {
        if (!(device.order == ByteOrder{})) used.insert(model::byte_order_text(device.order, kTwoRegisters));
        for (const auto& variable : device.variables)
            if (differs(variable, device.order))
                used.insert(model::byte_order_text(variable.order, variable.type));
    }
    std::string names;
    for (const auto permutation : used)
        names += fmt::format("{}{} = {}", names.empty() ? "" : ", ", permutation,
                             model::byte_order_name(permutation));
    return names;
}

std::string byte_orders_text(const model::Line& line) {
    std::string devices;
    std::size_t count = 0;
    for (const auto& device : line.devices) {
        std::string others;
        std::size_t other = 0;
        for (const auto& variable : device.variables)
            if (differs(variable, device.order))
                append_limited(others, other++,
                               fmt::format("{} {}", variable.name,
                                           model::byte_order_text(variable.order, variable.type)));
        if (device.order == ByteOrder{} && others.empty()) continue;
        auto text = fmt::format("{} {}", device.name, model::byte_order_text(device.order, kTwoRegisters));
        if (!others.empty()) text += " (" + others + ")";
        append_limited(devices, count++, text);
    }
    return devices;
}

}  // namespace takt::report
