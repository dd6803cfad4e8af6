// Arbitrary bytes with times on a line that is listened to. Each byte is reported once, each request has one
// end, and what was heard makes a project within its bounds.
//
// The first byte chooses framing and character time. Then pieces: time since the last one in units of 50 us,
// length, bytes. A length of 255 is a tick.
#include "input.hpp"
#include "takt/capture/heard_project.hpp"
#include "takt/capture/line_listener.hpp"

namespace {

using namespace takt;

struct Count final : capture::ListenObserver {
    std::uint64_t exchanges = 0;
    std::uint64_t strays = 0;
    std::uint64_t damaged_bytes = 0;
    void on_exchange(const capture::Exchange& exchange) override {
        ++exchanges;
        fuzz::require(exchange.response_time >= Duration::zero());
        fuzz::require(!exchange.request.pdu.empty());
    }
    void on_stray(const capture::LineFrame& frame) override {
        ++strays;
        fuzz::require(frame.begin <= frame.end);
    }
    void on_damaged(const capture::DamagedBytes& damaged) override {
        damaged_bytes += damaged.bytes.size();
        fuzz::require(!damaged.bytes.empty());
    }
};

void judge(const capture::LineStatistics& statistics, const Count& count) {
    const auto& counts = statistics.counts();
    fuzz::require(counts.requests == counts.responses + counts.unanswered + counts.broadcasts + counts.open);
    fuzz::require(count.exchanges == counts.requests && count.strays == counts.strays);
    fuzz::require(counts.frames == counts.requests + counts.responses + counts.strays);
    fuzz::require(count.damaged_bytes == counts.damaged_bytes);
    const auto project = capture::heard_project(statistics, {});
    fuzz::require(project.line.devices.size() <= 247);
    for (const auto& device : project.line.devices)
        fuzz::require(device.variables.size() <= capture::kMostVariables);
    (void)statistics.masters();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    fuzz::Input input({data, size});
    const auto choice = input.byte();
    capture::ListenConfig config;
    config.frames.framing = (choice & 1) != 0 ? wire::Framing::ascii : wire::Framing::rtu;
    config.frames.character = std::chrono::microseconds((choice >> 1 & 3) * 500);
    config.frames.known_only = (choice & 8) != 0;
    Count count;
    capture::LineListener listener(config, count);
    Instant t{};
    while (!input.empty()) {
        constexpr std::uint8_t kTick = 255;
        t += std::chrono::microseconds(50) * input.word();
        const auto length = input.byte();
        if (length == kTick)
            listener.on_tick(t);
        else
            listener.on_bytes(t, fuzz::Exact(input.bytes(length)).span());
        fuzz::require(listener.next_wakeup() > t - std::chrono::hours(1));
    }
    listener.end();
    judge(listener.statistics(), count);
    return 0;
}
