#include "program.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "field.hpp"
#include "takt/line/loop.hpp"

namespace takt::bench {
namespace {

using namespace std::chrono_literals;

void write_project(const std::string& path, std::size_t devices, std::uint16_t port) {
    std::ofstream file(path);
    file << "takt: 1\nlines:\n";
    for (std::size_t i = 0; i < devices; ++i)
        file << fmt::format(
            "- {{name: L{0}, transport: tcp, framing: tcp, host: {1}, tcp_port: {2}, devices: [{{name: D{0}, "
            "address: 1, poll_period: 1s, response_timeout: 500ms, variables: [{{name: V{0}, type: int16, "
            "register: 0, read: 3}}]}}]}}\n",
            i, device_address(i), port);
}

std::string last_line(const std::string& path) {
    std::ifstream file(path);
    std::string line, last;
    while (std::getline(file, line))
        if (line.find("\"summary\"") != std::string::npos) last = line;
    return last;
}

constexpr int kNotStarted = 127;  // exit status of a shell

/// Why there are no figures; empty: there are.
std::string why_failed(int status, const std::string& talk, bool summarised) {
    if (WIFSIGNALED(status)) return fmt::format("ended by signal {}", WTERMSIG(status));
    const int code = WEXITSTATUS(status);
    if (code == kNotStarted) return "could not be started: " + talk;
    if (code != 0) return fmt::format("exit code {}: {}", code, talk);
    return summarised ? "" : "no summary in its output; it said: " + talk;
}

std::string beginning_of(const std::string& path) {
    constexpr std::size_t kMost = 1000;
    std::ifstream file(path);
    std::string text(kMost, '\0');
    file.read(text.data(), static_cast<std::streamsize>(kMost));
    text.resize(static_cast<std::size_t>(file.gcount()));
    return text;
}

struct Call {
    std::string program;
    std::string project;
    std::string duration;
    std::string output;  // files
    std::string talk;
};

[[noreturn]] void become_program(const Call& call, int processor) {
    pin_to_processor(processor);
    ::dup2(::open(call.output.c_str(), O_CREAT | O_WRONLY | O_TRUNC, 0600), STDOUT_FILENO);
    ::dup2(::open(call.talk.c_str(), O_CREAT | O_WRONLY | O_TRUNC, 0600), STDERR_FILENO);
    ::execl(call.program.c_str(), "takt", "run", call.project.c_str(), "--json", "--for",
            call.duration.c_str(), nullptr);
    std::perror(call.program.c_str());
    ::_exit(kNotStarted);
}

double seconds(const timeval& time) {
    return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_usec) / 1e6;
}

}  // namespace

std::expected<ProgramMeasured, std::string> run_program(const std::string& program, std::size_t devices,
                                                        Duration time, std::uint16_t port, int processor) {
    char directory[] = "/tmp/takt-scale-XXXXXX";
    if (!::mkdtemp(directory)) return std::unexpected(std::string("no directory for the project"));
    const std::string project = std::string(directory) + "/scale.yaml";
    const std::string output = std::string(directory) + "/output.json";
    const std::string talk = std::string(directory) + "/talk.txt";
    write_project(project, devices, port);
    const std::string duration = fmt::format("{}s", time / 1s);
    const pid_t process = ::fork();
    if (process == 0) become_program({program, project, duration, output, talk}, processor);
    const Instant start = line::now();
    int status = 0;
    rusage usage{};
    ::wait4(process, &status, 0, &usage);
    ProgramMeasured measured;
    measured.seconds = static_cast<double>((line::now() - start).count()) / 1e9;
    measured.processor = (seconds(usage.ru_utime) + seconds(usage.ru_stime)) / measured.seconds;
    measured.peak_kib = static_cast<std::uint64_t>(usage.ru_maxrss);
    const auto summary = nlohmann::json::parse(last_line(output), nullptr, false);
    const std::string failure = why_failed(status, beginning_of(talk), !summary.is_discarded());
    std::filesystem::remove_all(directory);
    if (!failure.empty()) return std::unexpected(failure);
    for (const auto& line : summary["lines"])
        for (const auto& request : line["requests"]) {
            measured.sent += request["counters"]["sent"].get<std::uint64_t>();
            measured.answered += request["counters"]["answered"].get<std::uint64_t>();
            measured.missed += request["skipped"].get<std::uint64_t>();
            measured.overruns += request["overrun"].get<bool>() ? 1U : 0U;
        }
    return measured;
}

}  // namespace takt::bench
