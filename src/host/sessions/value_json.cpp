#include "takt/host/value_json.hpp"

#include <variant>

namespace takt::host {
namespace {

struct ToJson {
    bool is_float;

    file::Json operator()(std::monostate) const { return {}; }
    file::Json operator()(double number) const {
        return is_float ? file::Json(static_cast<float>(number)) : file::Json(number);
    }
    file::Json operator()(const auto& other) const { return file::Json(other); }
};

}  // namespace

file::Json to_json(DataType type, bool scaled, const value::Value& value) {
    return std::visit(ToJson{type == DataType::float32 && !scaled}, value);
}

}  // namespace takt::host
