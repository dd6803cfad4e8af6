// The signals are blocked except while ppoll() waits, so that none is missed between the check and the wait.
#include "stoppable_input.hpp"

#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <utility>

#include "stop_signals.hpp"
#include "takt/os/open.hpp"

namespace takt::app {
namespace {

std::atomic<bool> g_stop_requested = false;

void stop(int) {
    g_stop_requested = true;
}

sigset_t take_signals() {
    sigset_t set;
    ::sigemptyset(&set);
    for (const int signal : stop_signals()) {
        ::sigaddset(&set, signal);
        struct sigaction action{};
        action.sa_handler = stop;
        ::sigaction(signal, &action, nullptr);
    }
    return set;
}

}  // namespace

Result<StoppableInput> StoppableInput::open(const std::string& path) {
    if (path == "-") return StoppableInput("stdin", {}, STDIN_FILENO);
    TAKT_TRY(auto file, os::open_stream(path));
    const int number = file.get();
    return StoppableInput(path, std::move(file), number);
}

StoppableInput StoppableInput::around(std::string name, int descriptor) {
    return StoppableInput(std::move(name), {}, descriptor);
}

StoppableInput::StoppableInput(std::string path, os::Descriptor file, int number)
    : path_(std::move(path)), file_(std::move(file)), number_(number) {
    struct stat status{};
    if (::fstat(number_, &status) == 0 && S_ISREG(status.st_mode))
        size_ = static_cast<std::uint64_t>(status.st_size);
    taken_ = take_signals();
    ::pthread_sigmask(SIG_BLOCK, &taken_, &before_);
}

StoppableInput::StoppableInput(StoppableInput&& other) noexcept
    : path_(std::move(other.path_)),
      file_(std::move(other.file_)),
      number_(other.number_),
      size_(other.size_),
      owns_(std::exchange(other.owns_, false)),
      taken_(other.taken_),
      before_(other.before_) {}

StoppableInput::~StoppableInput() {
    if (!owns_) return;
    for (const int signal : {SIGINT, SIGTERM, SIGHUP})
        if (::sigismember(&taken_, signal) == 1) ::signal(signal, SIG_DFL);
    ::pthread_sigmask(SIG_SETMASK, &before_, nullptr);
}

bool StoppableInput::stopped() {
    return g_stop_requested;
}

// ppoll() lets no pending signal in while the input is readable.
bool StoppableInput::is_stopped() const {
    constexpr timespec kAtOnce{};
    if (::sigtimedwait(&taken_, nullptr, &kAtOnce) > 0) g_stop_requested = true;
    return g_stop_requested;
}

Result<bool> StoppableInput::wait(Duration limit) {
    if (is_stopped()) return false;
    const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(limit);
    const timespec time{.tv_sec = seconds.count(), .tv_nsec = (limit - seconds).count()};
    pollfd waited{.fd = number_, .events = POLLIN, .revents = 0};
    const int count = ::ppoll(&waited, 1, &time, &before_);
    if (count < 0 && errno != EINTR) return fail(Code::io_failed, path_, errno);
    return count > 0 && !g_stop_requested;
}

Result<std::size_t> StoppableInput::read(std::span<std::uint8_t> storage) {
    while (!is_stopped()) {
        pollfd waited{.fd = number_, .events = POLLIN, .revents = 0};
        if (::ppoll(&waited, 1, nullptr, &before_) < 0) {
            if (errno == EINTR) continue;
            return fail(Code::io_failed, path_, errno);
        }
        const auto count = ::read(number_, storage.data(), storage.size());
        if (count >= 0) return static_cast<std::size_t>(count);
        if (errno != EINTR && errno != EAGAIN) return fail(Code::io_failed, path_, errno);
    }
    return std::size_t{0};
}

}  // namespace takt::app
