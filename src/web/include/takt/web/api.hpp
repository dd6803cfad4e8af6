// Requests of the HTTP API and their answers, without a server: what handlers see and return.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "takt/base/result.hpp"
#include "takt/file/json.hpp"
#include "takt/report/drawing/texts.hpp"

namespace takt::web {

enum class Method : std::uint8_t { get, post, put };

/// The work of a request. Each kind has threads of its own.
enum class Work : std::uint8_t {
    quick,     ///< from memory or a file
    planning,  ///< up to many seconds of processor time
    device,    ///< waits for the response of a device
};
inline constexpr std::array kWorks = {Work::quick, Work::planning, Work::device};

/// A request that has passed the guard: size, host, origin, token and rate are checked.
struct ApiRequest {
    std::multimap<std::string, std::string, std::less<>> query;  ///< decoded
    std::string body;                                            ///< UTF-8; empty for GET
    const report::Texts& texts;                                  ///< in the language of the request
    std::string peer;                                            ///< address of the client, for audits
    /// Stops when the answer is of no use: the client has gone, a newer request supersedes this one, or the
    /// program stops.
    std::stop_token stop = {};

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
    /// The query parameter `name` has none of the allowed values.
    [[nodiscard]] static ApiResponse wrong_parameter(const ApiRequest& request, std::string_view name,
                                                     std::string allowed);
};

/// Called on a thread of the server; several run at the same time.
using ApiHandler = std::function<ApiResponse(const ApiRequest&)>;

struct ApiRoute {
    Method method = Method::get;
    std::string_view path;  ///< below /api/v1, as in "/project/evaluate"
    bool changes = false;   ///< needs --allow-write
    ApiHandler handler;
    Work work = Work::quick;
    /// A newer request of the same client supersedes an older one. A client is a peer's address with the
    /// query's `client`.
    bool newest_only = false;
};

}  // namespace takt::web
