#include "devices/device_search.hpp"

#include <algorithm>
#include <utility>

#include "takt/client/client.hpp"
#include "takt/client/probe_connection.hpp"
#include "takt/model/target_url.hpp"
#include "takt/os/thread_name.hpp"
#include "takt/report/states/probe_report.hpp"

namespace takt::web {
namespace {

constexpr Duration kProgressEvery = std::chrono::milliseconds(100);

}  // namespace

/// Notes what a scan finds.
class DeviceSearch::Scan final : private bus::ScanObserver {
public:
    Scan(DeviceSearch& search, line::Loop& loop, ScanOrder order)
        : search_(search), loop_(loop), scans_(loop, *this), progress_(loop, [this](Instant t) {
              note_progress();
              progress_.set(after(t, kProgressEvery));
          }) {
        for (auto& [target, config] : order.targets) {
            client::PortScan::Options options;
            options.scan.scan = std::move(config);
            if (order.open) options.open = order.open;
            scans_.add(std::move(target), std::move(options));
        }
    }

    void run() {
        scans_.begin();
        progress_.set(line::now());
        const bool complete = loop_.run_until([this] { return scans_.ended(); }, kLongest);
        note_progress();
        const std::lock_guard lock(search_.mutex_);
        auto& findings = search_.state_.findings;
        findings.complete = complete;
        findings.duration = line::now() - search_.started_;
        findings.requests = search_.state_.requests;
        findings.reached = scans_.totals().reached;
    }

private:
    void note_progress() {
        const auto totals = scans_.totals();
        const auto* const current = scans_.current();
        const std::lock_guard lock(search_.mutex_);
        auto& state = search_.state_;
        state.done = totals.done;
        state.total = totals.total;
        state.requests = totals.requests;
        if (current) state.where = model::url_of(current->line());
    }
    void on_device(const bus::FoundDevice& device) override {
        const std::lock_guard lock(search_.mutex_);
        search_.state_.findings.devices.push_back(device);
    }
    void on_trouble(const bus::ScanTrouble& trouble) override {
        const std::lock_guard lock(search_.mutex_);
        search_.state_.findings.troubles.push_back(trouble);
    }
    void on_absent_host() override {
        const std::lock_guard lock(search_.mutex_);
        ++search_.state_.findings.absent_hosts;
    }

    DeviceSearch& search_;
    line::Loop& loop_;
    client::PortScans scans_;
    line::Timer progress_;
};

DeviceSearch::~DeviceSearch() {
    end();
}

Result<std::uint64_t> DeviceSearch::start(ScanOrder order) {
    auto name = order.project_line;
    auto shared = std::make_shared<ScanOrder>(std::move(order));
    return start(
        Kind::scan, [this, shared](line::Loop& loop) { scan(loop, std::move(*shared)); }, std::move(name));
}

Result<std::uint64_t> DeviceSearch::start(ProbeOrder order) {
    auto shared = std::make_shared<const ProbeOrder>(std::move(order));
    return start(Kind::probe, [this, shared](line::Loop& loop) { probe(loop, *shared); });
}

Result<std::uint64_t> DeviceSearch::start(Kind kind, std::function<void(line::Loop&)> work,
                                          std::string project_line) {
    const std::lock_guard lock(mutex_);
    if (state_.running || ended_) return fail(Code::busy);
    TAKT_TRY(auto loop, line::Loop::create());
    if (thread_.joinable()) thread_.join();  // it has left its last critical section
    loop_ = std::move(loop);
    started_ = line::now();
    State next{.id = state_.id + 1, .kind = kind, .running = true, .project_line = std::move(project_line)};
    if (kind == Kind::probe) {
        next.findings = std::move(state_.findings);
        next.probed = std::move(state_.probed);
        next.project_line = std::move(state_.project_line);
    }
    state_ = std::move(next);
    thread_ = std::thread([this, work = std::move(work)] { run(work); });
    return state_.id;
}

void DeviceSearch::run(const std::function<void(line::Loop&)>& work) {
    os::name_thread("takt-search");
    std::shared_ptr<line::Loop> loop;
    {
        const std::lock_guard lock(mutex_);
        loop = loop_;
    }
    work(*loop);
    const std::lock_guard lock(mutex_);
    loop_.reset();
    state_.running = false;
    state_.elapsed = line::now() - started_;
}

void DeviceSearch::scan(line::Loop& loop, ScanOrder order) {
    Scan(*this, loop, std::move(order)).run();
}

void DeviceSearch::probe(line::Loop& loop, const ProbeOrder& order) {
    client::Options options{.target = model::url_of(order.line), .unit = order.unit.value};
    options.timeout = order.timeout;
    options.attempts = 2;
    options.adaptive = options.reconnect = true;
    const auto failed = [this](const Error& error) {
        const std::lock_guard lock(mutex_);
        state_.error = error;
    };
    if (!order.name.empty()) options.target = order.name;
    auto opened = client::connect(loop, order.line, options, order.open ? order.open : line::open_line);
    if (!opened) return failed(opened.error());
    client::Client device(*std::move(opened), options);
    client::ProbeConnection connection(device);
    auto findings = bus::probe_device(order.config, connection, [&](const bus::ProbeProgress& at) {
        const std::lock_guard lock(mutex_);
        state_.done = std::min(at.asked, at.expected);
        state_.total = at.expected;
        state_.requests = device.transmissions();
        state_.where = report::probe_progress(at);
    });
    if (findings.no_answer) return failed(*findings.no_answer);
    const std::lock_guard lock(mutex_);
    state_.error = findings.lost;
    std::erase_if(state_.probed, [&](const Probed& other) {
        return other.unit == order.unit && model::url_of(other.line) == model::url_of(order.line);
    });
    state_.probed.push_back({.line = order.line,
                             .project_line = order.project_line,
                             .unit = order.unit,
                             .findings = std::move(findings),
                             .transmissions = device.transmissions(),
                             .duration = line::now() - started_,
                             .interrupted = device.interrupted()});
}

void DeviceSearch::cancel() {
    const std::lock_guard lock(mutex_);
    if (!loop_) return;
    state_.cancelled = true;
    loop_->stop();
}

void DeviceSearch::end() {
    {
        const std::lock_guard lock(mutex_);
        ended_ = true;
    }
    cancel();
    if (thread_.joinable()) thread_.join();
}

DeviceSearch::State DeviceSearch::state() const {
    const std::lock_guard lock(mutex_);
    State copy = state_;
    if (copy.running) copy.elapsed = line::now() - started_;
    return copy;
}

}  // namespace takt::web
