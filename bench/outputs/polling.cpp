#include "polling.hpp"

#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <thread>
#include <utility>

#include "broker.hpp"
#include "plant_project.hpp"
#include "poll_times.hpp"
#include "takt/host/project_file.hpp"
#include "takt/host/project_host.hpp"
#include "takt/line/loop.hpp"
#include "takt/plan/plan.hpp"
#include "takt/publish/outputs.hpp"
#include "takt/publish/project_outputs.hpp"

namespace takt::bench {
namespace {

using namespace std::chrono_literals;

constexpr Duration kPeriod = 1s;
constexpr auto kConnectLimit = 90s;  // an output pauses up to 60 s between two attempts

double processor_seconds() {
    rusage usage{};
    ::getrusage(RUSAGE_SELF, &usage);
    const auto seconds = [](const timeval& time) {
        return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_usec) / 1e6;
    };
    return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

double microseconds(const std::vector<Duration>& ascending, double part) {
    if (ascending.empty()) return 0;
    const auto index = static_cast<std::size_t>(part * static_cast<double>(ascending.size() - 1));
    return static_cast<double>(ascending[index].count()) / 1e3;
}

class Run {
public:
    Run(const PollingOptions& options, const Field& field, const WorkingFolder& folder)
        : options_(options), broker_(folder), directory_(folder.make("polling")) {
        write_project(project_file(), {.devices = options.devices,
                                       .variables = options.variables,
                                       .field_port = field.port(),
                                       .broker_port = broker_.port()});
        auto loaded = host::load_project(project_file());
        if (loaded.has_errors()) throw Failure("the project has errors");
        auto plan = plan::make_plan(loaded.project);
        auto started =
            host::ProjectHost::start(loaded.project, std::move(plan), {.project_file = project_file()});
        if (!started) throw Failure("the host does not start");
        host_ = *std::move(started);
        auto tap = host_->open_session({.traffic = true, .from_beginning = true});
        if (!tap) throw Failure("no session");
        times_.emplace(*std::move(tap), options.devices, kPeriod);
    }
    ~Run() {
        times_.reset();
        host_->stop();
        outputs_.reset();
        std::filesystem::remove_all(directory_);
    }
    Run(const Run&) = delete;
    Run& operator=(const Run&) = delete;

    PollingRun run() {
        wait(3s);  // all connections are there, and the first requests are out
        measure("without outputs");
        start_outputs();
        wait(1s);
        measure("dead");
        broker_.start();
        wait_until([this] { return status().state == publish::OutputState::delivering; });
        broker_.slow_down();
        measure("slow");
        broker_.freeze();
        measure("hangs");
        broker_.wake();
        measure("back");
        wait_until([this] { return status().samples.waiting < options_.devices * options_.variables; });
        measure("delivering");
        outputs_->stop();
        measure("without again");
        return finish();
    }

private:
    [[nodiscard]] std::string project_file() const { return directory_ + "/plant.yaml"; }

    void start_outputs() {
        const auto open_session = [host = host_.get()](const host::SessionOptions& wanted) {
            return host->open_session(wanted);
        };
        auto session = open_session({});
        if (!session) throw Failure("no session");
        outputs_.emplace(*std::move(session),
                         [options = publish::ProjectOutputsOptions{.project_file = project_file(),
                                                                   .open_session = open_session,
                                                                   .log = {}}](const auto& configuration) {
                             return publish::project_outputs(options, configuration);
                         });
    }

    [[nodiscard]] publish::OutputStatus status() const {
        if (!outputs_) return {};
        const auto all = outputs_->status();
        return all.empty() ? publish::OutputStatus{} : all.front();
    }

    static void wait(Duration time) {
        const Instant end = line::now() + time;
        while (line::now() < end) {
            check_interrupted();
            std::this_thread::sleep_for(std::min<Duration>(100ms, end - line::now()));
        }
    }

    template <class Condition>
    void wait_until(Condition condition) {
        const Instant end = line::now() + kConnectLimit;
        while (!condition()) {
            if (line::now() > end) throw Failure("the output does not deliver: " + status().failure);
            wait(100ms);
        }
    }

    void measure(const std::string& name) {
        const auto before = status();
        const double used = processor_seconds();
        const Instant start = line::now();
        wait(std::chrono::seconds(options_.seconds));
        const Instant end = line::now();
        const double seconds = static_cast<double>((end - start).count()) / 1e9;
        const auto after = status();
        const auto rate = [&](std::uint64_t publish::OutputSamples::* what) {
            return static_cast<double>(after.samples.*what - before.samples.*what) / seconds;
        };
        PhaseMeasured phase{.name = name};
        phase.processor = (processor_seconds() - used) / seconds;
        phase.sampled = rate(&publish::OutputSamples::sampled);
        phase.delivered = rate(&publish::OutputSamples::delivered);
        phase.waiting = after.samples.waiting;
        phase.dropped = after.samples.dropped;
        phases_.emplace_back(std::move(phase), std::pair(start, end));
    }

    PollingRun finish() {
        PollingRun all;
        for (auto& [phase, range] : phases_) {
            const auto window = times_->window(range.first, range.second);
            phase.polls = window.lateness.size();
            phase.missed = window.missed;
            phase.p50_us = microseconds(window.lateness, 0.5);
            phase.p99_us = microseconds(window.lateness, 0.99);
            phase.most_us = microseconds(window.lateness, 1);
            phase.usual_p99_us = usual_p99(range.first, range.second);
            all.push_back(std::move(phase));
        }
        if (times_->repetitions() + times_->lost() > 0)
            fmt::print(stderr,
                       "the devices did not answer {} requests in time; {} links or frames were lost\n",
                       times_->repetitions(), times_->lost());
        return all;
    }

    // Of each second its p99, and of these the median: a second in which the machine does other work counts
    // as one second, although it delays all requests of it.
    [[nodiscard]] double usual_p99(Instant from, Instant to) const {
        std::vector<double> seconds;
        for (Instant start = from; start + kPeriod <= to; start += kPeriod)
            seconds.push_back(microseconds(times_->window(start, start + kPeriod).lateness, 0.99));
        std::ranges::sort(seconds);
        return seconds.empty() ? 0 : seconds[seconds.size() / 2];
    }

    const PollingOptions& options_;
    Broker broker_;
    std::string directory_;
    std::unique_ptr<host::ProjectHost> host_;
    std::optional<publish::Outputs> outputs_;
    std::optional<PollTimes> times_;
    std::vector<std::pair<PhaseMeasured, std::pair<Instant, Instant>>> phases_;
};

}  // namespace

PollingRun measure_polling(const PollingOptions& options, const Field& field, const WorkingFolder& folder) {
    return Run(options, field, folder).run();
}

}  // namespace takt::bench
