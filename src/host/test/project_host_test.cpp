// The host with its I/O thread, on simulated lines: every wait ends with an event, none with a clock.
#include "takt/host/project_host.hpp"

#include <gtest/gtest.h>

#include <fmt/format.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <fstream>
#include <latch>
#include <set>
#include <thread>
#include <vector>

#include "folder.hpp"
#include "projects.hpp"
#include "rig.hpp"
#include "takt/os/descriptor.hpp"
#include "takt/plan/plan.hpp"
#include "takt/store/retained.hpp"

namespace takt::host::test {
namespace {

const std::string kPlant = project_with(line_of("main", boiler(), "tcp"));

std::unique_ptr<ProjectHost> started(model::Project project, const HostOptions& options = {}) {
    auto plan = plan::make_plan(project);
    auto host = ProjectHost::start(std::move(project), std::move(plan), options);
    EXPECT_TRUE(host);
    return host ? *std::move(host) : nullptr;
}

std::unique_ptr<ProjectHost> started(const std::string& yaml, const HostOptions& options = {}) {
    return started(project_of(yaml), options);
}

template <class Body, class Matches>
std::optional<Body> wait_for(Session& session, Matches matches) {
    for (int waits = 0; waits < 1000; ++waits) {
        while (const auto event = session.next_event())
            if (const auto* body = std::get_if<Body>(&event->body); body && matches(*body)) return *body;
        (void)session.wait(10s);
    }
    return std::nullopt;
}

std::optional<Outcome> wait_for_outcome(Session& session) {
    for (int waits = 0; waits < 1000; ++waits) {
        if (auto outcome = session.next_outcome()) return outcome;
        while (session.next_event()) {}
        (void)session.wait(10s);
    }
    return std::nullopt;
}

TEST(ProjectHost, PollsAndCarriesOutCommandsOfSeveralThreads) {
    const auto host = started(kPlant);
    const auto session = *host->open_session({.from_beginning = true});
    ASSERT_TRUE(wait_for<DeviceStateChanged>(
        *session, [](const auto& changed) { return changed.state == poll::DeviceState::answering; }));
    constexpr int kCommands = 50;
    const auto work = [&host](std::int64_t from) {
        const auto own = *host->open_session();
        const auto slot = *own->configuration()->find("Setpoint");
        for (std::int64_t i = from; i < from + kCommands; ++i) {
            ASSERT_TRUE(own->submit({Command::Kind::write, slot, i}));
            const auto outcome = wait_for_outcome(*own);
            ASSERT_TRUE(outcome);
            EXPECT_TRUE(outcome->result == value::CommandResult::done ||
                        outcome->reason == value::Reason::superseded);
            EXPECT_TRUE(value::same(outcome->value, i));
        }
    };
    std::thread one(work, 0);
    std::thread other(work, 1000);
    one.join();
    other.join();
    EXPECT_EQ(session->missed_events(), 0U);
}

TEST(ProjectHost, GivesSnapshotsWhileItRunsAndAfterItHasStopped) {
    const auto host = started(kPlant);
    const auto session = *host->open_session({.from_beginning = true});
    ASSERT_TRUE(wait_for<ValueChanged>(*session, [](const auto&) { return true; }));
    const auto running = session->snapshot({.statistics = true, .plan = true});
    ASSERT_TRUE(running);
    EXPECT_TRUE(running->lines[0].up);
    EXPECT_EQ(running->values.size(), 2U);
    host->stop();
    const auto stopped = session->snapshot({.statistics = true});
    ASSERT_TRUE(stopped);
    EXPECT_GE(stopped->lines[0].devices[0].counters.answered, running->lines[0].devices[0].counters.answered);
    EXPECT_FALSE(session->submit({Command::Kind::get, {0}, {}}));
    EXPECT_FALSE(host->open_session());
}

TEST(ProjectHost, AFailedStartDeliversItsNotices) {
    const ::takt::test::Folder folder;
    const auto registers = folder / "unit.registers";
    std::ofstream(registers) << "a user's notes, longer than a mark";
    std::vector<std::string> notices;
    HostOptions options;
    options.project_file = folder / "plant.yaml";
    options.on_failed_start = [&](const Notice& notice) { notices.push_back(notice.code); };
    auto project = project_of(R"(
takt: 1
servers:
  - name: gate
    listen: 127.0.0.1
    tcp_port: 1
    units:
      - address: 1
        state: unit.registers
        banks: [{area: holding_register, items: [0..9], retain: true}]
)");
    auto plan = plan::make_plan(project);
    const auto host = ProjectHost::start(std::move(project), std::move(plan), options);
    ASSERT_FALSE(host);
    EXPECT_EQ(host.error().code, Code::unsupported);
    EXPECT_EQ(notices, std::vector<std::string>{"app.registers.foreign"});
}

TEST(ProjectHost, ASessionMayOutliveTheHost) {
    auto host = started(kPlant);
    const auto session = *host->open_session({.from_beginning = true});
    host.reset();
    while (session->next_event()) {}
    EXPECT_FALSE(session->snapshot({}));
    EXPECT_FALSE(session->submit({Command::Kind::get, {0}, {}}));
}

TEST(ProjectHost, AppliesAnotherProjectWhileSessionsReadAndCommand) {
    const auto host = started(kPlant);
    const auto session = *host->open_session({.from_beginning = true});
    ASSERT_TRUE(wait_for<ValueChanged>(*session, [](const auto&) { return true; }));
    const auto before = session->snapshot({.statistics = true});
    ASSERT_TRUE(before);
    for (int i = 0; i < 20; ++i) {
        auto project = project_of(kPlant);
        auto plan = plan::make_plan(project);
        ASSERT_TRUE(host->apply(std::move(project), std::move(plan)));
    }
    EXPECT_EQ(host->configuration()->generation(), 21U);
    ASSERT_TRUE(wait_for<ConfigurationChanged>(*session,
                                               [](const auto& changed) { return changed.generation == 21; }));
    ASSERT_TRUE(session->submit(
        {Command::Kind::write, *session->configuration()->find("Setpoint"), std::int64_t{3}}));
    const auto outcome = wait_for_outcome(*session);
    ASSERT_TRUE(outcome);
    EXPECT_EQ(outcome->result, value::CommandResult::done);
    const auto after = session->snapshot({.statistics = true});
    ASSERT_TRUE(after);
    EXPECT_GE(after->lines[0].devices[0].counters.answered, before->lines[0].devices[0].counters.answered);
    EXPECT_EQ(after->lines[0].devices[0].counters.timeouts, 0U);
}

// The state file is read by the thread that applies; the ring of events has one writer, the I/O thread.
TEST(ProjectHost, NoticesOfTheThreadThatAppliesArriveBesideEventsOfTheLines) {
    constexpr int kNames = 2000;
    const takt::test::Folder folder;
    const auto state = folder / "plant.state";
    std::string locals;
    {
        const auto opened = store::RetainedFile::open(state, {});
        ASSERT_TRUE(opened);
        for (int i = 0; i < kNames; ++i) {
            const auto name = fmt::format("local{}", i);
            opened->file->put({.name = name, .type = DataType::int16, .value = std::int64_t{-7}});
            locals += fmt::format("  - {{name: {}, type: bool, retain: true}}\n", name);
        }
        opened->file->close();
    }
    const auto host = started(kPlant, {.state_file = state});
    const auto session = *host->open_session({.from_beginning = true});
    std::atomic<bool> applied = false;
    std::size_t writes = 0;
    std::thread commanding([&] {
        const auto own = *host->open_session();
        for (std::int64_t i = 0; !applied; ++i) {
            ASSERT_TRUE(
                own->submit({Command::Kind::write, *own->configuration()->find("Setpoint"), i % 100}));
            const auto outcome = wait_for_outcome(*own);
            ASSERT_TRUE(outcome);
            writes +=
                outcome->error ? 0U : 1U;  // an error: it came too late for the project that it was meant for
        }
    });
    auto project = project_of(project_with(line_of("main", boiler(), "tcp"), locals));
    auto plan = plan::make_plan(project);
    EXPECT_TRUE(host->apply(std::move(project), std::move(plan)));
    applied = true;
    commanding.join();
    host->stop();
    std::set<std::string> names;
    std::set<CommandId> finished;
    std::uint64_t events = 0;
    while (const auto event = session->next_event()) {
        EXPECT_EQ(event->number, events++);
        if (const auto* const notice = std::get_if<Notice>(&event->body)) {
            EXPECT_EQ(notice->code, "app.retain.other_type");
            for (const auto& [key, value] : notice->arguments)
                EXPECT_TRUE(key != "name" || names.insert(value).second) << value;
        }
        const auto* const write = std::get_if<WriteFinished>(&event->body);
        EXPECT_TRUE(!write || finished.insert(write->outcome.id).second);
    }
    EXPECT_EQ(session->missed_events(), 0U);
    EXPECT_EQ(names.size(), static_cast<std::size_t>(kNames));
    EXPECT_EQ(finished.size(), writes);
}

// With 1000 devices a snapshot takes many slices: the host stops while most of the sessions wait for one.
TEST(ProjectHost, SnapshotsInProgressEndWhenTheHostStops) {
    std::string lines;
    for (int l = 0; l < 10; ++l) {
        std::string devices;
        for (int d = 0; d < 100; ++d)
            devices += device_of(fmt::format("d{}_{}", l, d), d + 1,
                                 variable_of(fmt::format("v{}_{}", l, d), 0, ", period: 1h"));
        lines += line_of(fmt::format("line{}", l), devices, "tcp");
    }
    const auto yaml = project_with(lines);
    for (const bool and_destroy : {false, true}) {
        SCOPED_TRACE(and_destroy);
        auto host = started(yaml);
        std::latch running(4);
        std::vector<std::thread> faces;
        for (int i = 0; i < 4; ++i)
            faces.emplace_back([&running, session = std::shared_ptr<Session>(*host->open_session())] {
                running.count_down();
                const Command get{.kind = Command::Kind::get, .slot = {0}};
                do {
                    const auto state = session->snapshot({.statistics = true}, 30s);
                    EXPECT_TRUE(state ? state->values.size() == 1000U
                                      : state.error().code == Code::connection_lost);
                    while (session->next_outcome()) {}
                } while (session->submit(get));  // until the host has stopped
                const auto last = session->snapshot({}, 30s);
                EXPECT_TRUE(last || last.error().code == Code::connection_lost);
            });
        running.wait();
        host->stop();
        if (and_destroy) host.reset();
        for (auto& face : faces) face.join();
    }
}

/// A project whose devices do not answer for a minute, with a server in front of them.
model::Project silent_plant_with_server(const takt::test::Folder& folder) {
    const std::string slow = ", response_timeout: 60s";
    auto project = project_of(project_with(
        line_of("main", device_of("Boiler", 1,
                                  variable_of("Level", 0) + variable_of("Setpoint", 10, kOnChange), slow) +
                            device_of("Pump", 2, variable_of("Speed", 0), slow)),
        {}, R"(  - name: panel
    listen: 127.0.0.1
    tcp_port: 1502
    audit: audit.log
    relay:
      - {line: main, units: [2]}
    units:
      - address: 1
        banks:
          - {area: holding_register, items: [0..9]}
        variables:
          - {name: Wanted, type: int16, area: holding_register, register: 1, writes_to: {variable: Setpoint}}
)"));
    project.servers.at(0).tcp_port = 0;  // one that is free
    project.files = {folder / "plant.yaml"};
    return project;
}

/// The port on which the project's server answers.
std::uint16_t port_of(Session& session) {
    const auto serving =
        wait_for<Notice>(session, [](const Notice& notice) { return notice.code == "app.serving"; });
    EXPECT_TRUE(serving);
    for (const auto& [key, value] : serving->arguments)
        if (key == "where") return static_cast<std::uint16_t>(std::stoi(value.substr(value.rfind(':') + 1)));
    return 0;
}

/// A client of a server.
class Client {
public:
    explicit Client(std::uint16_t port) : socket_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_port = htons(port);
        address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        EXPECT_EQ(::connect(socket_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    }
    void send(std::initializer_list<std::uint8_t> adu) {
        EXPECT_EQ(::write(socket_.get(), adu.begin(), adu.size()), static_cast<ssize_t>(adu.size()));
    }
    /// Blocks until bytes arrive; none: the connection was closed.
    std::vector<std::uint8_t> receive() {
        std::vector<std::uint8_t> bytes(260);
        const auto count = ::read(socket_.get(), bytes.data(), bytes.size());
        bytes.resize(count < 0 ? 0 : static_cast<std::size_t>(count));
        return bytes;
    }

private:
    os::Descriptor socket_;
};

constexpr std::initializer_list<std::uint8_t> kWriteWanted = {0, 1, 0, 0, 0, 6, 1, 6, 0, 1, 0, 42};
constexpr std::initializer_list<std::uint8_t> kWriteRelayed = {0, 2, 0, 0, 0, 6, 2, 6, 0, 3, 0, 43};

/// Waits until the server has got that many requests.
void wait_for_requests(Session& tap, int requests) {
    while (requests > 0) {
        while (const auto record = tap.next_traffic())
            requests -= record->source.kind == TrafficSource::Kind::endpoint &&
                                record->direction == wire::Direction::received
                            ? 1
                            : 0;
        (void)tap.wait(10s);
    }
}

TEST(ProjectHost, WritesThatAreUnansweredAtTheEndAreAuditedBeforeIt) {
    const takt::test::Folder folder;
    const auto host =
        started(silent_plant_with_server(folder),
                {.project_file = folder / "plant.yaml", .prepare = [](std::size_t, sim::Devices& devices) {
                     for (const UnitId unit : {UnitId{1}, UnitId{2}})
                         devices.find(unit)->behaviour.dead = true;
                 }});
    const auto session = *host->open_session({.traffic = true, .from_beginning = true});
    const auto port = port_of(*session);
    Client bound(port);
    Client relayed(port);
    bound.send(kWriteWanted);
    relayed.send(kWriteRelayed);
    wait_for_requests(*session, 2);
    host->stop();
    std::string audited;
    while (const auto event = session->next_event())
        if (const auto* const audit = std::get_if<AuditRecorded>(&event->body))
            audited += endpoint::audit_line(audit->record);
    EXPECT_EQ(audited, folder.read("audit.log"));
    EXPECT_NE(audited.find(R"("unit":1)"), std::string::npos) << audited;
    EXPECT_NE(audited.find(R"("event":"refused")"), std::string::npos)
        << "what was not written to the device";
    EXPECT_NE(audited.find(R"("unit":2)"), std::string::npos) << "it may have been executed";
    EXPECT_EQ(session->missed_events(), 0U);
}

TEST(ProjectHost, ClientsOfServersThatDidNotChangeStayConnected) {
    const takt::test::Folder folder;
    const auto changed = [&](auto change) {
        auto project = silent_plant_with_server(folder);
        project.servers.push_back(project.servers[0]);
        project.servers[1].name = "other";
        project.servers[1].relays.clear();
        project.servers[1].units[0].bindings.clear();
        change(project);
        return project;
    };
    const auto host = started(changed([](const model::Project&) {}), {.project_file = folder / "plant.yaml"});
    const auto session = *host->open_session({.from_beginning = true});
    Client kept(port_of(*session));
    Client closed(port_of(*session));
    const auto ask = [](Client& client) {
        client.send({0, 1, 0, 0, 0, 6, 1, 3, 0, 5, 0, 1});
        const auto answer = client.receive();
        return answer.empty() ? -1 : answer.back();
    };
    kept.send({0, 1, 0, 0, 0, 6, 1, 6, 0, 5, 0, 42});
    EXPECT_EQ(kept.receive().size(), 12U);
    EXPECT_EQ(ask(closed), 0);
    for (std::uint16_t turn = 1; turn <= 5; ++turn) {
        auto project = changed([&](model::Project& next) {
            next.servers[1].limits.max_connections = 100U + turn;
            std::swap(next.servers[0], next.servers[1]);
            next.lines.insert(next.lines.begin(),
                              project_of(project_with(line_of("first", pump()))).lines[0]);
            next.lines[0].devices[0].variables[0].name = "New speed";
            for (auto& relay : next.servers[1].relays) relay.line = 1;
        });
        auto plan = plan::make_plan(project);
        ASSERT_TRUE(host->apply(std::move(project), std::move(plan)));
        EXPECT_EQ(ask(kept), 42) << "the connection and the register";
        EXPECT_TRUE(closed.receive().empty()) << "its server has changed";
    }
    const auto state = session->snapshot({.endpoints = true});
    ASSERT_TRUE(state);
    ASSERT_EQ(state->endpoints.listeners.size(), 2U);
    EXPECT_EQ(state->endpoints.listeners[1].counters.requests, 6U) << "counted from before";
}

TEST(ProjectHost, SnapshotsHaveTheStatisticsOfServersWhileTheyWorkAndAfterwards) {
    const takt::test::Folder folder;
    const auto host = started(silent_plant_with_server(folder), {.project_file = folder / "plant.yaml"});
    const auto session = *host->open_session({.from_beginning = true});
    Client client(port_of(*session));
    client.send({0, 1, 0, 0, 0, 6, 1, 3, 0, 0, 0, 1});
    EXPECT_EQ(client.receive().size(), 11U);
    EXPECT_TRUE(session->snapshot({})->endpoints.listeners.empty()) << "not asked for";
    for (const bool stopped : {false, true}) {
        SCOPED_TRACE(stopped);
        if (stopped) host->stop();
        const auto state = session->snapshot({.endpoints = true});
        ASSERT_TRUE(state);
        ASSERT_EQ(state->endpoints.listeners.size(), 1U);
        const auto& listener = state->endpoints.listeners[0];
        EXPECT_NE(listener.where.find("tcp://127.0.0.1:"), std::string::npos);
        EXPECT_EQ(listener.counters.requests, 1U);
        ASSERT_TRUE(listener.connections);
        EXPECT_EQ(listener.connections->counters.accepted, 1U);
        EXPECT_EQ(state->endpoints.relayed.size(), 1U);
    }
    EXPECT_EQ(host->served().listeners[0].counters.requests, 1U);
}

}  // namespace
}  // namespace takt::host::test
