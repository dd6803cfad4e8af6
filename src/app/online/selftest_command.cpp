// takt selftest: a thread measures; this one shows the progress and takes the signals.
#include "commands.hpp"

#include <algorithm>
#include <atomic>
#include <optional>
#include <string>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "output.hpp"
#include "progress.hpp"
#include "takt/client/background_load.hpp"
#include "takt/client/measure.hpp"
#include "takt/report/states/selftest_report.hpp"
#include "texts.hpp"
#include "work_loop.hpp"

namespace takt::app {
namespace {

class Selftest {
public:
    Selftest(const Texts& texts, const SelftestOptions& options)
        : texts_(texts), options_(options), progress_(texts, line::now()) {
        report_.load_threads = std::max(1U, std::thread::hardware_concurrency());
    }

    ExitCode run() {
        if (const auto begun = work_loop_.begin(); !begun) return ended_by(texts_, begun.error());
        const auto done = measure_on_thread();
        progress_.clear();
        if (!done) return ended_by(texts_, done.error());
        print_realtime(texts_, options_.realtime, realtime_, false);
        print(options_.json ? report::selftest_json(report_).dump() + '\n'
                            : report::selftest_text(texts_, report_));
        return ExitCode::ok;
    }

private:
    Result<void> measure_on_thread() {
        Result<void> done;
        std::thread worker;
        try {
            worker = std::thread([&] {
                done = measure_all();
                work_loop_.loop().stop();
            });
        } catch (const std::system_error& error) {
            return client::no_thread(error);
        }
        work_loop_.work(std::nullopt);
        stop_ = true;
        worker.join();
        return done;
    }

    Result<void> measure_all() {
        TAKT_CHECK(measure_into(report_.idle));
        if (stop_) return {};
        try {
            const client::BackgroundLoad load(report_.load_threads);
            return measure_into(report_.loaded);
        } catch (const std::system_error& error) {
            return client::no_thread(error);
        }
    }

    // A measurement that was stopped is left out: it is shorter than the others.
    Result<void> measure_into(report::SelftestRun& run) {
        for (const auto subject : client::kSubjects) {
            TAKT_TRY(const auto measured, client::measure(subject, settings()));
            if (stop_) return {};
            run[static_cast<std::size_t>(subject)] = measured;
            ++ended_;
        }
        return {};
    }

    client::MeasureOptions settings() {
        return {.time = options_.time,
                .begin_thread =
                    [this](line::Loop& loop) {
                        auto steps = begin_realtime(options_.realtime, loop);
                        if (realtime_.empty()) realtime_ = std::move(steps);
                    },
                .begin_peer =
                    [this] {
                        if (options_.realtime.priority > 0)
                            (void)os::become_realtime({.priority = options_.realtime.priority, .cpu = {}});
                    },
                .stop = &stop_,
                .progress = [this](Duration since) { show_progress(since); }};
    }

    void show_progress(Duration since) {
        const auto length = static_cast<std::size_t>(options_.time.count());
        const auto now = ended_ * length + static_cast<std::size_t>(since.count());
        work_loop_.loop().post([this, now, all = 2 * client::kSubjects.size() * length] {
            progress_.show(line::now(), {.done = now, .total = all}, texts_("selftest.progress"));
        });
    }

    Texts texts_;
    const SelftestOptions& options_;
    Progress progress_;
    WorkLoop work_loop_;
    report::SelftestReport report_;  // until the end of the worker, its own
    std::vector<os::RealtimeResult> realtime_;
    std::size_t ended_ = 0;  // measurements
    std::atomic<bool> stop_ = false;
};

}  // namespace

ExitCode selftest(const CommonOptions& common, const SelftestOptions& options) {
    return Selftest(Texts(common.language), options).run();
}

}  // namespace takt::app
