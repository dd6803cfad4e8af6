#include "project_servers.hpp"

#include <array>
#include <utility>

#include "endpoint_face.hpp"
#include "takt/app/log.hpp"
#include "takt/file/json.hpp"

namespace takt::app {
namespace {

using Named = std::pair<const char*, std::uint64_t>;

std::array<Named, 9> named(const relay::GatewayCounters& counters) {
    return {Named{"asked", counters.asked},    {"sent", counters.sent},
            {"shared", counters.shared},       {"cached", counters.from_cache},
            {"no_answer", counters.no_answer}, {"no_path", counters.no_path},
            {"busy", counters.busy},           {"refused", counters.refused},
            {"forgotten", counters.forgotten}};
}

}  // namespace

/// A polled line that carries relayed requests too.
class ProjectServers::SharedLine final : public endpoint::RelayLine {
public:
    SharedLine(Running& running, std::size_t index) : running_(running), index_(index) {}

    [[nodiscard]] bool link_up() const override { return poller().link_up(); }
    [[nodiscard]] bool can_accept() const override { return poller().can_relay(); }
    [[nodiscard]] Result<void> submit(Instant t, const bus::Transaction& transaction) override {
        return poller().relay(t, transaction);
    }
    [[nodiscard]] std::optional<bus::Outcome> take_outcome() override { return poller().take_relayed(); }
    void poke() override { running_.poke_line(index_); }

private:
    [[nodiscard]] poll::LinePoller& poller() const { return running_.line(index_); }

    Running& running_;
    std::size_t index_;
};

/// The values of a project that runs.
class ProjectServers::Values final : public source::ProjectValues {
public:
    explicit Values(Running& running) : running_(running) {}
    [[nodiscard]] const value::Store& store() const override { return running_.values(); }
    [[nodiscard]] Result<bool> set(value::SlotId local, const value::Value& value) override {
        return running_.set_local(local, value);
    }
    [[nodiscard]] Result<bool> write(value::SlotId variable, const value::Value& value,
                                     Running::Written done) override {
        return running_.write_value(variable, value, std::move(done));
    }

private:
    Running& running_;
};

ProjectServers::ProjectServers(line::Loop& loop, const model::Project& project, const std::string& file,
                               Running& running, TrafficLog* log, const Texts& texts)
    : project_(project),
      file_(file),
      running_(running),
      texts_(texts),
      values_(std::make_unique<Values>(running)),
      lines_(project.lines.size()),
      endpoints_(endpoint::server_endpoints(project, file, {}, true),
                 {.loop = loop,
                  .notify = print_notices(texts),
                  .serve_log = app::log("serve"),
                  .source_log = app::log("source"),
                  .traffic = traffic_factory(log),
                  .project = &project,
                  .values = values_.get(),
                  .lines = [this](std::size_t index) -> endpoint::RelayLine& {
                      lines_[index] = std::make_unique<SharedLine>(running_, index);
                      return *lines_[index];
                  }}) {
    running_.watch_lines([this](Instant t, std::size_t line) { endpoints_.on_line_event(t, line); });
}

ProjectServers::~ProjectServers() {
    running_.watch_lines({});
}

void ProjectServers::reload_access() {
    app::reload_access(texts_, endpoints_, {}, file_);
}

std::string ProjectServers::summary_text() const {
    std::string text = report::served_text(texts_, summary_of(statistics_));
    for (const auto& [line, counters] : statistics_.relayed) {
        Texts::Arguments arguments{{"line", project_.lines[line].name}};
        for (const auto& [name, count] : named(counters)) arguments.emplace_back(name, std::to_string(count));
        text += texts_("app.relayed", arguments) + '\n';
    }
    return text;
}

std::string ProjectServers::summary_json() const {
    std::string text = report::served_json(summary_of(statistics_), "served");
    for (const auto& [line, counters] : statistics_.relayed) {
        auto object = file::Json::object();
        object.set("event", "relayed");
        object.set("line", project_.lines[line].name);
        for (const auto& [name, count] : named(counters)) object.set(name, count);
        text += object.dump() + '\n';
    }
    return text;
}

}  // namespace takt::app
