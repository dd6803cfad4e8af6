#include "engine/learning_planner.hpp"

#include <algorithm>
#include <utility>

#include "engine/wall_clock.hpp"
#include "takt/file/learnt.hpp"
#include "takt/file/write.hpp"
#include "takt/plan/learning.hpp"

namespace takt::host {
namespace {

constexpr std::size_t kMostJobs = 4096;  // at most one plan is being made for a line

}  // namespace

LearningPlanner::LearningPlanner(std::string path, Post post, PlanReady ready, endpoint::NoticeSink notify)
    : path_(std::move(path)),
      post_(std::move(post)),
      ready_(std::move(ready)),
      notify_(std::move(notify)),
      worker_(os::Worker::Options{.name = "takt-planner", .queue = kMostJobs}) {}

void LearningPlanner::watch(ConfigurationPtr configuration, const poll::Master& master) {
    configuration_ = std::move(configuration);
    master_ = &master;
}

// A plan of an earlier generation would have the indices of another project.
void LearningPlanner::want_plan(std::size_t line, std::vector<model::Learnt> learnt) {
    (void)worker_.post([this, alive = std::weak_ptr(alive_), configuration = configuration_, line,
                        learnt = std::move(learnt)] {
        auto made =
            std::make_shared<plan::LearningPlan>(plan::learning_plan(configuration->project(), line, learnt));
        auto copy = std::make_shared<const plan::LinePlan>(made->plan);
        post_([this, alive, configuration, line, made, copy] {
            if (alive.expired() || configuration != configuration_) return;
            ready_(line, std::move(*made), copy);
        });
    });
}

void LearningPlanner::on_learnt(Instant t) {
    if (!path_.empty()) save_at_ = std::min(save_at_, after(t, kSaveAfter));
}

void LearningPlanner::on_measured(Instant t) {
    if (path_.empty() || std::exchange(keeps_times_, true)) return;
    save_at_ = std::min(save_at_, after(t, kSaveTimesAfter));
}

void LearningPlanner::on_tick(Instant t) {
    if (save_at_ <= t) save(t);
}

void LearningPlanner::save(Instant t) {
    if (std::exchange(save_at_, kNever) == kNever) return;
    if (keeps_times_) save_at_ = after(t, kSaveTimesEvery);
    file::LearntOfLines learnt;
    file::TimesOfLines times;
    file::LengthsOfLines lengths_off;
    for (std::size_t l = 0; l < master_->line_count(); ++l) {
        learnt.push_back(master_->line(l).learnt(t));
        times.push_back(master_->line(l).learnt_times());
        lengths_off.push_back(master_->line(l).lengths_are_off());
    }
    (void)worker_.post([this, alive = std::weak_ptr(alive_), configuration = configuration_,
                        learnt = std::move(learnt), times = std::move(times),
                        lengths_off = std::move(lengths_off), now = wall_now()] {
        const auto text = file::learnt_text(configuration->project(), learnt, times, now, lengths_off);
        const auto written = file::write_file(path_, text, true);
        if (written) return;
        post_([this, alive, error = written.error()] {
            if (alive.expired() || std::exchange(failure_reported_, true)) return;
            notify_({endpoint::Notice::Severity::error, "host.learnt.failed", {}, error});
        });
    });
}

void LearningPlanner::finish(Instant t) {
    save(t);
    worker_.finish();
    alive_.reset();
}

}  // namespace takt::host
