#include "takt/host/project_host.hpp"

#include <algorithm>
#include <mutex>
#include <semaphore>
#include <utility>

#include "engine/io_thread.hpp"
#include "sessions/snapshot_request.hpp"
#include "takt/line/loop.hpp"

namespace takt::host {

struct ProjectHost::Impl {
    std::shared_ptr<HostLink> link = std::make_shared<HostLink>();
    std::unique_ptr<IoThread> io;
    std::mutex changing;  // one apply() or stop() at a time
};

ProjectHost::ProjectHost(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

Result<std::unique_ptr<ProjectHost>> ProjectHost::start(model::Project project, plan::Plan plan,
                                                        const HostOptions& options) {
    constexpr std::uint32_t kFirstGeneration = 1;
    auto impl = std::make_unique<Impl>();
    TAKT_TRY(auto loop, line::Loop::create());
    if (options.record_traffic) ++impl->link->taps;
    impl->io = std::make_unique<IoThread>(impl->link, std::move(loop), options);
    const auto opened = impl->io->open(
        std::make_shared<const Configuration>(kFirstGeneration, std::move(project), std::move(plan)));
    if (!opened && options.on_failed_start)
        std::ranges::for_each(impl->io->opening_notices(), options.on_failed_start);
    if (!opened) return std::unexpected(opened.error());
    impl->io->begin();
    return std::unique_ptr<ProjectHost>(new ProjectHost(std::move(impl)));
}

ProjectHost::~ProjectHost() {
    stop();
    impl_->link->set_last_state({});
}

// The engine stays as it is for the last snapshots; nothing changes it any more.
void ProjectHost::stop() {
    impl_->io->ask_to_end();
    const std::lock_guard lock(impl_->changing);
    if (!impl_->io->end()) return;
    impl_->link->set_last_state([io = impl_->io.get(), names = impl_->link->endpoint_names(),
                                 ended = line::now()](const SnapshotParts& parts) {
        for (std::size_t more = 0;; more = more_memory(more)) {
            const auto buffer = make_snapshot_buffer(io->engine().configuration(), names, parts, more);
            SnapshotFill fill(buffer);
            while (fill.fill_slice(io->engine(), ended)) {}
            if (!buffer->too_small) return std::move(buffer->snapshot);
        }
    });
    impl_->link->ended = true;
    impl_->link->refuse_rest();
    impl_->link->notify();
}

Result<std::unique_ptr<Session>> ProjectHost::open_session(const SessionOptions& options) {
    if (impl_->link->stopped) return fail(Code::connection_lost, "host");
    const SessionId id = impl_->link->open_session();
    if (id == 0) return fail(Code::queue_full, "sessions", HostLink::kMostSessions);
    return std::make_unique<Session>(impl_->link, id, options);
}

Result<void> ProjectHost::apply(model::Project project, plan::Plan plan) {
    const std::lock_guard lock(impl_->changing);
    auto& link = *impl_->link;
    if (link.stopped) return fail(Code::connection_lost, "host");
    const auto next =
        std::make_shared<const Configuration>(link.generation + 1, std::move(project), std::move(plan));
    link.add_configuration(next);
    auto request = impl_->io->prepare(next);
    const auto applied = request->applied;
    (void)link.post(std::move(request));
    applied->ready.acquire();
    const auto replaced = std::move(applied->replaced);  // destroyed here
    if (!applied->done) return fail(Code::connection_lost, "host");
    if (applied->error) return std::unexpected(*applied->error);
    return {};
}

namespace {

/// New access rules on their way to the I/O thread. The project and the semaphore outlive it.
struct AccessRequest final : HostRequest {
    struct Answer {
        bool in_force = false;
        std::binary_semaphore ready{0};
    };

    AccessRequest(IoThread& thread, const model::Project& with_rules, Answer& to)
        : io(thread), project(with_rules), answer(to) {}

    void serve(ProjectEngine&, Instant, std::unique_ptr<HostRequest>) override {
        answer.in_force = io.set_access(project);
        answer.ready.release();
    }
    void refuse(HostLink&, std::unique_ptr<HostRequest>) override { answer.ready.release(); }

    IoThread& io;
    const model::Project& project;
    Answer& answer;
};

}  // namespace

bool ProjectHost::set_access(const model::Project& project) {
    AccessRequest::Answer answer;
    (void)impl_->link->post(std::make_unique<AccessRequest>(*impl_->io, project, answer));
    answer.ready.acquire();
    return answer.in_force;
}

const endpoint::Statistics& ProjectHost::served() const {
    return impl_->io->served();
}

ConfigurationPtr ProjectHost::configuration() const {
    return impl_->link->configuration();
}

Instant ProjectHost::started() const {
    return impl_->io->started();
}

}  // namespace takt::host
