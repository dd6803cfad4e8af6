#include "retained_unit.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "takt/base/assert.hpp"
#include "takt/line/loop.hpp"

namespace takt::endpoint {
namespace {

using store::Durability;
using Severity = Notice::Severity;
using wire::Area;

constexpr Duration kReportEvery = std::chrono::seconds(1);
constexpr unsigned kBitsInARegister = 16;

bool exists(const serve::Banks& banks, Area area, serve::AddressRange items, unsigned& missing) {
    for (missing = items.first; missing <= items.last; ++missing)
        if (!banks.readable(area, static_cast<std::uint16_t>(missing), 1)) return false;
    return true;
}

/// The registers under bits of an overlaid bank.
serve::AddressRange under(const serve::BitBank& bank, unsigned first, unsigned last) {
    const auto register_of = [&bank](unsigned address) {
        return static_cast<std::uint16_t>(bank.overlay->first + (address - bank.first) / kBitsInARegister);
    };
    return {register_of(first), register_of(last)};
}

std::vector<serve::AddressRange> merged(std::vector<serve::AddressRange> ranges) {
    std::ranges::sort(ranges, {}, &serve::AddressRange::first);
    std::vector<serve::AddressRange> all;
    for (const auto& range : ranges)
        if (!all.empty() && range.first <= all.back().last + 1U)
            all.back().last = std::max(all.back().last, range.last);
        else
            all.push_back(range);
    return all;
}

}  // namespace

RetainedUnit::RetainedUnit(serve::Unit& unit, RetainSpec spec, PendingAnswers& pending, NoticeSink notify)
    : unit_(unit), spec_(std::move(spec)), pending_(pending), notify_(std::move(notify)) {}

// Bits that lie over registers are kept with these.
Result<store::RegisterLayout> RetainedUnit::layout() {
    std::array<std::vector<serve::AddressRange>, 4> items = spec_.items;
    for (std::size_t i = 0; i < spec_.items.size(); ++i) {
        const Area area{static_cast<std::uint8_t>(i)};
        for (const auto& range : spec_.items[i])
            if (unsigned missing = 0; !exists(unit_.banks, area, range, missing))
                return fail(Code::not_found, std::string(wire::name(area)) + " " + std::to_string(missing));
        if (!wire::is_bit_area(area) || !unit_.banks.bits(area).overlay) continue;
        const serve::BitBank& bits = unit_.banks.bits(area);
        for (const auto& range : spec_.items[i])
            items[static_cast<std::size_t>(bits.overlay->area)].push_back(
                under(bits, range.first, range.last));
        items[i].clear();
    }
    store::RegisterLayout layout{unit_.id.value, {}};
    pieces_.clear();
    for (std::size_t i = 0; i < items.size(); ++i) {
        const Area area{static_cast<std::uint8_t>(i)};
        for (const auto& range : merged(items[i])) {
            pieces_.push_back({area, range, layout.bytes()});
            layout.ranges.push_back(
                {static_cast<std::uint8_t>(area), wire::is_bit_area(area), range.first, range.last});
        }
    }
    constexpr auto kMost = store::RegisterLayout::kMostRanges;
    if (pieces_.size() > kMost)
        return fail(Code::too_long, spec_.path, static_cast<std::int64_t>(pieces_.size()),
                    static_cast<std::int64_t>(kMost));
    return layout;
}

/// The bytes of an image that hold items first..last of a piece.
void RetainedUnit::append(const Piece& piece, unsigned first, unsigned last,
                          std::vector<std::uint8_t>& bytes) const {
    const serve::Banks& banks = unit_.banks;
    if (!wire::is_bit_area(piece.area)) {
        for (unsigned item = first; item <= last; ++item) {
            const unsigned value = banks.registers(piece.area).get(static_cast<std::uint16_t>(item));
            bytes.push_back(static_cast<std::uint8_t>(value >> 8));
            bytes.push_back(static_cast<std::uint8_t>(value));
        }
        return;
    }
    for (unsigned at = (first - piece.items.first) / 8; at <= (last - piece.items.first) / 8; ++at) {
        unsigned byte = 0;
        for (unsigned bit = 0; bit < 8; ++bit) {
            const unsigned item = piece.items.first + at * 8 + bit;
            if (item <= piece.items.last && banks.bit(piece.area, static_cast<std::uint16_t>(item)))
                byte |= 1U << bit;
        }
        bytes.push_back(static_cast<std::uint8_t>(byte));
    }
}

std::vector<std::uint8_t> RetainedUnit::image() const {
    std::vector<std::uint8_t> bytes;
    for (const auto& piece : pieces_) append(piece, piece.items.first, piece.items.last, bytes);
    return bytes;
}

void RetainedUnit::restore(Bytes image) {
    serve::Banks& banks = unit_.banks;
    for (const auto& piece : pieces_)
        for (unsigned item = piece.items.first; item <= piece.items.last; ++item) {
            const auto address = static_cast<std::uint16_t>(item);
            const std::size_t index = item - piece.items.first;
            if (wire::is_bit_area(piece.area)) {
                banks.set_bit(piece.area, address, (image[piece.offset + index / 8] >> (index % 8) & 1) != 0);
            } else {
                const std::size_t at = piece.offset + 2 * index;
                banks.registers(piece.area)
                    .set(address, static_cast<std::uint16_t>(image[at] << 8 | image[at + 1]));
            }
        }
}

Result<void> RetainedUnit::open(Post post) {
    TAKT_TRY(const auto items, layout());
    auto opened = store::open_registers(spec_.path, items, image());
    if (!opened && opened.error().code == Code::unsupported)
        notify_({Severity::error, "endpoint.registers.foreign", {{"file", spec_.path}}, {}});
    if (!opened) return std::unexpected(opened.error());
    report(*opened);
    begin(*std::move(opened), std::move(post));
    return {};
}

void RetainedUnit::begin(store::OpenedRegisters opened, Post post) {
    restore(opened.file.image());
    store::RegisterWriter::Options options;
    options.durability = spec_.durability;
    options.on_progress = [this, post = std::move(post), alive = std::weak_ptr(alive_)] {
        post([this, alive] {
            if (!alive.expired()) settle();
        });
    };
    writer_ = std::make_unique<store::RegisterWriter>(std::move(opened.storage), std::move(opened.file),
                                                      std::move(options));
}

void RetainedUnit::report(const store::OpenedRegisters& opened) const {
    Notice notice;
    const bool damaged = !opened.set_aside.empty();
    if (opened.is_new && !damaged) notice.severity = Severity::status;
    if (opened.is_new)
        notice.code = damaged ? "endpoint.registers.damaged" : "endpoint.registers.new";
    else if (opened.other_layout)
        notice.code = "endpoint.registers.other_layout";
    else if (opened.was_damaged)
        notice.code = "endpoint.registers.one_copy";
    if (notice.code.empty()) return;
    notice.arguments = {{"file", spec_.path},
                        {"unit", std::to_string(unit_.id.value)},
                        {"aside", opened.set_aside},
                        {"taken", std::to_string(opened.taken)},
                        {"missing", std::to_string(opened.missing)},
                        {"number", std::to_string(opened.file.sequence())}};
    notify_(notice);
}

std::optional<wire::ExceptionCode> RetainedUnit::before(const serve::Context&, const serve::Access& access) {
    if (access.write && waiting_.size() >= kMostWaiting) return wire::ExceptionCode::server_device_busy;
    return std::nullopt;
}

void RetainedUnit::written(const serve::Context&, const serve::Access& access) {
    if (!writer_) return;
    Area area = access.area;
    serve::AddressRange items{access.start, static_cast<std::uint16_t>(access.start + access.count - 1U)};
    if (wire::is_bit_area(area) && unit_.banks.bits(area).overlay) {
        const serve::BitBank& bits = unit_.banks.bits(area);
        items = under(bits, items.first, items.last);
        area = bits.overlay->area;
    }
    collect_changes(area, items);
    if (changes_.empty()) return;
    // A write that changes nothing waits for the earlier one that brought these values.
    const std::uint64_t ticket = writer_->change(changes_);
    if (spec_.durability == Durability::acknowledged && ticket > durable_)
        waiting_.push_back({ticket, pending_.put_off()});
}

void RetainedUnit::collect_changes(Area area, serve::AddressRange items) {
    constexpr std::size_t kMostBytes = 1024;  // of one request: the spans below stay where they are
    bytes_.clear();
    bytes_.reserve(kMostBytes);
    changes_.clear();
    for (const auto& piece : pieces_) {
        const unsigned first = std::max(piece.items.first, items.first);
        const unsigned last = std::min(piece.items.last, items.last);
        if (piece.area != area || first > last) continue;
        const std::size_t index = first - piece.items.first;
        const std::size_t begin = bytes_.size();
        append(piece, first, last, bytes_);
        TAKT_ASSERT(bytes_.size() <= kMostBytes);
        changes_.push_back(
            {piece.offset + (wire::is_bit_area(area) ? index / 8 : 2 * index), Bytes(bytes_).subspan(begin)});
    }
}

// An entry is removed before it is reported as done: its client may write again from inside done(), and that
// write waits anew.
void RetainedUnit::settle() {
    const auto progress = writer_->progress();
    durable_ = progress.durable;
    if (progress.failed && (progress.stopped || spec_.durability != Durability::acknowledged))
        return reject_all(progress.why);
    while (!waiting_.empty() && waiting_.front().ticket <= durable_) {
        const serve::Token token = waiting_.front().token;
        waiting_.pop_front();
        pending_.done(token);
    }
}

void RetainedUnit::reject_all(const Error& why) {
    const Instant t = line::now();
    if (t >= next_report_) {
        next_report_ = after(t, kReportEvery);
        notify_(
            {Severity::error, "endpoint.registers.failed", {{"unit", std::to_string(unit_.id.value)}}, why});
    }
    if (spec_.durability != Durability::acknowledged) return;
    std::vector<std::uint8_t> durable;
    writer_->roll_back(durable);
    restore(durable);
    if (!waiting_.empty()) durable_ = waiting_.back().ticket;
    for (const Waiting& rejected : std::exchange(waiting_, {}))
        pending_.done(rejected.token, wire::ExceptionCode::server_device_failure);
}

void RetainedUnit::finish() {
    if (!writer_) return;
    settle();
    writer_->close();
    settle();
}

RetainedStatistics RetainedUnit::statistics() const {
    return {unit_.id, spec_.path, writer_ ? writer_->counters() : store::RegisterFile::Counters{}};
}

void RetainedUnit::refresh(RetainedStatistics& statistics) const {
    if (writer_) statistics.written = writer_->counters();
}

}  // namespace takt::endpoint
