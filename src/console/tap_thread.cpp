#include "takt/console/tap_thread.hpp"

#include <chrono>
#include <utility>
#include "takt/os/thread_name.hpp"

namespace takt::console {
namespace {

constexpr auto kTick = std::chrono::milliseconds(20);  // the ring holds the frames of a longer time

}  // namespace

TapSource tap_source(const std::shared_ptr<host::Session>& session) {
    return {.next = [session] { return session->next_traffic(); },
            .missed = [session] { return session->missed_traffic(); },
            .line_of = [session](const auto& record) { return session->line_of(record); }};
}

TapSource tap_source(const host::TrafficTap& tap) {
    const auto reader = std::make_shared<host::TrafficTap::Reader>(tap.reader());
    return {.next = [reader] { return reader->next(); },
            .missed = [reader] { return reader->missed(); },
            .line_of = [reader](const auto& record) { return reader->line_of(record); }};
}

TapThread::TapThread(Turn turn) : turn_(std::move(turn)), thread_([this] { work(); }) {}

TapThread::~TapThread() {
    {
        const std::lock_guard lock(mutex_);
        ending_ = true;
    }
    changed_.notify_all();
    thread_.join();
}

void TapThread::work() {
    os::name_thread("takt-tap");
    for (bool ending = false; !ending;) {
        {
            std::unique_lock lock(mutex_);
            ending = changed_.wait_for(lock, kTick, [this] { return ending_; });
        }
        turn_(ending);
    }
}

}  // namespace takt::console
