#include "backlog.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "../journal/plant.hpp"
#include "broker.hpp"
#include "plant_project.hpp"
#include "subscriber.hpp"
#include "takt/store/journal.hpp"
#include "takt/store/posix_journal_storage.hpp"

namespace takt::bench {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

constexpr std::size_t kPlainMessages = 100'000;
constexpr auto kStalled = 60s;  // without a message the run is given up
constexpr std::size_t kWaitingVariables = 1000;

double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

/// A journal as the output of an earlier run leaves it, whose broker was never there.
void fill_journal(const std::string& directory, std::size_t samples) {
    std::filesystem::create_directories(directory);
    const store::JournalOptions options;
    auto storage = store::PosixJournalStorage::open(directory, options.segment_bytes);
    if (!storage) throw Failure("the journal's folder cannot be used");
    const std::string_view names[] = {kOutputName};
    const auto now =
        std::chrono::duration_cast<Duration>(std::chrono::system_clock::now().time_since_epoch());
    Instant t{};
    auto journal = store::Journal::open(**storage, options, names, t, now.count());
    if (!journal) throw Failure("the journal cannot be opened");
    constexpr std::size_t kCollected = 10'000;
    Plant plant(kWaitingVariables, Kind::floating);
    std::int64_t wall = now.count() - Duration(1h).count();
    for (std::size_t done = 0; done < samples; done += kCollected, wall += 1'000'000'000) {
        plant.collect(std::min(kCollected, samples - done), wall, wall + 1'000'000'000,
                      [&](const auto& payload, std::uint64_t count) {
                          t += 10ms;
                          (void)journal->append(t, {.samples = count, .wall_ns = wall, .payload = payload});
                          journal->on_tick(t, wall);
                      });
    }
    if (!journal->close(t) || journal->counters({0}).waiting != samples)
        throw Failure("the journal cannot be written");
}

/// `takt run` of a project; its output goes to a file.
class Program {
public:
    Program(const std::string& program, const std::string& project, const std::string& output) {
        process_ = ::fork();
        if (process_ != 0) return;
        ::prctl(PR_SET_PDEATHSIG, SIGKILL);
        ::dup2(::open(output.c_str(), O_CREAT | O_WRONLY | O_TRUNC, 0600), STDOUT_FILENO);
        ::dup2(STDOUT_FILENO, STDERR_FILENO);
        ::execl(program.c_str(), "takt", "run", project.c_str(), "--json", nullptr);
        ::_exit(127);
    }
    ~Program() {
        if (process_ > 0) end(SIGKILL);
    }
    Program(const Program&) = delete;
    Program& operator=(const Program&) = delete;

    /// KiB; 0 after its end.
    [[nodiscard]] std::uint64_t peak() const {
        std::ifstream status(fmt::format("/proc/{}/status", process_));
        for (std::string word; status >> word;)
            if (std::uint64_t kib = 0; word == "VmHWM:" && status >> kib) return kib;
        return 0;
    }
    /// @returns its processor time in seconds
    double end(int signal) {
        ::kill(process_, signal);
        rusage usage{};
        ::wait4(process_, nullptr, 0, &usage);
        process_ = -1;
        const auto seconds = [](const timeval& time) {
            return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_usec) / 1e6;
        };
        return seconds(usage.ru_utime) + seconds(usage.ru_stime);
    }

private:
    pid_t process_ = -1;
};

/// The output of the summary at the end of a run.
nlohmann::json last_output(const std::string& path) {
    std::ifstream file(path);
    nlohmann::json last;
    for (std::string line; std::getline(file, line);) {
        if (line.find("\"summary\"") == std::string::npos) continue;
        const auto parsed = nlohmann::json::parse(line, nullptr, false);
        if (!parsed.is_discarded() && parsed.contains("outputs")) last = parsed["outputs"][0];
    }
    if (last.is_null()) throw Failure("takt run printed no summary");
    return last;
}

class Run {
public:
    Run(const BacklogOptions& options, const Field& field, const WorkingFolder& folder)
        : options_(options), broker_(folder), directory_(folder.make("backlog")) {
        write_project(directory_ + "/plant.yaml", {.devices = options.devices,
                                                   .variables = options.variables,
                                                   .field_port = field.port(),
                                                   .broker_port = broker_.port()});
    }
    ~Run() { std::filesystem::remove_all(directory_); }
    Run(const Run&) = delete;
    Run& operator=(const Run&) = delete;

    BacklogMeasured run() {
        broker_.start();
        Subscriber subscriber(broker_.port());
        measured_.plain_per_s = publish_plainly(broker_.port(), kPlainMessages);
        measured_.at_start = options_.samples;
        fill_journal(directory_ + "/plant.journal/" + kOutputName, options_.samples);
        const auto start = Clock::now();
        Program program(options_.program, directory_ + "/plant.yaml", directory_ + "/output");
        receive_waiting(subscriber, program);
        receive_new(subscriber, program);
        measured_.processor = program.end(SIGINT) / seconds_since(start);
        wait_for_silence(subscriber);
        finish(subscriber);
        return measured_;
    }

private:
    // The time begins with the first sample: the start of the program is not part of the pace.
    void receive_waiting(const Subscriber& subscriber, const Program& program) {
        wait_until(subscriber, program, [&] { return subscriber.complete() > 0; });
        const auto start = Clock::now();
        const auto first = subscriber.complete();
        wait_until(subscriber, program, [&] { return subscriber.complete() >= options_.samples; });
        measured_.seconds = seconds_since(start);
        measured_.takt_per_s = static_cast<double>(subscriber.complete() - first) / measured_.seconds;
    }

    // Samples that arrived meanwhile, until the subscriber receives only as many as are read.
    void receive_new(const Subscriber& subscriber, const Program& program) {
        const std::uint64_t read = options_.devices * options_.variables;
        auto checked = Clock::now();
        auto before = subscriber.complete();
        wait_until(subscriber, program, [&] {
            if (Clock::now() - checked < 2s) return false;
            checked = Clock::now();
            return std::exchange(before, subscriber.complete()) + 3 * read > subscriber.complete();
        });
    }

    template <class Condition>
    void wait_until(const Subscriber& subscriber, const Program& program, Condition condition) {
        auto messages = subscriber.messages();
        auto progress = Clock::now();
        while (!condition() && subscriber.out_of_order() == 0) {
            check_interrupted();
            std::this_thread::sleep_for(1ms);
            measured_.peak_kib = std::max(measured_.peak_kib, program.peak());
            if (std::exchange(messages, subscriber.messages()) != subscriber.messages())
                progress = Clock::now();
            if (Clock::now() - progress > kStalled) throw Failure("nothing is delivered any more");
        }
    }

    static void wait_for_silence(const Subscriber& subscriber) {
        for (std::uint64_t before = ~0ULL; before != subscriber.messages();) {
            before = subscriber.messages();
            std::this_thread::sleep_for(500ms);
        }
    }

    void finish(const Subscriber& subscriber) {
        measured_.delivered = subscriber.complete();
        measured_.repeated = subscriber.repeated();
        measured_.out_of_order = subscriber.out_of_order();
        const auto output = last_output(directory_ + "/output");
        measured_.at_end = output["sampled"];
        measured_.waiting = output["waiting"];
        measured_.dropped = output["dropped"];
    }

    const BacklogOptions& options_;
    Broker broker_;
    std::string directory_;
    BacklogMeasured measured_;
};

}  // namespace

BacklogMeasured measure_backlog(const BacklogOptions& options, const Field& field,
                                const WorkingFolder& folder) {
    return Run(options, field, folder).run();
}

}  // namespace takt::bench
