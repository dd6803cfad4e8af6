// A real host on simulated lines, as the web module reaches it.
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>

#include "projects.hpp"
#include "takt/host/project_file.hpp"
#include "takt/host/project_host.hpp"
#include "takt/web/host_access.hpp"
#include "takt/web/stream.hpp"

namespace takt::web::test {

using namespace std::chrono_literals;

class RunningHost {
public:
    explicit RunningHost(const std::string& yaml) {
        auto loaded = host::load_project_text("test.yaml", yaml);
        if (loaded.has_errors()) throw std::runtime_error(loaded.findings.front().code + '\n' + yaml);
        auto plan = host::prove(loaded, false, false).plan;
        auto started = host::ProjectHost::start(loaded.project, std::move(plan), {});
        EXPECT_TRUE(started);
        host = *std::move(started);
    }

    [[nodiscard]] HostAccess access() {
        return {.open_session = [this](const auto& options) { return host->open_session(options); },
                .configuration = [this] { return host->configuration(); },
                .started = host->started()};
    }

    void apply(const std::string& yaml) {
        auto loaded = host::load_project_text("test.yaml", yaml);
        auto plan = host::prove(loaded, false, false).plan;
        EXPECT_TRUE(host->apply(std::move(loaded.project), std::move(plan)));
    }

    std::unique_ptr<host::ProjectHost> host;
};

/// Takes from a stream until the text has what is wanted. @returns everything taken
inline std::string take_until(StreamSource& stream, const std::function<bool(const std::string&)>& enough) {
    std::string text;
    for (const auto end = std::chrono::steady_clock::now() + 10s; std::chrono::steady_clock::now() < end;) {
        if (!stream.take(text) || enough(text)) return text;
        std::this_thread::sleep_for(5ms);
    }
    ADD_FAILURE() << "the stream did not have it: " << text.substr(0, 2000);
    return text;
}

inline std::string take_until(StreamSource& stream, const std::string& wanted) {
    return take_until(stream,
                      [&](const std::string& text) { return text.find(wanted) != std::string::npos; });
}

inline std::size_t count_of(const std::string& text, const std::string& part) {
    std::size_t count = 0;
    for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
    return count;
}

}  // namespace takt::web::test
