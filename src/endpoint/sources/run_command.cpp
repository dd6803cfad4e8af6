// Runs a process with its output on a pipe. It ends by itself, at the time-out, or at the limit of output.
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>

#include "sources/outside.hpp"
#include "takt/endpoint/answer.hpp"

namespace takt::endpoint {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

constexpr auto kLookAtStop = 50ms;

struct Spawned {
    pid_t pid = 0;
    int output = -1;
};

int spawn(const model::Command& command, int output, pid_t& pid) {
    posix_spawn_file_actions_t actions;
    posix_spawnattr_t attributes;
    ::posix_spawn_file_actions_init(&actions);
    ::posix_spawnattr_init(&attributes);
    ::posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    ::posix_spawn_file_actions_adddup2(&actions, output, STDOUT_FILENO);
    ::posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
    ::posix_spawn_file_actions_addclosefrom_np(&actions, STDERR_FILENO + 1);
    sigset_t none;
    sigset_t all;
    ::sigemptyset(&none);
    ::sigfillset(&all);
    ::posix_spawnattr_setsigmask(&attributes, &none);
    ::posix_spawnattr_setsigdefault(&attributes, &all);
    ::posix_spawnattr_setpgroup(&attributes, 0);
    ::posix_spawnattr_setflags(&attributes,
                               POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP);
    std::vector<char*> arguments;
    for (const auto& argument : command.run) arguments.push_back(const_cast<char*>(argument.c_str()));
    arguments.push_back(nullptr);
    const int error = ::posix_spawnp(&pid, arguments[0], &actions, &attributes, arguments.data(), environ);
    ::posix_spawnattr_destroy(&attributes);
    ::posix_spawn_file_actions_destroy(&actions);
    return error;
}

Result<Spawned> start(const model::Command& command) {
    int ends[2];
    if (::pipe2(ends, O_CLOEXEC) != 0) return fail(Code::cannot_open, command.run[0], errno);
    Spawned spawned{.output = ends[0]};
    const int error = spawn(command, ends[1], spawned.pid);
    ::close(ends[1]);
    if (error == 0) {
        ::fcntl(ends[0], F_SETFL, O_NONBLOCK);
        return spawned;
    }
    ::close(ends[0]);
    return fail(Code::cannot_open, command.run[0], error);
}

/// Reads the available output. @returns false at its end
bool drain(int output, std::string& text) {
    while (text.size() <= kMostText) {
        std::array<char, 4096> buffer;
        const auto count = ::read(output, buffer.data(), buffer.size());
        if (count > 0) text.append(buffer.data(), static_cast<std::size_t>(count));
        if (count < 0 && errno == EINTR) continue;
        if (count <= 0) return count < 0 && errno == EAGAIN;
    }
    return true;
}

enum class End { exited, timed_out, too_long };

End follow(const Spawned& spawned, Clock::time_point deadline, const StopFlag& stop, std::string& text) {
    const int process = static_cast<int>(::syscall(SYS_pidfd_open, spawned.pid, 0));
    bool open = true;
    End end = End::timed_out;
    while (!stop && Clock::now() < deadline) {
        const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - Clock::now());
        // Without pidfd_open() (kernels before 5.3) the end of the process is polled.
        std::array<pollfd, 2> watched{{{process, POLLIN, 0}, {open ? spawned.output : -1, POLLIN, 0}}};
        ::poll(watched.data(), watched.size(),
               static_cast<int>(std::clamp(left, 0ms, kLookAtStop + 0ms).count()));
        if (open) open = drain(spawned.output, text);
        if (text.size() > kMostText) {
            end = End::too_long;
            break;
        }
        siginfo_t info{};
        if (::waitid(P_PID, static_cast<id_t>(spawned.pid), &info, WEXITED | WNOHANG | WNOWAIT) == 0 &&
            info.si_pid != 0) {
            drain(spawned.output, text);
            end = text.size() > kMostText ? End::too_long : End::exited;
            break;
        }
    }
    if (process >= 0) ::close(process);
    return end;
}

}  // namespace

Result<std::string> run_command(const model::Command& command, const StopFlag& stop) {
    if (command.run.empty()) return fail(Code::not_found);
    TAKT_TRY(const auto spawned, start(command));
    std::string text;
    const End end = follow(spawned, Clock::now() + command.timeout, stop, text);
    ::kill(-spawned.pid, SIGKILL);  // the whole group; the pid stays reserved until waitpid()
    int status = 0;
    while (::waitpid(spawned.pid, &status, 0) < 0 && errno == EINTR) {}
    ::close(spawned.output);
    const auto& program = command.run[0];
    if (end == End::timed_out)
        return fail(Code::timed_out, program, command.timeout / std::chrono::milliseconds(1));
    if (end == End::too_long) return fail(Code::too_long, program, static_cast<std::int64_t>(kMostText));
    constexpr int kSignalled = 128;
    const int code = WIFEXITED(status) ? WEXITSTATUS(status) : kSignalled + WTERMSIG(status);
    if (code != 0) return fail(Code::io_failed, program, code);
    text.erase(text.find_last_not_of("\r\n") + 1);
    return text;
}

}  // namespace takt::endpoint
