#include "takt/web/api.hpp"

#include <utility>

namespace takt::web {

std::string_view ApiRequest::parameter(std::string_view name) const {
    const auto found = query.find(name);
    return found == query.end() ? std::string_view() : std::string_view(found->second);
}

ApiResponse ApiResponse::json(const file::Json& object, int status) {
    return {.status = status, .body = object.dump() + '\n'};
}

ApiResponse ApiResponse::error(int status, std::string_view code, std::string text) {
    auto error = file::Json::object();
    error.set("code", code);
    error.set("text", std::move(text));
    auto object = file::Json::object();
    object.set("error", std::move(error));
    return json(object, status);
}

ApiResponse ApiResponse::wrong_parameter(const ApiRequest& request, std::string_view name,
                                         std::string allowed) {
    return error(400, "parameter",
                 request.texts("web.error.parameter", {{"name", std::string(name)},
                                                       {"value", std::string(request.parameter(name))},
                                                       {"allowed", std::move(allowed)}}));
}

}  // namespace takt::web
