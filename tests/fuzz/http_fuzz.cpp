// Arbitrary bytes, cut into arbitrary pieces, as the browser of a page: each request is admitted by the rules
// before it is executed, has the body that it announced, and each answer is one of HTTP/1.1.
#include <chrono>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "http/http_connection.hpp"
#include "http/http_router.hpp"
#include "input.hpp"

namespace {

using namespace takt;
using namespace takt::web;

HttpRouter make_router() {
    const auto echo = [](const ApiRequest& request) {
        auto object = file::Json::object();
        for (const auto& [name, value] : request.query) object.set(name, value);
        object.set("body", request.body.size());
        return ApiResponse::json(object);
    };
    return HttpRouter({.token = "token", .allow_write = true}, {*parse_network("10.0.0.1")},
                      text::Language::english,
                      {{.path = "/echo", .handler = echo},
                       {.method = Method::post, .path = "/echo", .changes = true, .handler = echo}},
                      {}, {});
}

class Browser {
public:
    explicit Browser(const char* peer)
        : connection_({}, peer, t_,
                      {.admit = [this](HttpRequest& request) { return admit(request); },
                       .execute = [this](HttpRequest request) { return execute(std::move(request)); },
                       .reserve = [](std::string_view, std::ptrdiff_t) { return 0; },
                       .input_ended = [] {},
                       .destroyed = [] {}}) {
        connection_.engine().on_link(t_, true);
    }

    void send(Bytes bytes) {
        const fuzz::Exact exact(bytes);
        connection_.engine().on_bytes(t_, exact.span());
    }
    void wait(Duration time) {
        t_ += time;
        connection_.engine().on_tick(t_);
    }
    /// Executes what waits, and takes the answers.
    void receive() {
        do {
            if (waiting_) connection_.answer(router_.reply(*std::exchange(waiting_, std::nullopt)));
            std::string answer;
            for (auto bytes = connection_.engine().transmit(t_); !bytes.empty();
                 bytes = connection_.engine().transmit(t_))
                answer.append(bytes.begin(), bytes.end());
            fuzz::require(answer.empty() || answer.starts_with("HTTP/1.1 "));
        } while (waiting_);
    }

private:
    std::optional<HttpReply> admit(HttpRequest& request) {
        fuzz::require(request.head.path.starts_with('/') && !request.head.method.empty());
        fuzz::require(request.head.body_bytes <= HeadLimits{}.body_bytes);
        auto refusal = router_.admit(request);
        admitted_ = !refusal;
        return refusal;
    }
    int execute(HttpRequest request) {
        fuzz::require(std::exchange(admitted_, false) && !waiting_);
        fuzz::require(request.body.size() == request.head.body_bytes);
        waiting_ = std::move(request);
        return 0;
    }

    Instant t_{std::chrono::seconds(1)};
    HttpRouter router_ = make_router();
    bool admitted_ = false;
    std::optional<HttpRequest> waiting_;
    HttpConnection connection_;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    fuzz::Input input({data, size});
    Browser browser(input.byte() % 2 == 0 ? "10.0.0.1:1" : "10.0.0.5:1");
    while (!input.empty()) {
        const auto piece = input.byte();
        if (piece == 0xFF)
            browser.wait(std::chrono::milliseconds(input.word()));
        else
            browser.send(input.bytes(piece + std::size_t{1}));
        if (piece % 4 != 0) browser.receive();
    }
    browser.receive();
    return 0;
}
