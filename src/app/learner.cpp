#include "takt/app/learner.hpp"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <utility>

#include "takt/app/console.hpp"
#include "takt/file/read.hpp"
#include "takt/file/write.hpp"
#include "takt/plan/learning.hpp"

namespace takt::app {
namespace {

using namespace std::chrono_literals;

constexpr Duration kSaveAfter = 200ms;

std::chrono::sys_seconds wall_now() {
    return std::chrono::floor<std::chrono::seconds>(std::chrono::system_clock::now());
}

bool learns(const model::Project& project) {
    return std::ranges::any_of(project.lines, [](const model::Line& line) { return plan::learns(line); });
}

}  // namespace

std::string learnt_path(const std::string& project_file) {
    return std::filesystem::path(project_file).replace_extension(".learnt.json").string();
}

std::string recall_learnt(LoadedProject& loaded, const std::string& project_file) {
    if (loaded.has_errors() || !learns(loaded.project)) return {};
    std::string path = learnt_path(project_file);
    std::error_code trouble;
    if (!std::filesystem::exists(path, trouble) && !trouble) return path;
    const auto file = static_cast<std::uint32_t>(loaded.files.size());
    loaded.files.push_back(path);
    const auto text = file::read_file(path, file::kMaxLearntBytes);
    if (!text) {
        loaded.findings.push_back({.severity = model::Severity::warning,
                                   .code = "learnt.unreadable",
                                   .location = {.file = file},
                                   .path = {},
                                   .value = std::string(name(text.error().code)),
                                   .allowed = {},
                                   .arguments = {}});
        return {};
    }
    auto recalled = file::recall(*text, wall_now(), file, loaded.project);
    std::ranges::move(recalled.findings, std::back_inserter(loaded.findings));
    return recalled.whole ? path : std::string();
}

Learner::Learner(line::Loop& loop, const model::Project& project, const Texts& texts, std::string path)
    : loop_(loop),
      project_(project),
      texts_(texts),
      path_(std::move(path)),
      save_timer_(loop, [this](Instant) { save(); }),
      thread_([this] { work(); }) {}

Learner::~Learner() {
    {
        const std::lock_guard lock(mutex_);
        ends_ = true;
    }
    wake_.notify_one();
    if (thread_.joinable()) thread_.join();
}

void Learner::follow(poll::Master& master, std::function<void(std::size_t line)> poke) {
    master_ = &master;
    poke_ = std::move(poke);
}

void Learner::work() {
    for (;;) {
        std::function<void()> job;
        {
            std::unique_lock lock(mutex_);
            wake_.wait(lock, [this] { return ends_ || !jobs_.empty(); });
            if (jobs_.empty()) return;
            job = std::move(jobs_.front());
            jobs_.pop_front();
        }
        job();
    }
}

void Learner::put(std::function<void()> job) {
    {
        const std::lock_guard lock(mutex_);
        jobs_.push_back(std::move(job));
    }
    wake_.notify_one();
}

void Learner::want_plan(std::size_t line, std::vector<model::Learnt> learnt) {
    put([this, line, learnt = std::move(learnt)] {
        auto made = std::make_shared<plan::LearningPlan>(plan::learning_plan(project_, line, learnt));
        loop_.post([this, line, made] {
            master_->line(line).replace_plan(std::move(*made));
            poke_(line);
        });
    });
}

void Learner::note() {
    if (path_.empty()) return;
    unsaved_ = true;
    if (save_timer_.when() == kNever) save_timer_.set(after(line::now(), kSaveAfter));
}

void Learner::save() {
    if (!std::exchange(unsaved_, false)) return;
    const Instant t = line::now();
    file::LearntOfLines learnt;
    for (std::size_t l = 0; l < master_->line_count(); ++l) learnt.push_back(master_->line(l).learnt(t));
    put([this, learnt = std::move(learnt), now = wall_now()] {
        const auto written = file::write_file(path_, file::learnt_text(project_, learnt, now), true);
        if (written) return;
        loop_.post([this, error = written.error()] {
            if (!std::exchange(complained_, true)) print_error(texts_.describe(error));
        });
    });
}

void Learner::finish() {
    save_timer_.set(kNever);
    save();
    {
        const std::lock_guard lock(mutex_);
        ends_ = true;
    }
    wake_.notify_one();
    if (thread_.joinable()) thread_.join();
}

}  // namespace takt::app
