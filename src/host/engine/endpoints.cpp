#include "engine/endpoints.hpp"

#include <utility>

#include "takt/model/continued.hpp"

namespace takt::host {

/// A polled line that carries relayed requests too.
class Endpoints::PolledLine final : public endpoint::SharedLine {
public:
    PolledLine(Endpoints& endpoints, std::size_t index) : endpoints_(endpoints), index_(index) {}

    void set_index(std::size_t index) { index_ = index; }

    [[nodiscard]] bool link_up() const override { return poller().link_up(); }
    [[nodiscard]] bool can_accept() const override { return poller().can_relay() && !guests().waits(index_); }
    [[nodiscard]] bool may_start(Instant t, UnitId unit, const bus::AnswerShape& shape) const override {
        return poller().may_start_relayed(t, unit, shape);
    }
    [[nodiscard]] Result<void> submit(Instant t, const bus::Transaction& transaction) override {
        return poller().relay(t, transaction);
    }
    [[nodiscard]] std::optional<bus::Outcome> take_outcome() override {
        return guests().in_slot(index_) ? std::nullopt : poller().take_relayed();
    }
    [[nodiscard]] bool withdraw() override {
        return !guests().in_slot(index_) && poller().withdraw_relayed();
    }
    void poke() override { endpoints_.surroundings_.poke(index_); }

private:
    [[nodiscard]] const LineGuests& guests() const { return endpoints_.engine().guests(); }
    [[nodiscard]] poll::LinePoller& poller() const { return endpoints_.engine().master().line(index_); }

    Endpoints& endpoints_;
    std::size_t index_;
};

/// The values of the project for what is bound to them.
class Endpoints::Values final : public endpoint::ProjectValues {
public:
    explicit Values(Endpoints& endpoints) : endpoints_(endpoints) {}

    [[nodiscard]] const value::Store& store() const override { return endpoints_.engine().master().store(); }
    [[nodiscard]] Result<bool> set(value::SlotId local, const value::Value& value) override {
        return endpoints_.engine().set_local(endpoints_.surroundings_.now(), local, value);
    }
    [[nodiscard]] Result<bool> write(value::SlotId variable, const value::Value& value,
                                     std::function<void(const value::CommandOutcome&)> done) override {
        return endpoints_.engine().write_value(endpoints_.surroundings_.now(), variable, value,
                                               std::move(done));
    }

private:
    Endpoints& endpoints_;
};

Endpoints::Endpoints(Surroundings surroundings)
    : configuration_(surroundings.engine().configuration()),
      surroundings_(std::move(surroundings)),
      values_(std::make_unique<Values>(*this)),
      lines_(configuration_->project().lines.size()) {}

Endpoints::~Endpoints() {
    surroundings_.link.set_endpoint_names(nullptr);
}

Result<std::unique_ptr<Endpoints>> Endpoints::open(Surroundings surroundings) {
    std::unique_ptr<Endpoints> made(new Endpoints(std::move(surroundings)));
    const auto& around = made->surroundings_;
    made->set_ = std::make_unique<endpoint::EndpointSet>(
        around.specs(made->configuration_->project()),
        endpoint::Environment{
            .loop = around.loop,
            .notify = around.notify,
            .serve_log = around.log("serve"),
            .source_log = around.log("source"),
            .traffic = made->traffic(),
            .audit = [&engine = around.engine](
                         Instant t, const auto& record) { engine().publish_event(t, AuditRecorded{record}); },
            .served = made->served()});
    if (const auto opened = made->set_->open(); !opened) {
        (void)made->set_->close();
        return std::unexpected(opened.error());
    }
    made->publish_names();
    return made;
}

endpoint::ServedProject Endpoints::served() {
    return {.project = &configuration_->project(),
            .values = values_.get(),
            .lines = [this](std::size_t index) -> endpoint::SharedLine& {
                lines_[index] = std::make_unique<PolledLine>(*this, index);
                return *lines_[index];
            }};
}

line::TrafficFactory Endpoints::traffic() {
    return [this](const model::Line& line) {
        const TrafficSource source{TrafficSource::Kind::endpoint, surroundings_.link.add_endpoint_line(line)};
        auto made =
            std::make_shared<TrafficPublisher>(surroundings_.link, source, configuration_->generation());
        std::erase_if(traffic_, [](const auto& publisher) { return publisher.expired(); });
        traffic_.push_back(made);
        return made;
    };
}

// The names replace those of a smaller or larger set of listeners: counters for other names are not copied.
void Endpoints::publish_names() {
    names_ = std::make_shared<const endpoint::Statistics>(set_->statistics());
    surroundings_.link.set_endpoint_names(names_);
}

void Endpoints::leave(const model::Project& next) {
    set_->leave(next);
    const auto before = model::continued_gateways(configuration_->project(), next);
    auto old = std::exchange(lines_, std::vector<std::unique_ptr<PolledLine>>(before.size()));
    for (std::size_t i = 0; i < before.size(); ++i) {
        if (!before[i] || !old[*before[i]]) continue;
        lines_[i] = std::move(old[*before[i]]);
        lines_[i]->set_index(i);
    }
}

Result<void> Endpoints::enter() {
    const auto before = std::exchange(configuration_, engine().configuration());
    for (const auto& publisher : traffic_)
        if (const auto known = publisher.lock()) known->set_generation(configuration_->generation());
    const auto entered = set_->enter(surroundings_.specs(configuration_->project()), served());
    publish_names();
    return entered;
}

bool Endpoints::copy_counters(const EndpointNames& names, endpoint::Statistics& into) const {
    if (names != names_) return false;
    set_->refresh(into);
    return true;
}

}  // namespace takt::host
