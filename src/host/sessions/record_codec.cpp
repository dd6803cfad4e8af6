// An event or a frame as words of 64 bits, for BroadcastRing. One function visits the members of each
// structure, for writing and for reading, so the two cannot differ. A number is one word; a text is its
// length in bytes, then its bytes packed eight to a word; a variant is its index, then its members. Texts are
// cut at kLongestText bytes.
#include "sessions/record_codec.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <chrono>
#include <concepts>
#include <cstring>
#include <string>
#include <type_traits>
#include <utility>

#include "takt/base/assert.hpp"

namespace takt::host {
namespace {

/// Visits members by appending them to a record.
class WordWriter {
public:
    static constexpr bool kReads = false;
    explicit WordWriter(std::vector<std::uint64_t>& record) : record_(record) {}

    void word(std::uint64_t value) { record_.push_back(value); }
    void bytes(std::string_view bytes) {
        const auto size = std::min(bytes.size(), kLongestText);
        word(size);
        for (std::size_t at = 0; at < size; at += sizeof(std::uint64_t)) {
            std::uint64_t packed = 0;
            std::memcpy(&packed, bytes.data() + at, std::min(sizeof packed, size - at));
            word(packed);
        }
    }

private:
    std::vector<std::uint64_t>& record_;
};

/// Visits members by taking them from a record.
class RecordReader {
public:
    static constexpr bool kReads = true;
    explicit RecordReader(std::span<const std::uint64_t> record) : record_(record) {}

