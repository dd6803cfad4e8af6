#include "online/web_run.hpp"

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <iterator>
#include <utility>

#include "log.hpp"
#include "output.hpp"
#include "takt/model/output.hpp"
#include "takt/os/open.hpp"
#include "takt/web/history_api.hpp"
#include "takt/web/project_api.hpp"
#include "version.hpp"

namespace takt::app {
namespace {

constexpr std::size_t kLeastToken = 16;
constexpr std::size_t kMostToken = 256;
constexpr std::size_t kMostTokenFile = 4096;

bool is_token(std::string_view text) {
    return text.size() >= kLeastToken && text.size() <= kMostToken &&
           std::ranges::all_of(text, [](char c) { return c > ' ' && c < 0x7F; });
}

std::optional<std::string> token_of_file(const Texts& texts, const std::string& path) {
    const auto file = os::open_for_reading(path);
    const auto text = file ? os::read_all(file->get(), path, kMostTokenFile)
                           : Result<std::string>(std::unexpected(file.error()));
    if (!text) {
        print_error(texts.describe(text.error()));
        return std::nullopt;
    }
    auto line = text->substr(0, text->find_first_of("\r\n"));
    if (is_token(line)) return line;
    print_error(texts("app.web.token_short", {{"file", path}}));
    return std::nullopt;
}

/// The face with what its routes refer to, in the order in which they are made and (backwards) destroyed.
class ServedProject final : public WebSide {
public:
    ServedProject(WebRun run, bool editable)
        : history_{.project_file = run.project_file, .configuration = run.host.configuration},
          project_(
              {.file = run.project_file, .apply = editable ? std::move(run.apply) : decltype(run.apply)()}) {}

    Result<void> begin(web::WebFaceOptions options, bool or_free_port) {
        for (auto& route : project_.routes()) options.routes.push_back(std::move(route));
        for (auto& route : web::history_routes(history_)) options.routes.push_back(std::move(route));
        auto started = web::WebFace::start(options);
        if (!started && or_free_port && started.error().code == Code::cannot_open) {
            options.server.address.port = 0;
            started = web::WebFace::start(std::move(options));
        }
        TAKT_TRY(face_, std::move(started));
        return {};
    }

    bool stop() override { return face_->stop(); }
    [[nodiscard]] std::string url() const { return face_->url(); }

private:
    web::HistoryApiOptions history_;
    web::ProjectApi project_;
    std::unique_ptr<web::WebFace> face_;
};

}  // namespace

std::optional<std::string> read_token(const Texts& texts, const WebOptions& options) {
    if (!options.address) return "";
    if (!options.token_file.empty()) return token_of_file(texts, options.token_file);
    if (!web::needs_token(*options.address)) return "";
    const auto& address = *options.address;
    print_error(
        texts("app.web.token_needed",
              {{"address", line::host_and_port(address.host.empty() ? "*" : address.host, address.port)}}));
    print_status("    " + texts("app.web.token_needed.advice", {{"port", std::to_string(address.port)}}) +
                 '\n');
    return std::nullopt;
}

Result<std::unique_ptr<WebSide>> start_web(const Texts& texts, const WebOptions& options,
                                           const std::string& token, WebRun run) {
    const bool editable = options.allow_write && !run.project_file.empty();
    web::WebFaceOptions face{.server = {.address = *options.address,
                                        .names = options.names,
                                        .proxies = options.proxies,
                                        .token = token,
                                        .allow_write = options.allow_write,
                                        .language = texts.language(),
                                        .log = log("web")},
                             .host = run.host,
                             .project = std::filesystem::path(run.project_file).filename().string(),
                             .version = std::string(kProgramVersion),
                             .demo = options.demo,
                             .editable = editable,
                             .history = web::has_history(run.host.configuration()->project()),
                             .marks_file = run.project_file.empty() ? "" : web::marks_file(run.project_file)};
    auto served = std::make_unique<ServedProject>(std::move(run), editable);
    TAKT_CHECK(served->begin(std::move(face), options.or_free_port));
    print_status(
        texts(options.allow_write ? "app.web.address" : "app.web.read_only", {{"url", served->url()}}) +
        '\n');
    return served;
}

}  // namespace takt::app
