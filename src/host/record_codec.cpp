#include "record_codec.hpp"

#include <algorithm>
#include <bit>
#include <concepts>
#include <cstring>
#include <string>
#include <type_traits>
#include <utility>

#include "takt/base/assert.hpp"

namespace takt::host {
namespace {

/// Visits members by appending them to a record.
class RecordWriter {
public:
    static constexpr bool kReads = false;
    explicit RecordWriter(std::vector<std::uint64_t>& record) : record_(record) {}

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

template <class Archive>
void fields(Archive& archive, value::SlotId& slot) {
    fields(archive, slot.value);
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
    fields(archive, key.line);
    fields(archive, key.device);
    fields(archive, key.read);
    fields(archive, key.write);
    fields(archive, key.start);
    fields(archive, key.quantity);
}

template <class Archive>
void fields(Archive& archive, Outcome& outcome) {
    fields(archive, outcome.id);
    fields(archive, outcome.kind);
    fields(archive, outcome.slot);
    fields(archive, outcome.t);
    fields(archive, outcome.error);
    fields(archive, outcome.result);
    fields(archive, outcome.reason);
    fields(archive, outcome.progress);
    fields(archive, outcome.rounded);
    fields(archive, outcome.not_retained);
    fields(archive, outcome.quality);
    fields(archive, outcome.value);
    fields(archive, outcome.written);
    fields(archive, outcome.read_back);
}

template <class Archive>
void fields(Archive& archive, model::Finding& finding) {
    fields(archive, finding.severity);
    fields(archive, finding.code);
    fields(archive, finding.path);
    fields(archive, finding.value);
    fields(archive, finding.allowed);
    auto count = finding.arguments.size();
    fields(archive, count);
    if constexpr (Archive::kReads) finding.arguments.resize(count);
    for (auto& [name, text] : finding.arguments) {
        fields(archive, name);
        fields(archive, text);
    }
}

template <class Archive>
void fields(Archive& archive, ValueChanged& body) {
    fields(archive, body.slot);
    fields(archive, body.value);
    fields(archive, body.quality);
    fields(archive, body.reason);
    fields(archive, body.good_at);
    fields(archive, body.batch);
}

template <class Archive>
void fields(Archive& archive, DeviceStateChanged& body) {
    fields(archive, body.line);
    fields(archive, body.device);
    fields(archive, body.state);
}

template <class Archive>
void fields(Archive& archive, LinkChanged& body) {
    fields(archive, body.line);
    fields(archive, body.up);
    fields(archive, body.why);
}

template <class Archive>
void fields(Archive& archive, PeriodOverrun& body) {
    fields(archive, body.request);
    fields(archive, body.period);
    fields(archive, body.real);
    fields(archive, body.overrun);
}

template <class Archive>
void fields(Archive& archive, WriteWaiting& body) {
    fields(archive, body.request);
    fields(archive, body.variable);
}

template <class Archive>
void fields(Archive& archive, VerifyFailed& body) {
    fields(archive, body.slot);
    fields(archive, body.written);
    fields(archive, body.read_back);
}

template <class Archive>
void fields(Archive& archive, GapLearnt& body) {
    fields(archive, body.line);
    fields(archive, body.gap_event.kind);
    fields(archive, body.gap_event.device);
    fields(archive, body.gap_event.read);
    fields(archive, body.gap_event.items.first);
    fields(archive, body.gap_event.items.last);
    fields(archive, body.gap_event.exception);
}

template <class Archive>
void fields(Archive& archive, WriteFinished& body) {
    fields(archive, body.outcome);
    fields(archive, body.session);
}

template <class Archive>
void fields(Archive& archive, Notice& body) {
    fields(archive, static_cast<model::Finding&>(body));
    fields(archive, body.error);
}

template <class Archive>
void fields(Archive& archive, ConfigurationChanged& body) {
    fields(archive, body.generation);
}

template <class Archive>
void fields(Archive& archive, AuditRecorded& body) {
    fields(archive, body.record);
}

template <class Archive>
void fields(Archive& archive, EventsLost& body) {
    fields(archive, body.count);
}

template <class Archive>
void fields(Archive& archive, Event& event) {
    fields(archive, event.generation);
    fields(archive, event.t);
    fields(archive, event.body);
}

}  // namespace

// The writer only reads what it visits.
void encode(const Event& event, std::vector<std::uint64_t>& record) {
    RecordWriter writer(record);
    fields(writer, const_cast<Event&>(event));
}

// The members of Event and ValueChanged in their order; checked by a test against the other encode().
void encode(std::uint32_t generation, const value::Event& changed, std::optional<Instant> good_at,
            std::vector<std::uint64_t>& record) {
    RecordWriter writer(record);
    auto& event = const_cast<value::Event&>(changed);
    std::size_t alternative_index = 0;
    fields(writer, generation);
    fields(writer, event.t);
    fields(writer, alternative_index);
    fields(writer, event.slot);
    fields(writer, event.value);
    fields(writer, event.quality);
    fields(writer, event.reason);
    fields(writer, good_at);
    fields(writer, event.batch);
}

Event decode_event(std::span<const std::uint64_t> record) {
    RecordReader reader(record);
    Event event;
    fields(reader, event);
    return event;
}

void encode(std::uint32_t generation, const TrafficSource& source, Instant t, wire::Direction direction,
            UnitId unit, std::optional<wire::FrameFault> fault, Bytes pdu, Bytes raw,
            std::vector<std::uint64_t>& record) {
    RecordWriter writer(record);
    auto kind = source.kind;
    auto index = source.index;
    fields(writer, generation);
    fields(writer, kind);
    fields(writer, index);
    fields(writer, t);
    fields(writer, direction);
    fields(writer, unit.value);
    fields(writer, fault);
    writer.bytes({reinterpret_cast<const char*>(pdu.data()), pdu.size()});
    writer.bytes({reinterpret_cast<const char*>(raw.data()), raw.size()});
}

TrafficRecord decode_traffic(std::span<const std::uint64_t> record) {
    RecordReader reader(record);
    TrafficRecord result;
    fields(reader, result.generation);
    fields(reader, result.source.kind);
    fields(reader, result.source.index);
    fields(reader, result.t);
    fields(reader, result.direction);
    fields(reader, result.unit.value);
    fields(reader, result.fault);
    fields(reader, result.pdu);
    fields(reader, result.raw);
    return result;
}

}  // namespace takt::host
