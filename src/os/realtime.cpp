// The order of the steps: what may take long comes before the thread is scheduled before all others.
#include "takt/os/realtime.hpp"

#include <fcntl.h>
#include <malloc.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstddef>

#include "takt/os/descriptor.hpp"

namespace takt::os {
namespace {

int error_of(int result) {
    return result == 0 ? 0 : errno;
}

// Pages that exist are brought in and locked at once. Later ones are locked when they are first used: the
// stack of a thread is 8 MB long, and few threads use more than some pages.
int lock_memory() {
    if (::mlockall(MCL_CURRENT) != 0) return errno;
    return error_of(::mlockall(MCL_CURRENT | MCL_FUTURE | MCL_ONFAULT));
}

// Touches the part of the stack that the thread may need later.
[[gnu::noinline]] void touch_stack() {
    constexpr std::size_t kPage = 4096;
    constexpr std::size_t kPages = 64;
    std::array<volatile std::byte, kPages * kPage> stack;
    for (std::size_t i = 0; i < stack.size(); i += kPage) stack[i] = std::byte{0};
}

// mallopt() has no errno.
int keep_memory() {
    touch_stack();
    constexpr int kNever = -1;
    return ::mallopt(M_TRIM_THRESHOLD, kNever) == 1 ? 0 : ENOTSUP;
}

// The request ends when the descriptor is closed: the kernel's documentation, admin-guide/pm/cpuidle,
// "Power Management Quality of Service for CPUs".
int hold_idle_states() {
    static Descriptor device;
    device.reset(::open("/dev/cpu_dma_latency", O_WRONLY | O_CLOEXEC));
    if (!device) return errno;
    const std::int32_t microseconds = 0;
    if (::write(device.get(), &microseconds, sizeof microseconds) == sizeof microseconds) return 0;
    const int error = errno;
    device.reset();
    return error;
}

int take_processor(int cpu) {
    if (cpu < 0 || cpu >= CPU_SETSIZE) return EINVAL;
    cpu_set_t only;
    CPU_ZERO(&only);
    CPU_SET(static_cast<unsigned>(cpu), &only);
    return error_of(::sched_setaffinity(0, sizeof only, &only));
}

int end_timer_slack() {
    constexpr unsigned long kNanoseconds = 1;  // 0 would mean the default
    return error_of(::prctl(PR_SET_TIMERSLACK, kNanoseconds, 0, 0, 0));
}

int schedule_first(int priority) {
    const sched_param parameter{.sched_priority = priority};
    return error_of(::sched_setscheduler(0, SCHED_FIFO | SCHED_RESET_ON_FORK, &parameter));
}

}  // namespace

std::string_view name(RealtimeStep step) {
    switch (step) {
        case RealtimeStep::lock_memory: return "lock_memory";
        case RealtimeStep::keep_memory: return "keep_memory";
        case RealtimeStep::idle_states: return "idle_states";
        case RealtimeStep::processor: return "processor";
        case RealtimeStep::timer_slack: return "timer_slack";
        case RealtimeStep::scheduling: return "scheduling";
    }
    return "lock_memory";
}

std::vector<RealtimeResult> become_realtime(const RealtimeOptions& options) {
    std::vector<RealtimeResult> results;
    if (options.priority) {
        results.push_back({RealtimeStep::lock_memory, lock_memory()});
        results.push_back({RealtimeStep::keep_memory, keep_memory()});
        results.push_back({RealtimeStep::idle_states, hold_idle_states()});
    }
    if (options.cpu) results.push_back({RealtimeStep::processor, take_processor(*options.cpu)});
    if (options.priority) {
        results.push_back({RealtimeStep::timer_slack, end_timer_slack()});
        results.push_back({RealtimeStep::scheduling, schedule_first(*options.priority)});
    }
    return results;
}

}  // namespace takt::os
