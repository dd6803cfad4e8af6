#include "rig.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "takt/file/load.hpp"
#include "takt/model/findings.hpp"
#include "takt/plan/plan.hpp"

namespace takt::host::test {

void CountedEngine::on_link(Instant t, bool up) {
    engine_->on_link(t, up);
    then_(t);
}
void CountedEngine::on_bytes(Instant t, Bytes bytes) {
    {
        const CountingAllocations counting;
        engine_->on_bytes(t, bytes);
    }
    then_(t);
}
void CountedEngine::on_tick(Instant t) {
    {
        const CountingAllocations counting;
        engine_->on_tick(t);
    }
    then_(t);
}
Bytes CountedEngine::transmit(Instant t) {
    const CountingAllocations counting;
    return engine_->transmit(t);
}

model::Project project_of(const std::string& yaml) {
    const auto loaded = file::load_text("test.yaml", yaml);
    auto checked = model::interpret(loaded.document);
    for (const auto& finding : checked.findings)
        EXPECT_EQ(finding.severity, model::Severity::warning) << finding.code << ' ' << finding.path;
    EXPECT_TRUE(loaded.findings.empty());
    return std::move(checked.project);
}

ConfigurationPtr configuration_of(const std::string& yaml, std::uint32_t generation) {
    auto project = project_of(yaml);
    auto plan = plan::make_plan(project);
    return std::make_shared<const Configuration>(generation, std::move(project), std::move(plan));
}

Rig::Rig(const std::string& yaml, const ProjectEngine::Options& options, Instant start)
    : now(start), options_(options) {
    const auto configuration = configuration_of(yaml);
    link->add_configuration(configuration);
    link->generation = 1;
    engine = make_engine(configuration);
    counted_.resize(configuration->project().lines.size());
    lines_.resize(counted_.size());
    for (std::size_t i = 0; i < lines_.size(); ++i) start_line(i);
}

std::unique_ptr<ProjectEngine> Rig::make_engine(const ConfigurationPtr& configuration) {
    auto options = options_;
    options.started = now;
    options.restored_at = now;
    for (std::size_t i = 0; i < configuration->project().lines.size(); ++i) {
        traffic_.push_back(std::make_unique<TrafficPublisher>(*link, TrafficSource{.index = i},
                                                              configuration->generation()));
        options.line_traffic.push_back(traffic_.back().get());
    }
    auto made = std::make_unique<ProjectEngine>(*link, configuration, options);
    made->set_poke([this](std::size_t line) { poke(line); });
    made->set_endpoint_counters([this](const EndpointNames& names, endpoint::Statistics& into) {
        return endpoints ? endpoints->copy_counters(names, into) : !names;
    });
    return made;
}

void Rig::start_line(std::size_t index) {
    counted_[index] = std::make_unique<CountedEngine>(engine->master().line(index), then(index));
    lines_[index] = std::make_unique<sim::SimulatedLine>(engine->configuration()->project().lines[index],
                                                         *counted_[index]);
    engine->on_link(now, index, true, std::nullopt);
    lines_[index]->start(now);
}

CountedEngine::Then Rig::then(std::size_t line) {
    return [this, line](Instant t) {
        if (endpoints) endpoints->after_line_event(t, line);
    };
}

void Rig::apply(const std::string& yaml) {
    const auto next = configuration_of(yaml, engine->configuration()->generation() + 1);
    link->add_configuration(next);
    if (options_.retention) options_.retention->prepare(*next);
    auto made = make_engine(next);
    const auto& running = engine->configuration()->project().lines;
    for (std::size_t i = 0; i < running.size(); ++i) engine->master().line(i).hold();
    const auto quiet = [&] {
        for (std::size_t i = 0; i < running.size(); ++i)
            if (!engine->master().line(i).quiet()) return false;
        return true;
    };
    for (int turns = 0; turns < 1000 && !quiet(); ++turns) run(1ms);
    ASSERT_TRUE(quiet());
    std::vector<std::optional<std::size_t>> continued;
    for (const auto& line : next->project().lines) {
        const auto found = std::ranges::find(running, line.name, &model::Line::name);
        const bool same = found != running.end() && found->devices.size() == line.devices.size();
        continued.push_back(same ? std::optional<std::size_t>(found - running.begin()) : std::nullopt);
    }
    if (endpoints) endpoints->leave(next->project());
    made->take_over(now, *engine, continued);
    std::swap(engine, made);
    if (options_.retention) options_.retention->watch(*next, engine->master().store());
    link->generation = next->generation();
    engine->publish_event(now, ConfigurationChanged{next->generation()});
    auto old_counted = std::exchange(counted_, {});
    auto old_lines = std::exchange(lines_, {});
    counted_.resize(continued.size());
    lines_.resize(continued.size());
    for (std::size_t i = 0; i < continued.size(); ++i) {
        if (!continued[i]) {
            start_line(i);
            continue;
        }
        counted_[i] = std::move(old_counted[*continued[i]]);
        counted_[i]->call(engine->master().line(i), then(i));
        lines_[i] = std::move(old_lines[*continued[i]]);
    }
    const auto entered = endpoints ? endpoints->enter() : Result<void>();
    ASSERT_TRUE(entered);
    for (std::size_t i = 0; i < lines_.size(); ++i) poke(i);
}

Instant Rig::next() const {
    Instant next = next_tick_;
    for (const auto& line : lines_) next = std::min(next, line->next_wakeup());
    return next;
}

void Rig::step() {
    for (auto& line : lines_)
        if (line->next_wakeup() <= now) line->advance(now);
    if (next_tick_ <= now) {
        engine->on_tick(now);
        next_tick_ = engine->next_tick(now);
    }
    const CountingAllocations counting;
    engine->publish(now);
}

void Rig::run(Duration length) {
    const Instant end = after(now, length);
    serve();
    while (next() <= end) {
        now = std::max(now, next());
        step();
    }
    now = end;
    step();
}

void Rig::serve() {
    while (engine->serve(now)) {}
    engine->publish(now);
}

std::shared_ptr<SnapshotBuffer> Rig::snapshot(const SnapshotParts& parts, std::size_t more) {
    auto buffer = make_snapshot_buffer(engine->configuration(), link->endpoint_names(), parts, more);
    EXPECT_TRUE(link->post(std::make_unique<SnapshotFill>(buffer)));
    const CountingAllocations counting;
    while (engine->serve(now)) {}
    EXPECT_TRUE(buffer->ready.try_acquire());
    return buffer;
}

std::unique_ptr<Session> Rig::open(const SessionOptions& options) {
    const auto id = link->open_session();
    EXPECT_NE(id, 0U);
    return std::make_unique<Session>(link, id, options);
}

value::SlotId Rig::slot(const std::string& name) const {
    const auto found = engine->configuration()->find(name);
    EXPECT_TRUE(found) << name;
    return found.value_or(value::SlotId{});
}

std::vector<Event> take_events(Session& session) {
    std::vector<Event> events;
    while (auto event = session.next_event()) events.push_back(*std::move(event));
    return events;
}

}  // namespace takt::host::test
