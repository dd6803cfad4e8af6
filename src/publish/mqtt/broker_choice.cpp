#include "mqtt/broker_choice.hpp"

#include <algorithm>
#include <utility>

namespace takt::publish {
namespace {

// A failure that goes away only when a user or an administrator acts.
bool needs_user(MqttFailureKind kind) {
    switch (kind) {
        case MqttFailureKind::tls_unknown_issuer:
        case MqttFailureKind::tls_expired:
        case MqttFailureKind::tls_other_name:
        case MqttFailureKind::tls_files:
        case MqttFailureKind::tls:
        case MqttFailureKind::version:
        case MqttFailureKind::not_authorized:
        case MqttFailureKind::quota: return true;
        default: return false;
    }
}

// No program answers there: an attempt costs the broker nothing.
bool is_absent(MqttFailureKind kind) {
    return kind == MqttFailureKind::refused || kind == MqttFailureKind::unreachable ||
           kind == MqttFailureKind::timed_out;
}

// A broker of 3.1.1 answers CONNECT of MQTT 5 with a return code or closes the connection (3.1.1, 3.1.2.2).
bool may_be_version(const MqttFailure& failure) {
    if (failure.kind == MqttFailureKind::version) return true;
    return failure.reason == MqttReason::success &&
           (failure.kind == MqttFailureKind::lost || failure.kind == MqttFailureKind::protocol);
}

}  // namespace

BrokerChoice::BrokerChoice(const MqttSessionOptions& options)
    : options_(options),
      known_(options.brokers.size()),
      pause_(options.first_pause),
      random_(options.seed ^ 0x9E3779B97F4A7C15) {}

MqttVersion BrokerChoice::version() const {
    if (options_.versions == MqttVersions::only_5) return MqttVersion::v5;
    if (options_.versions == MqttVersions::only_3_1_1) return MqttVersion::v3_1_1;
    const Known& known = known_[index_];
    return known.try_3_1_1 ? MqttVersion::v3_1_1 : known.version.value_or(MqttVersion::v5);
}

std::optional<MqttMessage> BrokerChoice::will() const {
    auto will = options_.will;
    if (!will) return will;
    if (known_[index_].no_retain) will->retain = false;
    if (known_[index_].qos_0_only) will->qos = 0;
    return will;
}

void BrokerChoice::on_connected(Instant now) {
    Known& known = known_[index_];
    known.version = version();
    known.try_3_1_1 = false;
    connected_at_ = now;
    all_need_user_ = all_nearby_ = true;
    if (index_ == 0) {
        failed_returns_ = 0;
        return_at_ = kNever;
    } else {
        return_at_ = after(now, options_.return_after * (1U << std::min(failed_returns_, 3U)));
        ++failed_returns_;
    }
}

Duration BrokerChoice::on_failed(const MqttFailure& failure, bool nearby) {
    if (try_otherwise(failure)) return Duration::zero();
    all_need_user_ = all_need_user_ && needs_user(failure.kind);
    all_nearby_ = all_nearby_ && nearby && is_absent(failure.kind);
    if (++index_ < known_.size()) return Duration::zero();
    index_ = 0;
    const bool need_user = std::exchange(all_need_user_, true);
    const bool are_nearby = std::exchange(all_nearby_, true);
    return next_pause(need_user ? options_.refused_pause : Duration::zero(),
                      are_nearby ? options_.longest_nearby_pause : kNoLimit);
}

Duration BrokerChoice::on_lost(Instant now, const MqttFailure& failure) {
    if (now - connected_at_ >= options_.stable_after) pause_ = options_.first_pause;
    index_ = 0;
    return_at_ = kNever;
    if (failure.kind == MqttFailureKind::session_taken_over) return next_pause(options_.taken_over_pause);
    return next_pause(needs_user(failure.kind) ? options_.refused_pause : Duration::zero());
}

// Whether the same broker may accept another kind of CONNECT. Each kind is tried once.
bool BrokerChoice::try_otherwise(const MqttFailure& failure) {
    Known& known = known_[index_];
    if (failure.reason == MqttReason::retain_not_supported && options_.will && !known.no_retain)
        return known.no_retain = true;
    if (failure.reason == MqttReason::qos_not_supported && options_.will && !known.qos_0_only)
        return known.qos_0_only = true;
    if (options_.versions != MqttVersions::automatic) return false;
    if (version() == MqttVersion::v5)
        return known.try_3_1_1 =
                   may_be_version(failure) && (!known.version || failure.kind == MqttFailureKind::version);
    if (known.try_3_1_1 || failure.kind == MqttFailureKind::version) known.version.reset();
    known.try_3_1_1 = false;
    return false;
}

Duration BrokerChoice::next_pause(Duration least, Duration most) {
    const Duration pause = std::min(std::max(pause_, 2 * least), most);
    pause_ = std::min(2 * pause_, options_.longest_pause);
    return pause - pause * static_cast<Duration::rep>(draw() % 1024) / 2048;
}

std::uint64_t BrokerChoice::draw() {
    random_ = random_ * 6364136223846793005U + 1442695040888963407U;  // Knuth, MMIX
    return random_ >> 33;
}

}  // namespace takt::publish
