// A host with servers on real ports: its clients, its threads and its end.
#include <gtest/gtest.h>

#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <string>
#include <utility>
#include <vector>

#include "../../src/host/test/projects.hpp"
#include "../../src/host/test/running_host.hpp"
#include "folder.hpp"
#include "takt/endpoint/audit_log.hpp"
#include "takt/os/descriptor.hpp"

namespace takt::host::test {
namespace servers_test {

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
        wait_for<Notice>(session, [](const Notice& notice) { return notice.code == "endpoint.serving"; });
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

TEST(HostServers, WritesThatAreUnansweredAtTheEndAreAuditedBeforeIt) {
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

TEST(HostServers, ClientsOfServersThatDidNotChangeStayConnected) {
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

TEST(HostServers, SnapshotsHaveTheStatisticsOfServersWhileTheyWorkAndAfterwards) {
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

}  // namespace servers_test
}  // namespace takt::host::test
