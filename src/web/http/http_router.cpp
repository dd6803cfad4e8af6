// cpp-httplib parses and formats: its Server is given each request as a stream in memory. It never sees a
// socket, and the body is handed over whole, so its own readers of bodies are not used.
#include "http/http_router.hpp"

#include <httplib.h>

#include <algorithm>
#include <array>
#include <exception>
#include <optional>
#include <utility>

#include "http/forwarding.hpp"
#include "http/page.hpp"
#include "takt/base/utf8.hpp"

namespace takt::web {
namespace {

constexpr std::string_view kApi = "/api/v1";
constexpr std::size_t kMostRequests = 100'000;  // of a connection: what cpp-httplib promises clients

// Scripts and styles come from the program only; the page can neither be framed nor give its address away.
// Inline styles: uPlot and the page's virtual tables place their elements with them.
constexpr std::array<std::pair<const char*, const char*>, 7> kFields = {{
    {"Content-Security-Policy",
     "default-src 'self'; img-src 'self' data:; style-src 'self' 'unsafe-inline'; object-src 'none'; "
     "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"},
    {"X-Content-Type-Options", "nosniff"},
    {"X-Frame-Options", "DENY"},
    {"Referrer-Policy", "no-referrer"},
    {"Cross-Origin-Opener-Policy", "same-origin"},
    {"Cross-Origin-Resource-Policy", "same-origin"},
    {"Permissions-Policy", "camera=(), microphone=(), geolocation=()"},
}};

/// A request as a stream that cpp-httplib reads, and its answer.
class MemoryStream final : public httplib::Stream {
public:
    MemoryStream(std::string_view input, const std::string& peer) : input_(input), peer_(peer) {}

    [[nodiscard]] std::string take_output() { return std::move(output_); }

    [[nodiscard]] bool is_readable() const override { return !input_.empty(); }
    [[nodiscard]] bool is_writable() const override { return true; }
    ssize_t read(char* into, std::size_t size) override {
        size = std::min(size, input_.size());
        input_.copy(into, size);
        input_.remove_prefix(size);
        return static_cast<ssize_t>(size);
    }
    ssize_t write(const char* from, std::size_t size) override {
        output_.append(from, size);
        return static_cast<ssize_t>(size);
    }
    void get_remote_ip_and_port(std::string& ip, int& port) const override {
        ip = peer_;
        port = 0;
    }
    void get_local_ip_and_port(std::string& ip, int& port) const override {
        ip.clear();
        port = 0;
    }
    [[nodiscard]] socket_t socket() const override { return -1; }

private:
    std::string_view input_;
    std::string output_;
    const std::string& peer_;
};

std::optional<std::string> header_field(const httplib::Request& request, const char* name) {
    if (!request.has_header(name)) return std::nullopt;
    return request.get_header_value(name);
}

bool accepts_gzip(const httplib::Request& request) {
    const auto text = request.get_header_value("Accept-Encoding");
    const auto at = text.find("gzip");
    return at != std::string::npos && text.compare(at, 8, "gzip;q=0") != 0;
}

text::Language language_of(const httplib::Request& request, text::Language otherwise) {
    if (request.has_param("lang")) return text::language(request.get_param_value("lang")).value_or(otherwise);
    return text::language(request.get_header_value("Accept-Language")).value_or(otherwise);
}

/// What passes between admit() or reply() and the handler that cpp-httplib calls inside, on one thread.
struct HttpExchange {
    HttpRequest& request;
    bool admitting = false;
    bool admitted = false;
    bool gzip = false;
    std::unique_ptr<StreamSource> stream = {};
};

thread_local HttpExchange* current = nullptr;

bool is_utf8(std::string_view text) {
    while (!text.empty()) {
        const auto size = first_character(text).bytes;
        if (size == 0) return false;
        text.remove_prefix(size);
    }
    return true;
}

std::string fields_text() {
    std::string text;
    for (const auto& [name, value] : kFields) text.append(name).append(": ").append(value).append("\r\n");
    return text;
}

std::string stream_head() {
    return "HTTP/1.1 200 OK\r\nContent-Type: text/event-stream\r\nCache-Control: no-store\r\n"
           "Connection: close\r\nX-Accel-Buffering: no\r\n" +
           fields_text() + "\r\n";
}

std::string quoted_file_name(std::string name) {
    std::ranges::replace_if(
        name, [](char c) { return c == '"' || c == '\\' || static_cast<unsigned char>(c) < 0x20; }, '_');
    return '"' + name + '"';
}

}  // namespace

struct HttpRouter::Impl final : httplib::Server {
    Impl(GuardPolicy policy, std::vector<Network> named, text::Language spoken, std::vector<ApiRoute> api,
         std::vector<StreamRoute> event_streams, Log sink)
        : guard(std::move(policy)),
          proxies(std::move(named)),
          language(spoken),
          routes(std::move(api)),
          streams(std::move(event_streams)),
          log(sink) {
        set_keep_alive_max_count(kMostRequests);
        set_keep_alive_timeout(20);  // as HttpConnection::Limits::idle
        set_pre_routing_handler([this](const httplib::Request& request, httplib::Response& response) {
            handle(request, response);
            return HandlerResponse::Handled;
        });
    }