    std::uint64_t word() {
        TAKT_ASSERT(at_ < record_.size());
        return record_[at_++];
    }
    std::string_view bytes() {
        const auto size = static_cast<std::size_t>(word());
        const auto words = (size + sizeof(std::uint64_t) - 1) / sizeof(std::uint64_t);
        TAKT_ASSERT(words <= record_.size() - at_);
        const auto* first = reinterpret_cast<const char*>(record_.data() + at_);
        at_ += words;
        return {first, size};
    }

private:
    std::span<const std::uint64_t> record_;
    std::size_t at_ = 0;
};

template <class T>
concept Scalar = std::integral<T> || std::is_enum_v<T>;

template <class Archive, Scalar T>
void fields(Archive& archive, T& value) {
    if constexpr (Archive::kReads)
        value = static_cast<T>(archive.word());
    else
        archive.word(static_cast<std::uint64_t>(value));
}

template <class Archive>
void fields(Archive& archive, double& value) {
    if constexpr (Archive::kReads)
        value = std::bit_cast<double>(archive.word());
    else
        archive.word(std::bit_cast<std::uint64_t>(value));
}

template <class Archive>
void fields(Archive& archive, Duration& value) {
    auto count = value.count();
    fields(archive, count);
    value = Duration(count);
}

template <class Archive>
void fields(Archive& archive, Instant& value) {
    auto since = value.time_since_epoch();
    fields(archive, since);
    value = Instant(since);
}

template <class Archive>
void fields(Archive& archive, std::string& value) {
    if constexpr (Archive::kReads)
        value.assign(archive.bytes());
    else
        archive.bytes(value);
}

template <class Archive>
void fields(Archive& archive, std::vector<std::uint8_t>& value) {
    if constexpr (Archive::kReads) {
        const auto bytes = archive.bytes();
        value.assign(bytes.begin(), bytes.end());
    } else {
        archive.bytes({reinterpret_cast<const char*>(value.data()), value.size()});
    }
}

template <class Archive, class T>
void fields(Archive& archive, std::optional<T>& value) {
    bool there = value.has_value();
    fields(archive, there);
    if constexpr (Archive::kReads) value = there ? std::optional(T{}) : std::nullopt;
    if (there) fields(archive, *value);
}

template <std::size_t I = 0, class Archive, class... Ts>
void alternative(Archive& archive, std::variant<Ts...>& value, std::size_t index) {
    if constexpr (I < sizeof...(Ts)) {
        if (index != I) return alternative<I + 1>(archive, value, index);
        if constexpr (Archive::kReads) value.template emplace<I>();
        if constexpr (!std::is_same_v<std::variant_alternative_t<I, std::variant<Ts...>>, std::monostate>)
            fields(archive, *std::get_if<I>(&value));
    }
}

template <class Archive, class... Ts>
void fields(Archive& archive, std::variant<Ts...>& value) {
    auto index = value.index();
    fields(archive, index);
    alternative(archive, value, index);
}

/// Visits members one after another.
template <class Archive, class... Members>
void all(Archive& archive, Members&... members) {
    (fields(archive, members), ...);
}

template <class Archive>
void fields(Archive& archive, value::SlotId& slot) {
    fields(archive, slot.value);
}

template <class Archive>
void fields(Archive& archive, Mismatch& mismatch) {
    all(archive, mismatch.part, mismatch.came, mismatch.asked);
}

template <class Archive>
void fields(Archive& archive, Error& error) {
    fields(archive, error.code);
    if constexpr (Archive::kReads)
        error.subject.assign(archive.bytes());
    else
        archive.bytes(error.subject.view());
    for (auto& number : error.numbers) fields(archive, number);
}

template <class Archive>
void fields(Archive& archive, RequestKey& key) {
    all(archive, key.line, key.device, key.read, key.write, key.start, key.quantity);
}

template <class Archive>
void fields(Archive& archive, Outcome& outcome) {
    all(archive, outcome.id, outcome.tag, outcome.kind, outcome.slot, outcome.t, outcome.error,
        outcome.result, outcome.reason, outcome.progress, outcome.rounded, outcome.not_retained,
        outcome.quality, outcome.value, outcome.written, outcome.read_back, outcome.trigger);
}

template <class Archive>
void fields(Archive& archive, ValueChanged& body) {
    all(archive, body.slot, body.value, body.quality, body.reason, body.good_at, body.sampled_at,
        body.good_before, body.batch);
}

template <class Archive>
void fields(Archive& archive, DeviceStateChanged& body) {
    all(archive, body.line, body.device, body.state, body.failure, body.shown, body.changes, body.in);
}

template <class Archive>
void fields(Archive& archive, LinkChanged& body) {
    all(archive, body.line, body.up, body.why, body.repeated, body.in);
}

template <class Archive>
void fields(Archive& archive, PeriodOverrun& body) {
    all(archive, body.request, body.period, body.real, body.overrun);
}

template <class Archive>
void fields(Archive& archive, DelaysFound& body) {
    auto& finding = body.finding;
    all(archive, body.line, body.device, finding.setting, finding.delay, finding.limit, finding.advised,
        finding.count, finding.later);
}

template <class Archive>
void fields(Archive& archive, NoiseFound& body) {
    all(archive, body.line, body.device, body.finding.least, body.finding.most);
}

template <class Archive>
void fields(Archive& archive, SurplusFound& body) {
    all(archive, body.line, body.device);
}

template <class Archive>
void fields(Archive& archive, WriteWaiting& body) {
    all(archive, body.request, body.variable);
}

template <class Archive>
void fields(Archive& archive, VerifyFailed& body) {
    all(archive, body.slot, body.written, body.read_back);
}

template <class Archive>
void fields(Archive& archive, GapLearnt& body) {
    auto& event = body.gap_event;
    all(archive, body.line, event.kind, event.device, event.read, event.items.first, event.items.last,
        event.exception);
}

template <class Archive>
void fields(Archive& archive, WriteFinished& body) {
    all(archive, body.outcome, body.session);
}

template <class Archive>
void fields(Archive& archive, Notice& body) {
    all(archive, body.severity, body.code, body.error);
    auto count = body.arguments.size();
    fields(archive, count);
    if constexpr (Archive::kReads) body.arguments.resize(count);
    for (auto& [name, text] : body.arguments) all(archive, name, text);
}

template <class Archive>
void fields(Archive& archive, ConfigurationChanged& body) {
    fields(archive, body.generation);
}

template <class Archive>
void fields(Archive& archive, wire::Pdu& pdu) {
    if constexpr (Archive::kReads) {
        pdu.clear();
        for (const char byte : archive.bytes()) pdu.push_back(static_cast<std::uint8_t>(byte));
    } else {
        archive.bytes({reinterpret_cast<const char*>(pdu.data()), pdu.size()});
    }
}

// A reason is one of these constants.
std::string_view audit_reason(std::string_view text) {
    constexpr std::array<std::string_view, 5> kReasons{"rule", "read_only", "rate", "exception",
                                                       "disconnected"};
    const auto found = std::ranges::find(kReasons, text);
    return found == kReasons.end() ? std::string_view() : *found;
}

template <class Archive>
void fields(Archive& archive, endpoint::AuditRecord::Items& items) {
    all(archive, items.area, items.start, items.count);
}

template <class Archive>
void fields(Archive& archive, AuditRecorded& body) {
    auto& record = body.record;
    auto time = record.time.time_since_epoch().count();
    fields(archive, time);
    if constexpr (Archive::kReads) {
        using Clock = std::chrono::system_clock;
        record.time = Clock::time_point(Clock::duration(time));
        record.peer.assign(archive.bytes());
        record.why = audit_reason(archive.bytes());
    } else {
        archive.bytes(record.peer.view());
        archive.bytes(record.why);
    }
    all(archive, record.event, record.unit, record.broadcast, record.function, record.items,
        record.old_values, record.new_values, record.request, record.exception, record.own_unit,
        record.relayed_to, record.outcome);
}

template <class Archive>
void fields(Archive& archive, EventsLost& body) {
    fields(archive, body.count);
}

template <class Archive>
void fields(Archive& archive, Event& event) {
    all(archive, event.generation, event.t, event.body);
}

}  // namespace

// The writer only reads what it visits.
void encode(const Event& event, std::vector<std::uint64_t>& record) {
    WordWriter writer(record);
    fields(writer, const_cast<Event&>(event));
}

// The members of Event and ValueChanged in their order; checked by a test against the other encode().
void encode(std::uint32_t generation, const value::Event& changed, std::vector<std::uint64_t>& record) {
    WordWriter writer(record);
    auto& event = const_cast<value::Event&>(changed);
    std::size_t alternative_index = 0;
    all(writer, generation, event.t, alternative_index, event.slot, event.value, event.quality, event.reason,
        event.good_at, event.sampled_at, event.good_before, event.batch);
}

Event decode_event(std::span<const std::uint64_t> record) {
    RecordReader reader(record);
    Event event;
    fields(reader, event);
    return event;
}

void encode(const TrafficView& frame, std::vector<std::uint64_t>& record) {
    WordWriter writer(record);
    auto numbers = frame;  // members are visited as if they were written
    all(writer, numbers.generation, numbers.source.kind, numbers.source.index, numbers.t, numbers.direction,
        numbers.unit.value, numbers.fault, numbers.incident, numbers.after, numbers.instead);
    writer.bytes(frame.peer);
    for (const auto bytes : {frame.pdu, frame.raw})
        writer.bytes({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

TrafficRecord decode_traffic(std::span<const std::uint64_t> record) {
    RecordReader reader(record);
    TrafficRecord result;
    all(reader, result.generation, result.source.kind, result.source.index, result.t, result.direction,
        result.unit.value, result.fault, result.incident, result.after, result.instead, result.peer,
        result.pdu, result.raw);
    return result;
}

}  // namespace takt::host
