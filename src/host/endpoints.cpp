#include "endpoints.hpp"

#include <utility>

#include "traffic_publisher.hpp"
#include "takt/line/loop.hpp"

namespace takt::host {

/// A polled line that carries relayed requests too.
class Endpoints::RelayedLine final : public endpoint::RelayLine {
public:
    RelayedLine(Endpoints& endpoints, std::size_t index) : endpoints_(endpoints), index_(index) {}

    [[nodiscard]] bool link_up() const override { return poller().link_up(); }
    [[nodiscard]] bool can_accept() const override { return poller().can_relay(); }
    [[nodiscard]] Result<void> submit(Instant t, const bus::Transaction& transaction) override {
        return poller().relay(t, transaction);
    }
    [[nodiscard]] std::optional<bus::Outcome> take_outcome() override { return poller().take_relayed(); }
    [[nodiscard]] bool withdraw() override { return poller().withdraw_relayed(); }
    void poke() override { endpoints_.surroundings_.poke(index_); }

private:
    [[nodiscard]] poll::LinePoller& poller() const { return endpoints_.engine_.master().line(index_); }

    Endpoints& endpoints_;
    std::size_t index_;
};

/// The values of the project for what is bound to them.
class Endpoints::Values final : public source::ProjectValues {
public:
    explicit Values(ProjectEngine& engine) : engine_(engine) {}

    [[nodiscard]] const value::Store& store() const override { return engine_.master().store(); }
    [[nodiscard]] Result<bool> set(value::SlotId local, const value::Value& value) override {
        return engine_.set_local(line::now(), local, value);
    }
    [[nodiscard]] Result<bool> write(value::SlotId variable, const value::Value& value,
                                     std::function<void(const value::CommandOutcome&)> done) override {
        return engine_.write_value(line::now(), variable, value, std::move(done));
    }

private:
    ProjectEngine& engine_;
};

Endpoints::Endpoints(ProjectEngine& engine, Surroundings surroundings)
    : engine_(engine),
      configuration_(engine.configuration()),
      surroundings_(std::move(surroundings)),
      values_(std::make_unique<Values>(engine)),
      lines_(configuration_->project().lines.size()) {}

Endpoints::~Endpoints() {
    surroundings_.link.set_endpoint_names(nullptr);
}

Result<std::unique_ptr<Endpoints>> Endpoints::open(ProjectEngine& engine, const std::string& project_file,
                                                   Surroundings surroundings) {
    std::unique_ptr<Endpoints> made(new Endpoints(engine, std::move(surroundings)));
    auto& around = made->surroundings_;
    const auto& project = made->configuration_->project();
    const auto generation = made->configuration_->generation();
    made->set_ = std::make_unique<endpoint::EndpointSet>(
        endpoint::server_endpoints(project, project_file, {}, true),
        endpoint::Environment{.loop = around.loop,
                              .notify = around.notify,
                              .serve_log = around.log("serve"),
                              .source_log = around.log("source"),
                              .traffic =
                                  [&link = around.link, generation](const model::Line& line) {
                                      const auto index = link.add_endpoint_line(line);
                                      return std::make_shared<TrafficPublisher>(
                                          link, TrafficSource{TrafficSource::Kind::endpoint, index}, generation);
                                  },
                              .audit = [&engine](Instant t, const endpoint::AuditRecord& record) {
                                  engine.publish_event(t, AuditRecorded{record});
                              },
                              .project = &project,
                              .values = made->values_.get(),
                              .lines = [self = made.get()](std::size_t index) -> endpoint::RelayLine& {
                                  self->lines_[index] = std::make_unique<RelayedLine>(*self, index);
                                  return *self->lines_[index];
                              }});
    if (const auto opened = made->set_->open(); !opened) {
        (void)made->set_->close();
        return std::unexpected(opened.error());
    }
    made->names_ = std::make_shared<const endpoint::Statistics>(made->set_->statistics());
    around.link.set_endpoint_names(made->names_);
    return made;
}

bool Endpoints::copy_counters(const EndpointNames& names, endpoint::Statistics& into) const {
    if (names != names_) return false;
    set_->refresh(into);
    return true;
}

}  // namespace takt::host