    RequestGuard guard;
    std::vector<Network> proxies;
    text::Language language;
    std::vector<ApiRoute> routes;
    std::vector<StreamRoute> streams;
    Log log;

    /// @param close  the answer announces the end of the connection
    std::string process(HttpExchange& exchange, bool close, bool& closed) {
        current = &exchange;
        MemoryStream stream(exchange.request.head, exchange.request.peer);
        static_cast<void>(process_request(stream, close, closed, [](httplib::Request& parsed) {
            current->gzip = accepts_gzip(parsed);
            parsed.headers.erase("Accept-Encoding");  // Brotli at its best quality takes seconds
            if (current->gzip && parsed.path.starts_with(kApi))
                parsed.headers.emplace("Accept-Encoding", "gzip");
        }));
        current = nullptr;
        return stream.take_output();
    }

    void handle(const httplib::Request& request, httplib::Response& response);
    void serve_page(const httplib::Request& request, const report::Texts& texts,
                    httplib::Response& response) const;
    [[nodiscard]] ApiResponse serve_api(const httplib::Request& request, const ForwardedClient& client,
                                        const report::Texts& texts, httplib::Response& response) const;
    [[nodiscard]] ForwardedClient client_of(const httplib::Request& request) const;
    [[nodiscard]] const ApiRoute* route_of(const httplib::Request& request) const;
    [[nodiscard]] std::optional<Refusal> check(const httplib::Request& request, const ForwardedClient& client,
                                               bool changes) const;
    void admit(const httplib::Request& request, const ForwardedClient& client, const ApiRoute* route) const;
    [[nodiscard]] ApiResponse execute(const ApiRoute& route, const ApiRequest& request) const;
};

namespace {

ApiResponse refusal(const report::Texts& texts, const Refusal& why) {
    return ApiResponse::error(why.status, why.code, texts("web.error." + std::string(why.code)));
}

void put(httplib::Response& response, const ApiResponse& answer) {
    response.status = answer.status;
    response.set_header("Cache-Control", "no-store");
    if (!answer.file_name.empty())
        response.set_header("Content-Disposition",
                            "attachment; filename=" + quoted_file_name(answer.file_name));
    response.set_content(answer.body, answer.content_type);
}

std::optional<Method> method_of(const std::string& name) {
    if (name == "GET" || name == "HEAD") return Method::get;
    if (name == "POST") return Method::post;
    if (name == "PUT") return Method::put;
    return std::nullopt;
}

std::string_view api_path(const httplib::Request& request) {
    return request.path.starts_with(kApi) ? std::string_view(request.path).substr(kApi.size()) : "";
}

}  // namespace

ForwardedClient HttpRouter::Impl::client_of(const httplib::Request& request) const {
    const auto addresses = request.get_header_value("X-Forwarded-For");
    const auto host = request.get_header_value("X-Forwarded-Host");
    const auto scheme = request.get_header_value("X-Forwarded-Proto");
    return forwarded_client(request.remote_addr, {addresses, host, scheme}, proxies);
}

const ApiRoute* HttpRouter::Impl::route_of(const httplib::Request& request) const {
    const auto found = std::ranges::find_if(routes, [&](const ApiRoute& its) {
        return its.path == api_path(request) && its.method == method_of(request.method);
    });
    return found == routes.end() ? nullptr : &*found;
}

// Visitors with the token have limits of their own: behind a proxy that is not named all have one address,
// and those without a token must not use up the limits of the others.
std::optional<Refusal> HttpRouter::Impl::check(const httplib::Request& request, const ForwardedClient& client,
                                               bool changes) const {
    GuardedRequest guarded{.api = request.path.starts_with("/api"),
                           .reads = method_of(request.method) == Method::get,
                           .changes = changes,
                           .tls = client.tls,
                           .host = header_field(request, "Host"),
                           .origin = header_field(request, "Origin"),
                           .fetch_site = header_field(request, "Sec-Fetch-Site"),
                           .mark = header_field(request, "X-Takt"),
                           .content_type = header_field(request, "Content-Type"),
                           .authorization = header_field(request, "Authorization"),
                           .parameters = request.params.size()};
    if (!client.host.empty()) guarded.forwarded_host = client.host;
    if (request.has_param("token")) guarded.query_token = request.get_param_value("token");
    for (const auto& [name, value] : request.params)
        guarded.longest_parameter = std::max({guarded.longest_parameter, name.size(), value.size()});
    current->request.visitor = limit_key(client.address) + (guard.has_token(guarded) ? " token" : "");
    return guard.check(guarded);
}

void HttpRouter::Impl::admit(const httplib::Request& request, const ForwardedClient& client,
                             const ApiRoute* route) const {
    auto& admitted = current->request;
    current->admitted = true;
    admitted.is_stream = request.method == "GET" && std::ranges::any_of(streams, [&](const auto& stream) {
                             return stream.path == api_path(request);
                         });
    if (!route) return;
    admitted.work = route->work;
    if (route->newest_only) admitted.superseded_by = client.address + ' ' + request.get_param_value("client");
}

void HttpRouter::Impl::handle(const httplib::Request& request, httplib::Response& response) {
    for (const auto& [name, value] : kFields) response.set_header(name, value);
    const report::Texts texts(language_of(request, language));
    const auto client = client_of(request);
    const bool api = request.path.starts_with("/api");
    // The rules come first: a stranger does not learn which routes there are.
    const auto* const route = api ? route_of(request) : nullptr;
    if (const auto why = check(request, client, route && route->changes)) {
        if (why->status == 401) response.set_header("WWW-Authenticate", "Bearer");
        return put(response, refusal(texts, *why));
    }
    if (current->admitting) return admit(request, client, route);
    if (api) return put(response, serve_api(request, client, texts, response));
    serve_page(request, texts, response);
}

void HttpRouter::Impl::serve_page(const httplib::Request& request, const report::Texts& texts,
                                  httplib::Response& response) const {
    const auto* const file = find_page_file(request.path == "/index.html" ? "/" : request.path);
    if (!file) return put(response, refusal(texts, {404, "not_found"}));
    if (method_of(request.method) != Method::get) {
        response.set_header("Allow", "GET, HEAD");
        return put(response, refusal(texts, {405, "method"}));
    }
    response.set_header("ETag", std::string(file->etag));
    response.set_header("Cache-Control", "no-cache");
    response.set_header("Vary", "Accept-Encoding");
    if (request.get_header_value("If-None-Match") == file->etag) {
        response.status = 304;
        return;
    }
    response.status = 200;
    const auto content = current->gzip ? file->gzip : file->plain;
    if (current->gzip) response.set_header("Content-Encoding", "gzip");
    response.set_content(content.data(), content.size(), std::string(file->content_type));
}

ApiResponse HttpRouter::Impl::serve_api(const httplib::Request& request, const ForwardedClient& client,
                                        const report::Texts& texts, httplib::Response& response) const {
    ApiRequest asked{.body = std::move(current->request.body),
                     .texts = texts,
                     .peer = client.address,
                     .stop = current->request.stop};
    for (const auto& [name, value] : request.params)
        if (name != "token") asked.query.emplace(name, value);
    if (const auto* const route = route_of(request)) return execute(*route, asked);
    const auto with_path = [path = api_path(request)](const auto& route) { return route.path == path; };
    const auto stream = std::ranges::find_if(streams, with_path);
    if (stream != streams.end() && request.method == "GET") {
        current->stream = stream->open(asked);
        if (current->stream) return {};
        response.set_header("Retry-After", "5");
        return refusal(texts, {503, "streams"});
    }
    if (stream == streams.end() && std::ranges::none_of(routes, with_path))
        return refusal(texts, {404, "not_found"});
    response.set_header("Allow", stream != streams.end() ? "GET" : "GET, POST, PUT");
    return refusal(texts, {405, "method"});
}

ApiResponse HttpRouter::Impl::execute(const ApiRoute& route, const ApiRequest& request) const {
    try {
        if (!is_utf8(request.body)) return refusal(request.texts, {400, "utf8"});
        return route.handler(request);
    } catch (const std::exception& failure) {
        log(LogLevel::error, "web.handler_failed", failure.what());
        return refusal(request.texts, {500, "internal"});
    }
}

HttpRouter::HttpRouter(GuardPolicy policy, std::vector<Network> proxies, text::Language language,
                       std::vector<ApiRoute> routes, std::vector<StreamRoute> streams, Log log)
    : impl_(std::make_unique<Impl>(std::move(policy), std::move(proxies), language, std::move(routes),
                                   std::move(streams), log)) {}
HttpRouter::~HttpRouter() = default;

std::optional<HttpReply> HttpRouter::admit(HttpRequest& request) const {
    HttpExchange exchange{.request = request, .admitting = true};
    bool closed = false;
    auto text = impl_->process(exchange, request.has_body, closed);
    if (exchange.admitted) return std::nullopt;
    if (text.empty()) return HttpReply{.bytes = bare_reply(400), .close = true};
    return HttpReply{.bytes = std::move(text), .close = closed};
}

HttpReply HttpRouter::reply(HttpRequest request) const {
    HttpExchange exchange{.request = request};
    bool closed = false;
    auto text = impl_->process(exchange, false, closed);
    if (exchange.stream) return {.bytes = stream_head(), .stream = std::move(exchange.stream)};
    // What cpp-httplib itself rejects ends the connection.
    if (text.empty()) return {.bytes = bare_reply(400), .close = true};
    return {.bytes = std::move(text), .close = closed};
}

}  // namespace takt::web
