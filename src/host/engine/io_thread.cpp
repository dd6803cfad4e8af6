// The turn of the I/O thread: bytes or a timer reach the engine of a line (LineSet::Forwarder) -> the
// endpoints get the event (after_line_event) -> the driver sends what the engine has -> the publish timer,
// already due, fires and publishes. So no subscriber delays a frame. The requests of sessions arrive by the
// bell, in serve().
#include "engine/io_thread.hpp"

#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <semaphore>
#include <utility>

#include "engine/applied_project.hpp"
#include "engine/wall_clock.hpp"
#include "sessions/record_codec.hpp"
#include "takt/line/real_line.hpp"
#include "takt/os/thread_name.hpp"
#include "takt/plan/learning.hpp"

namespace takt::host {
namespace {

/// How long commands may take to end when another project is applied. Transactions in flight are waited for
/// in any case, at most for one time-out.
constexpr Duration kLongestHold = std::chrono::seconds(1);

std::uint64_t unix_seconds() {
    return static_cast<std::uint64_t>(wall_now().time_since_epoch().count());
}

}  // namespace

IoThread::IoThread(std::shared_ptr<HostLink> link, std::unique_ptr<line::Loop> loop, HostOptions options)
    : link_(std::move(link)),
      loop_(std::move(loop)),
      options_(std::move(options)),
      started_(line::now()),
      lines_(*link_, *loop_, options_.prepare, notices(),
             [this](Instant t, std::size_t line) { after_line_event(t, line); }),
      serve_timer_(*loop_, [this](Instant t) { serve(t); }),
      publish_timer_(*loop_, [this](Instant t) { publish(t); }),
      tick_timer_(*loop_, [this](Instant t) { on_tick(t); }) {}

IoThread::~IoThread() = default;

Log IoThread::log(std::string_view category) const {
    return options_.log ? options_.log(category) : Log();
}

// The ring has one writer: the thread that starts the host, then the I/O thread. A thread that applies a
// project hands its notices over.
endpoint::NoticeSink IoThread::notices() {
    return [this](const Notice& notice) {
        const auto writer = io_thread_.load();
        if (writer == std::thread::id() || writer == std::this_thread::get_id()) return append(notice);
        {
            const std::lock_guard lock(notices_mutex_);
            waiting_notices_.push_back(notice);
        }
        loop_->post([this] { append_waiting(); });
    };
}

// Only this thread writes events. At the end the loop runs no posted task any more, so the rest is taken
// then.
void IoThread::append_waiting() {
    std::vector<Notice> waiting;
    {
        const std::lock_guard lock(notices_mutex_);
        waiting.swap(waiting_notices_);
    }
    for (const Notice& notice : waiting) append(notice);
}

void IoThread::append(const Notice& notice) {
    if (io_thread_.load() == std::thread::id()) opening_notices_.push_back(notice);
    std::vector<std::uint64_t> record;
    encode(Event{.generation = link_->generation, .t = line::now(), .body = notice}, record);
    link_->events.append(record);
}

Result<void> IoThread::open(const ConfigurationPtr& configuration) {
    link_->add_configuration(configuration);
    link_->generation = configuration->generation();
    open_files(*configuration);
    auto traffic = lines_.traffic_of(*configuration);
    engine_ = make_engine(configuration, traffic);
    if (learner_) learner_->watch(configuration, engine_->master());
    if (retention_) retention_->watch(*configuration, engine_->master().store());
    offer_endpoint_counters();
    TAKT_CHECK(open_endpoints());
    TAKT_CHECK(lines_.open(*engine_, std::move(traffic)));
    TAKT_CHECK(watch_requests());
    tick_timer_.set(line::now());
    return {};
}

Result<void> IoThread::open_endpoints() {
    if (engine_->configuration()->project().servers.empty()) return {};
    TAKT_TRY(endpoints_, Endpoints::open({.loop = *loop_,
                                          .link = *link_,
                                          .specs =
                                              [this](const model::Project& project) {
                                                  return endpoint::server_endpoints(
                                                      project, options_.project_file, {}, true);
                                              },
                                          .now = line::now,
                                          .engine = [this]() -> ProjectEngine& { return *engine_; },
                                          .notify = notices(),
                                          .log = [this](std::string_view category) { return log(category); },
                                          .poke = [this](std::size_t line) { lines_.poke(line); }}));
    return {};
}

void IoThread::offer_endpoint_counters() {
    engine_->set_endpoint_counters([this](const EndpointNames& names, endpoint::Statistics& into) {
        return endpoints_ ? endpoints_->copy_counters(names, into) : !names;
    });
}

// Before the line sends: a relayed request goes out with the end of the one before.
void IoThread::after_line_event(Instant t, std::size_t line) {
    if (endpoints_) endpoints_->after_line_event(t, line);
    publish_soon(t);
}

// The state file is read before the engine is made, which begins with the values in it.
void IoThread::open_files(const Configuration& configuration) {
    const auto post = [this](std::function<void()> task) { loop_->post(std::move(task)); };
    if (!options_.state_file.empty() && !retention_)
        retention_ = Retention::open(configuration, options_.state_file, post, notices());
    if (!options_.learn || learner_) return;
    if (options_.learnt_file.empty() && !plan::learns(configuration.project())) return;
    const auto ready = [this](std::size_t line, plan::LearningPlan plan,
                              std::shared_ptr<const plan::LinePlan> copy) {
        engine_->replace_plan(line, std::move(plan), std::move(copy));
    };
    learner_ = std::make_unique<LearningPlanner>(options_.learnt_file, post, ready, notices());
}

std::unique_ptr<ProjectEngine> IoThread::make_engine(
    const ConfigurationPtr& configuration, const std::vector<std::shared_ptr<TrafficPublisher>>& traffic) {
    const auto& project = configuration->project();
    ProjectEngine::Options options{.retention = retention_.get(),
                                   .learner = learner_.get(),
                                   .started = started_,
                                   .restored_at = line::now(),
                                   .utc_seconds = unix_seconds,
                                   .log = log("host")};
    for (std::size_t i = 0; i < traffic.size(); ++i) {
        options.line_traffic.push_back(traffic[i].get());
        const auto& line = project.lines[i];
        options.line_bus.emplace_back(line::fit_to_real_line(poll::line_config(project, line), line));
    }
    auto engine = std::make_unique<ProjectEngine>(*link_, configuration, options);
    engine->set_poke([this](std::size_t line) { lines_.poke(line); });
    return engine;
}

Result<void> IoThread::watch_requests() {
    link_->bell.reset(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK));
    if (!link_->bell) return fail(Code::io_failed, "eventfd", errno);
    requests_ = std::make_unique<line::Watch>(*loop_, link_->bell.get(), [this] {
        std::uint64_t rings = 0;
        [[maybe_unused]] const auto drained = ::read(link_->bell.get(), &rings, sizeof rings);
        requests_->want_read();
        serve(line::now());
    });
    requests_->want_read();
    return {};
}

