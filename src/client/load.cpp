#include "takt/client/load.hpp"

#include <algorithm>
#include <cerrno>
#include <utility>

#include "load_connection.hpp"
#include "takt/line/target.hpp"

namespace takt::client {
namespace {

constexpr Duration kSecond = std::chrono::seconds(1);
constexpr Duration kGiveUp = std::chrono::seconds(10);
constexpr Duration kDrainMargin = std::chrono::seconds(2);

}  // namespace

// Whole periods first, so that no product overflows.
Duration Rate::offset(std::uint64_t number) const {
    const auto whole = static_cast<std::int64_t>(number / requests);
    const auto rest = static_cast<std::int64_t>(number % requests);
    return whole * per + rest * per / static_cast<std::int64_t>(requests);
}

std::uint64_t Rate::before(Duration time) const {
    const auto whole = static_cast<std::uint64_t>(time / per) * requests;
    const auto rest = static_cast<std::uint64_t>((time % per).count()) * requests;
    const auto period = static_cast<std::uint64_t>(per.count());
    return whole + (rest + period - 1) / period;
}

Load::Load(line::Loop& loop, const LoadOptions& options, capture::LatencyReport& report)
    : loop_(loop),
      options_(options),
      report_(report),
      timer_(loop, [this](Instant t) { offer(t); }),
      clock_(loop, [this](Instant t) { report_progress(t); }) {}

Load::~Load() = default;

Result<void> Load::connect(const OpenLine& open) {
    TAKT_TRY(const auto target, line::parse_target(options_.target.target));
    const auto line = target.as_line();
    auto config = one_off_line(line);
    if (options_.connections > 1 && line.transport == model::Transport::serial)
        return fail(Code::unsupported, "connections", static_cast<std::int64_t>(options_.connections));
    if (options_.in_flight > 1 && line.framing != wire::Framing::tcp)
        return fail(Code::unsupported, "in_flight", static_cast<std::int64_t>(options_.in_flight));
    config.in_flight = options_.in_flight;
    for (std::size_t i = 0; i < options_.connections; ++i) {
        connections_.push_back(std::make_unique<LoadConnection>(*this, config));
        TAKT_CHECK(connections_.back()->open(line, open));
    }
    const auto failed = [](const auto& each) { return !each->up() && each->link_error().has_value(); };
    const auto up = [](const auto& each) { return each->up(); };
    loop_.run_until(
        [&] { return std::ranges::any_of(connections_, failed) || std::ranges::all_of(connections_, up); },
        options_.target.timeout);
    if (const auto found = std::ranges::find_if(connections_, failed); found != connections_.end())
        return std::unexpected(*(*found)->link_error());
    if (std::ranges::all_of(connections_, up)) return {};
    return fail(Code::cannot_open, options_.target.target, loop_.stopped() ? ECANCELED : ETIMEDOUT);
}

Result<void> Load::run(const std::function<void(const LoadProgress&)>& progress) {
    using namespace std::chrono;
    progress_ = progress;
    start_ = up_at_ = line::now();
    counts_.begin_ns = duration_cast<nanoseconds>(line::wall_clock(start_).time_since_epoch()).count();
    if (options_.time) end_ = after(start_, *options_.time);
    running_ = true;
    clock_.set(start_ + kSecond);
    offer(start_);
    loop_.run_until([this] { return done(line::now()); }, options_.time ? end_ - start_ : Duration::max());
    const Instant ended = line::now();
    running_ = false;
    if (!loop_.stopped() && !failure_)
        loop_.run_until([this] { return in_flight_ == 0; }, options_.target.timeout + kDrainMargin);
    finish(ended);
    if (failure_) return std::unexpected(*failure_);
    return {};
}

bool Load::done(Instant t) const {
    if (failure_ || t >= end_) return true;
    return options_.count && next_ >= *options_.count && in_flight_ == 0;
}

// A request that is due now, unless the measurement has ended.
std::optional<Load::Due> Load::due(Instant t) const {
    if (!running_ || failure_ || t >= end_ || (options_.count && next_ >= *options_.count))
        return std::nullopt;
    const Instant intended = options_.rate ? after(start_, options_.rate->offset(next_)) : t;
    if (intended > t) return std::nullopt;
    return Due{next_, intended};
}

void Load::take() {
    ++next_;
    arm();
}

void Load::arm() {
    if (!options_.rate) return;
    const bool all = options_.count && next_ >= *options_.count;
    timer_.set(all ? kNever : after(start_, options_.rate->offset(next_)));
}

// One request to each connection in turn, so that the load is the same on all of them.
void Load::offer(Instant t) {
    if (connections_.empty()) return;
    for (std::size_t idle = 0; idle < connections_.size() && due(t);) {
        auto& connection = *connections_[next_connection_];
        next_connection_ = (next_connection_ + 1) % connections_.size();
        if (!connection.has_room()) {
            ++idle;
            continue;
        }
        idle = 0;
        connection.take_one(t);
        connection.poke();
    }
}

bool Load::any_up() const {
    return std::ranges::any_of(connections_, [](const auto& each) { return each->up(); });
}

void Load::report_progress(Instant t) {
    clock_.set(t + kSecond);
    if (any_up()) up_at_ = t;
    if (!options_.time && t - up_at_ > kGiveUp)
        failure_ = fail(Code::connection_lost, options_.target.target).error();
    second_.elapsed = t - start_;
    second_.sent = next_;
    if (progress_ && running_) progress_(second_);
    second_ = {};
}

void Load::finish(Instant t) {
    t = std::min(t, end_);
    for (auto& connection : connections_) {
        connection->end(t);
        counts_.unexpected += connection->unexpected();
    }
    counts_.elapsed = t - start_;
    if (options_.rate) {
        const auto due = std::min(options_.count.value_or(UINT64_MAX), options_.rate->before(t - start_));
        counts_.unsent = due > next_ ? due - next_ : 0;
        report_.on_unsent(observed(next_, t), counts_.unsent);
    }
    report_.end(wall_ns(line::now()));
}

capture::ObservedRequest Load::observed(std::uint64_t number, Instant t) const {
    return {.unit = options_.target.unit,
            .function = options_.request.function(),
            .items = capture::items_of(options_.request.pdu()),
            .packet = {number + 1, wall_ns(t)}};
}

}  // namespace takt::client
