// The page of a running project: what `run` and `demo` have in common.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "commands.hpp"
#include "takt/host/project_file.hpp"
#include "takt/web/web_face.hpp"
#include "texts.hpp"

namespace takt::app {

/// The token of the API; empty: none is needed. Prints why there is nothing: an address that other computers
/// reach has no token, or the file has none.
[[nodiscard]] std::optional<std::string> read_token(const Texts& texts, const WebOptions& options);

struct WebRun {
    std::string project_file;  ///< empty: nothing can be edited
    web::HostAccess host;
    /// Runs a saved project in place of the one that runs. Called on a thread of the page.
    std::function<Result<void>(host::LoadedProject)> apply;
};

/// The page and the editing of the project's file.
class WebSide {
public:
    virtual ~WebSide() = default;
    /// As web::WebFace::stop().
    virtual bool stop() = 0;
};

/// Serves the page, and prints its address.
/// @param options  with an address
/// @returns as web::WebFace::start()
[[nodiscard]] Result<std::unique_ptr<WebSide>> start_web(const Texts& texts, const WebOptions& options,
                                                         const std::string& token, WebRun run);

}  // namespace takt::app
