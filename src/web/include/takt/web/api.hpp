// Requests of the HTTP API and their answers, without a server: what handlers see and return.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "takt/base/result.hpp"
#include "takt/file/json.hpp"
#include "takt/report/texts.hpp"

namespace takt::web {

enum class Method : std::uint8_t { get, post, put };

/// A request that has passed the guard: size, host, origin, token and rate are checked.
struct ApiRequest {
    std::multimap<std::string, std::string, std::less<>> query;  ///< decoded
    std::string body;                                            ///< UTF-8; empty for GET
    const report::Texts& texts;                                  ///< in the language of the request
    std::string peer;                                            ///< address of the client, for audits

    /// The first value of a query parameter; empty without one.
    [[nodiscard]] std::string_view parameter(std::string_view name) const;
};

struct ApiResponse {
    int status = 200;
    std::string content_type = "application/json";
    std::string body;
    std::string file_name = {};  ///< of a download; empty: shown by the browser

    [[nodiscard]] static ApiResponse json(const file::Json& object, int status = 200);
    /// {"error":{"code","text"}}
    /// @param code  stable, as in "read_only"
    [[nodiscard]] static ApiResponse error(int status, std::string_view code, std::string text);
};

/// Called on a thread of the server; several run at the same time.
using ApiHandler = std::function<ApiResponse(const ApiRequest&)>;

struct ApiRoute {
    Method method = Method::get;
    std::string_view path;  ///< below /api/v1, as in "/project/evaluate"
    bool changes = false;   ///< needs --allow-write
    ApiHandler handler;
};

}  // namespace takt::web
