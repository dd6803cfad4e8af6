#include "subscriber.hpp"

#include <fmt/format.h>
#include <mosquitto.h>

#include <charconv>
#include <chrono>
#include <thread>

#include "../working_folder.hpp"

namespace takt::bench {
namespace {

using namespace std::chrono_literals;

constexpr std::size_t kInFlight = 64;  // as an output
constexpr int kTopics = 1000;

MosquittoPtr new_client(const char* id, void* object) {
    mosquitto_lib_init();
    MosquittoPtr client(mosquitto_new(id, true, object));
    if (!client) throw Failure("libmosquitto does not start");
    mosquitto_int_option(client.get(), MOSQ_OPT_TCP_NODELAY, 1);
    return client;
}

/// The number of a sample in its message; 0: it has none.
std::uint64_t number_of(std::string_view payload) {
    constexpr std::string_view kKey = "\"seq\":";
    const auto at = payload.rfind(kKey);
    if (at == std::string_view::npos) return 0;
    std::uint64_t number = 0;
    payload.remove_prefix(at + kKey.size());
    (void)std::from_chars(payload.data(), payload.data() + payload.size(), number);
    return number;
}

/// The messages of publish_plainly() that are in flight.
struct Publisher {
    std::size_t in_flight = 0;
    bool connected = false;
};

}  // namespace

void MosquittoDelete::operator()(mosquitto* client) const {
    mosquitto_destroy(client);
}

Subscriber::Subscriber(std::uint16_t port) : client_(new_client("bench-subscriber", this)) {
    mosquitto* const client = client_.get();
    mosquitto_message_callback_set(client, [](mosquitto*, void* self, const mosquitto_message* message) {
        static_cast<Subscriber*>(self)->on_message(
            message->topic,
            {static_cast<const char*>(message->payload), static_cast<std::size_t>(message->payloadlen)});
    });
    mosquitto_subscribe_callback_set(client, [](mosquitto*, void* self, int, int, const int*) {
        static_cast<Subscriber*>(self)->subscribed_ = true;
    });
    if (mosquitto_connect(client, "127.0.0.1", port, 60) != MOSQ_ERR_SUCCESS ||
        mosquitto_subscribe(client, nullptr, "#", 1) != MOSQ_ERR_SUCCESS ||
        mosquitto_loop_start(client) != MOSQ_ERR_SUCCESS)
        throw Failure("the subscriber does not connect");
    for (int i = 0; i < 1000 && !subscribed_; ++i) std::this_thread::sleep_for(10ms);
    if (!subscribed_) throw Failure("the subscription is not acknowledged");
}

Subscriber::~Subscriber() {
    mosquitto_disconnect(client_.get());
    mosquitto_loop_stop(client_.get(), true);
}

void Subscriber::on_message(std::string_view topic, std::string_view payload) {
    ++messages_;
    if (!topic.starts_with("plant/")) return;
    const std::uint64_t number = number_of(payload);
    if (number == complete_ + 1 && out_of_order_ == 0)
        complete_ = number;
    else if (number <= complete_ && payload.find("\"repeated\":true") != std::string_view::npos)
        ++repeated_;
    else
        ++out_of_order_;
}

double publish_plainly(std::uint16_t port, std::size_t messages) {
    Publisher state;
    const auto client = new_client("bench-publisher", &state);
    mosquitto_int_option(client.get(), MOSQ_OPT_SEND_MAXIMUM, 0);
    mosquitto_connect_callback_set(
        client.get(), [](mosquitto*, void* self, int) { static_cast<Publisher*>(self)->connected = true; });
    mosquitto_publish_callback_set(
        client.get(), [](mosquitto*, void* self, int) { --static_cast<Publisher*>(self)->in_flight; });
    const auto loop = [&] {
        check_interrupted();
        if (mosquitto_loop(client.get(), 1000, 1) != MOSQ_ERR_SUCCESS) throw Failure("the broker is lost");
    };
    if (mosquitto_connect(client.get(), "127.0.0.1", port, 60) != MOSQ_ERR_SUCCESS)
        throw Failure("the broker cannot be reached");
    while (!state.connected) loop();
    const std::string padding(200, 'x');
    const auto start = std::chrono::steady_clock::now();
    for (std::size_t i = 0; i < messages;) {
        for (; i < messages && state.in_flight < kInFlight; ++i, ++state.in_flight) {
            const auto topic = fmt::format("pace/{}", i % kTopics);
            const auto payload = fmt::format(R"({{"value":{},"text":"{}"}})", i, padding);
            if (mosquitto_publish(client.get(), nullptr, topic.c_str(), static_cast<int>(payload.size()),
                                  payload.data(), 1, true) != MOSQ_ERR_SUCCESS)
                throw Failure("a message is not accepted");
        }
        loop();
    }
    while (state.in_flight > 0) loop();
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    mosquitto_disconnect(client.get());
    return static_cast<double>(messages) / seconds.count();
}

}  // namespace takt::bench