void IoThread::begin() {
    std::binary_semaphore begun{0};
    thread_ = std::thread([this, &begun] {
        os::name_thread("takt-io");
        io_thread_ = std::this_thread::get_id();
        begun.release();
        run();
    });
    begun.acquire();
}

void IoThread::run() {
    if (options_.begin_thread) options_.begin_thread(*loop_);
    loop_->run();
    const Instant t = line::now();
    append_waiting();
    if (applying_) applying_->applied->ready.release();
    while (engine_->serve(t)) {}
    engine_->finish(t);
    if (!endpoints_) return;
    served_ = endpoints_->close();
    engine_->set_endpoint_counters([this](const EndpointNames&, endpoint::Statistics& into) {
        into = served_;
        return true;
    });
}

bool IoThread::set_access(const model::Project& project) {
    return endpoints_ && endpoints_->set_access(project);
}

void IoThread::ask_to_end() {
    link_->stopped = true;
    loop_->stop();
}

bool IoThread::end() {
    if (!thread_.joinable()) return false;
    ask_to_end();
    thread_.join();
    return true;
}

// While a project is being applied, requests wait: they are for the project that comes.
void IoThread::serve(Instant t) {
    if (applying_) return;
    if (engine_->serve(t)) serve_timer_.set(t);
    publish_soon(t);
}

void IoThread::on_tick(Instant t) {
    engine_->on_tick(t);
    publish_soon(t);
    tick_timer_.set(engine_->next_tick(t));
}

void IoThread::publish(Instant t) {
    engine_->publish(t);
    if (applying_) switch_when_quiet(t);
}

// By a timer, so that publishing comes after the driver has sent what the engine gave it.
void IoThread::publish_soon(Instant t) {
    if (publish_timer_.when() == kNever) publish_timer_.set(t);
}

std::unique_ptr<ApplyRequest> IoThread::prepare(const ConfigurationPtr& next) {
    // Values of the running project replace those of the state file.
    if (retention_) retention_->prepare(*next);
    open_files(*next);
    auto request = std::make_unique<ApplyRequest>(*this, lines_.traffic_of(*next));
    request->engine = make_engine(next, request->traffic);
    for (std::size_t i = 0; i < next->project().lines.size(); ++i)
        request->continued.push_back(lines_.continued(*next, i));
    return request;
}

void ApplyRequest::serve(ProjectEngine& /*running*/, Instant t, std::unique_ptr<HostRequest> self) {
    io.apply(t, std::unique_ptr<ApplyRequest>(static_cast<ApplyRequest*>(self.release())));
}

void ApplyRequest::refuse(HostLink& /*link*/, std::unique_ptr<HostRequest> /*self*/) {
    applied->ready.release();
}

void IoThread::apply(Instant t, std::unique_ptr<ApplyRequest> request) {
    applying_ = std::move(request);
    applying_->give_up_at = after(t, kLongestHold);
    for (std::size_t i = 0; i < engine_->master().line_count(); ++i) {
        engine_->master().line(i).hold();
        lines_.poke(i);
    }
    publish_soon(t);
}

void IoThread::switch_when_quiet(Instant t) {
    const auto& master = engine_->master();
    const bool wait_for_commands = t < applying_->give_up_at;
    for (std::size_t i = 0; i < master.line_count(); ++i)
        if (wait_for_commands ? !master.line(i).quiet() : !master.line(i).idle()) return;
    switch_project(t);
}

// Ports that one project has and the other needs are closed first: servers leave before lines move, and new
// ones come after them.
void IoThread::switch_project(Instant t) {
    auto request = std::move(applying_);
    auto& next = *request->engine;
    if (endpoints_) endpoints_->leave(next.configuration()->project());
    next.take_over(t, *engine_, request->continued);
    request->applied->replaced = std::exchange(engine_, std::move(request->engine));
    offer_endpoint_counters();
    lines_.move_to(*engine_, std::move(request->traffic));
    const auto& configuration = engine_->configuration();
    if (learner_) learner_->watch(configuration, engine_->master());
    if (retention_) retention_->watch(*configuration, engine_->master().store());
    link_->generation = configuration->generation();
    engine_->publish_event(t, ConfigurationChanged{configuration->generation()});
    const auto opened = endpoints_ ? endpoints_->enter() : open_endpoints();
    request->applied->error = opened ? std::nullopt : std::optional(opened.error());
    for (std::size_t i = 0; i < engine_->master().line_count(); ++i) lines_.poke(i);
    serve(t);
    request->applied->done = true;
    request->applied->ready.release();
}

}  // namespace takt::host
