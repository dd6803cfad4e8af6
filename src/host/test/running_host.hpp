// A host with its I/O thread, started by a test, and waits that end with an event.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "rig.hpp"
#include "takt/host/project_host.hpp"
#include "takt/plan/plan.hpp"

namespace takt::host::test {

[[nodiscard]] inline std::unique_ptr<ProjectHost> started(model::Project project,
                                                          const HostOptions& options = {}) {
    auto plan = plan::make_plan(project);
    auto host = ProjectHost::start(std::move(project), std::move(plan), options);
    EXPECT_TRUE(host);
    return host ? *std::move(host) : nullptr;
}

[[nodiscard]] inline std::unique_ptr<ProjectHost> started(const std::string& yaml,
                                                          const HostOptions& options = {}) {
    return started(project_of(yaml), options);
}

template <class Body, class Matches>
[[nodiscard]] std::optional<Body> wait_for(Session& session, Matches matches) {
    for (int waits = 0; waits < 1000; ++waits) {
        while (const auto event = session.next_event())
            if (const auto* body = std::get_if<Body>(&event->body); body && matches(*body)) return *body;
        (void)session.wait(10s);
    }
    return std::nullopt;
}

[[nodiscard]] inline std::optional<Outcome> wait_for_outcome(Session& session) {
    for (int waits = 0; waits < 1000; ++waits) {
        if (auto outcome = session.next_outcome()) return outcome;
        while (session.next_event()) {}
        (void)session.wait(10s);
    }
    return std::nullopt;
}

}  // namespace takt::host::test
