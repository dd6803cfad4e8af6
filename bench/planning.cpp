// How long `takt plan --json` takes on large projects, with how much memory.
//
// Each project is written to a file and planned by the program beside this one, in a process of its own. One
// line for each: project, lines, variables, whether it is feasible, seconds from start to end, peak memory,
// and whether both limits hold: 2 s and 500 MB (docs/planning.md, "Large projects"). The exit code is 1 if a
// limit is exceeded.
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace {

using Clock = std::chrono::steady_clock;

constexpr double kMostSeconds = 2;
constexpr double kMostMegabytes = 500;
constexpr int kNotStarted = 127;  // exit status of a shell

/// A project of equal devices.
struct Shape {
    const char* name = "";
    std::size_t lines = 1;
    std::size_t devices = 1;    // of each line
    std::size_t variables = 1;  // of each device
    const char* period = "1s";
    unsigned baud = 115200;
    std::size_t step = 1;  // from one register to the next
    const char* strategy = "classic";
    bool distinct_periods = false;

    [[nodiscard]] std::size_t count() const { return lines * devices * variables; }
};

const std::vector<Shape>& shapes() {
    static const std::vector<Shape> kShapes{
        {.name = "64 lines", .lines = 64, .devices = 2, .variables = 5},
        {.name = "64 lines, late",
         .lines = 64,
         .devices = 2,
         .variables = 5,
         .period = "20ms",
         .baud = 2400,
         .step = 3},
        {.name = "256 lines", .lines = 256, .devices = 2, .variables = 5},
        {.name = "256 lines, late",
         .lines = 256,
         .devices = 2,
         .variables = 5,
         .period = "20ms",
         .baud = 2400,
         .step = 3},
        {.name = "1,024 lines", .lines = 1024, .devices = 2, .variables = 5},
        {.name = "1,024 lines, late",
         .lines = 1024,
         .devices = 2,
         .variables = 5,
         .period = "20ms",
         .baud = 2400,
         .step = 3},
        {.name = "88,000 in one line", .devices = 44, .variables = 2000, .period = "60s"},
        {.name = "88,000 in one line, late", .devices = 44, .variables = 2000, .period = "100ms"},
        {.name = "88,000 optimal",
         .devices = 44,
         .variables = 2000,
         .period = "60s",
         .step = 3,
         .strategy = "optimal"},
        {.name = "88,000 optimal, late",
         .devices = 44,
         .variables = 2000,
         .period = "100ms",
         .step = 3,
         .strategy = "optimal"},
        {.name = "88,000 in many lines", .lines = 440, .devices = 2, .variables = 100},
        {.name = "88,000 in many lines, late",
         .lines = 440,
         .devices = 2,
         .variables = 100,
         .period = "20ms",
         .baud = 9600,
         .step = 3},
        {.name = "100,000 in 100 lines, late", .lines = 100, .devices = 10, .variables = 100, .step = 3},
        {.name = "100,000, far too slow",
         .lines = 100,
         .devices = 10,
         .variables = 100,
         .period = "20ms",
         .baud = 9600,
         .step = 3},
        {.name = "65,000 distinct periods",
         .devices = 26,
         .variables = 2500,
         .step = 2,
         .distinct_periods = true},
    };
    return kShapes;
}

void write_device(std::ofstream& file, const Shape& shape, std::size_t address, std::size_t& number) {
    file << fmt::format(
        "      - name: D{0}\n        address: {0}\n        poll_period: {1}\n        group_requests: true\n"
        "        strategy: {2}\n        turnaround: 2ms\n        variables:\n",
        address, shape.period, shape.strategy);
    for (std::size_t v = 0; v < shape.variables; ++v) {
        ++number;
        const auto period = shape.distinct_periods ? fmt::format(", period: {}ms", number) : std::string();
        file << fmt::format("          - {{name: v{}, type: int16, register: {}, read: 0x03{}}}\n", number,
                            v * shape.step, period);
    }
}

void write_project(const std::string& path, const Shape& shape) {
    std::ofstream file(path);
    file << "takt: 1\nlines:\n";
    std::size_t number = 0;
    for (std::size_t l = 0; l < shape.lines; ++l) {
        file << fmt::format(
            "  - name: L{}\n    transport: simulated\n    framing: rtu\n    baud: {}\n    parity: none\n"
            "    devices:\n",
            l, shape.baud);
        for (std::size_t d = 1; d <= shape.devices; ++d) write_device(file, shape, d, number);
    }
}

struct Measured {
    double seconds = 0;
    double megabytes = 0;
    int status = 0;

    [[nodiscard]] bool feasible() const { return WIFEXITED(status) && WEXITSTATUS(status) == 0; }
    /// 1: the project has late values.
    [[nodiscard]] bool ended() const { return WIFEXITED(status) && WEXITSTATUS(status) <= 1; }
    [[nodiscard]] bool holds() const { return seconds <= kMostSeconds && megabytes <= kMostMegabytes; }
};

[[noreturn]] void become_program(const std::string& program, const std::string& project) {
    const int nowhere = ::open("/dev/null", O_WRONLY);
    ::dup2(nowhere, STDOUT_FILENO);
    ::dup2(nowhere, STDERR_FILENO);
    ::execl(program.c_str(), "takt", "plan", project.c_str(), "--json", nullptr);
    ::_exit(kNotStarted);
}

Measured measure(const std::string& program, const std::string& project) {
    const auto start = Clock::now();
    const pid_t child = ::fork();
    if (child == 0) become_program(program, project);
    Measured measured;
    rusage usage{};
    ::wait4(child, &measured.status, 0, &usage);
    measured.seconds = std::chrono::duration<double>(Clock::now() - start).count();
    measured.megabytes = static_cast<double>(usage.ru_maxrss) * 1024 / 1e6;
    return measured;
}

void print_row(const Shape& shape, const Measured& measured) {
    fmt::print("{:<28}{:>6}{:>11}{:>10}{:>10.2f}{:>8.0f}  {}\n", shape.name, shape.lines, shape.count(),
               measured.feasible() ? "yes" : "no", measured.seconds, measured.megabytes,
               !measured.ended()  ? "failed"
               : measured.holds() ? "holds"
                                  : "exceeded");
    std::fflush(stdout);
}

std::string row_json(const Shape& shape, const Measured& measured) {
    return fmt::format(R"({{"project":"{}","lines":{},"variables":{},"feasible":{},)"
                       R"("seconds":{:.3f},"megabytes":{:.1f},"holds":{}}})",
                       shape.name, shape.lines, shape.count(), measured.feasible(), measured.seconds,
                       measured.megabytes, measured.ended() && measured.holds());
}

}  // namespace

int main(int count, char** arguments) {
    const bool json = count > 1 && std::strcmp(arguments[1], "--json") == 0;
    const auto program = std::filesystem::read_symlink("/proc/self/exe").parent_path() / "takt";
    std::string folder = std::filesystem::temp_directory_path() / "takt-planning-XXXXXX";
    if (!::mkdtemp(folder.data())) return 2;
    const std::string project = folder + "/project.yaml";
    if (!json)
        fmt::print("{:<28}{:>6}{:>11}{:>10}{:>10}{:>8}\n", "project", "lines", "variables", "feasible",
                   "seconds", "MB");
    std::string rows;
    bool all_hold = true;
    for (const Shape& shape : shapes()) {
        write_project(project, shape);
        const auto measured = measure(program, project);
        all_hold = all_hold && measured.ended() && measured.holds();
        if (json)
            rows += (rows.empty() ? "" : ",") + row_json(shape, measured);
        else
            print_row(shape, measured);
    }
    std::filesystem::remove_all(folder);
    if (json) fmt::print("{{\"planning\":[{}]}}\n", rows);
    return all_hold ? 0 : 1;
}
