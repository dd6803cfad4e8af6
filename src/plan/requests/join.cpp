// How reads and writes share entries: 0x17, and entries of both of the same items.
#include <algorithm>
#include <deque>
#include <iterator>
#include <map>
#include <tuple>
#include <utility>

#include "requests/write_pass.hpp"
#include "timing/admission.hpp"

namespace takt::plan {
namespace {

using wire::Function;

bool in_written_range(const Request& write, const model::Variable& v) {
    const std::uint32_t first = v.start();
    return first < std::uint32_t{write.start} + write.quantity && first + v.registers > write.start;
}

class Joiner {
public:
    Joiner(const model::Project& project, const model::Line& line, const model::Device& device)
        : project_(project), line_(line), device_(device) {}

    std::vector<Request> join(std::vector<Request> reads, std::vector<Request> writes);

private:
    void pair_triggered();
    void pair(Request& read, const Request& write);
    void merge();
    [[nodiscard]] bool fits(const Request& read, const Request& write) const;
    [[nodiscard]] bool clear(const Request& read, const Request& write) const;
    [[nodiscard]] bool mergeable(const Request& read, const Request& write) const;

    const model::Project& project_;
    const model::Line& line_;
    const model::Device& device_;
    std::vector<Request> reads_;
    std::vector<Request> writes_;
    std::vector<Request> both_;  // 0x17
};

std::vector<Request> Joiner::join(std::vector<Request> reads, std::vector<Request> writes) {
    reads_ = std::move(reads);
    writes_ = std::move(writes);
    if (device_.fc23) pair_triggered();
    merge();
    std::sort(both_.begin(), both_.end(), [](const Request& a, const Request& b) {
        return std::tie(a.start, a.write_start, a.variables) < std::tie(b.start, b.write_start, b.variables);
    });
    std::move(both_.begin(), both_.end(), std::back_inserter(reads_));
    std::move(writes_.begin(), writes_.end(), std::back_inserter(reads_));
    return std::move(reads_);
}

// Each pair saves the fixed part of one transaction, so any maximal pairing is optimal. Order: ascending
// start.
void Joiner::pair_triggered() {
    std::map<model::LocalIndex, std::deque<Request*>> triggered;
    for (Request& read : reads_)
        if (read.read == Function::read_holding_registers && read.read_trigger)
            triggered[*read.read_trigger].push_back(&read);
    std::vector<Request> rest;
    for (Request& write : writes_) {
        const bool registers = write.write == Function::write_single_register ||
                               write.write == Function::write_multiple_registers;
        const auto known = write.write_trigger ? triggered.find(*write.write_trigger) : triggered.end();
        if (known != triggered.end() && registers && !write.read_modify_write) {
            auto& candidates = known->second;
            const auto found = std::find_if(candidates.begin(), candidates.end(), [&](const Request* read) {
                return fits(*read, write) && clear(*read, write);
            });
            if (found != candidates.end()) {
                pair(**found, write);
                candidates.erase(found);
                continue;
            }
        }
        rest.push_back(std::move(write));
    }
    writes_ = std::move(rest);
    std::erase_if(reads_, [](const Request& read) { return !read.read; });
}

// Polling continues without the trigger, so the polled request must not write.
void Joiner::pair(Request& read, const Request& write) {
    Request both = read;
    both.read = both.write = Function::read_write_multiple_registers;
    both.period.reset();
    both.phase = Duration::zero();
    both.write_trigger = write.write_trigger;
    both.write_on_change = write.write_on_change;
    both.write_start = write.start;
    both.write_quantity = write.quantity;
    both.admission = write.admission;
    both.deadline.reset();
    if (both.status != write.status) both.status.reset();
    auto& all = both.variables;
    all.insert(all.end(), write.variables.begin(), write.variables.end());
    std::sort(all.begin(), all.end(), [this](std::size_t a, std::size_t b) {
        const auto& first = device_.variables[a];
        const auto& second = device_.variables[b];
        return std::tuple(first.start(), first.bit, a) < std::tuple(second.start(), second.bit, b);
    });
    all.erase(std::unique(all.begin(), all.end()), all.end());
    both_.push_back(std::move(both));
    if (read.period)
        read.read_trigger.reset();
    else
        read.read.reset();  // all of its variables were moved
}

// The written items must follow from the range alone.
bool Joiner::clear(const Request& read, const Request& write) const {
    return std::none_of(read.variables.begin(), read.variables.end(), [&](std::size_t index) {
        const bool written =
            std::find(write.variables.begin(), write.variables.end(), index) != write.variables.end();
        return !written && in_written_range(write, device_.variables[index]);
    });
}

bool Joiner::fits(const Request& read, const Request& write) const {
    constexpr auto kBoth = Function::read_write_multiple_registers;
    const std::size_t asked = wire::request_pdu_length(kBoth, read.quantity, write.quantity);
    const wire::FrameLimits limits = project_.frame_limits();
    const bool in_buffer =
        limits.frame_buffer == 0 || wire::frame_length(line_.framing, asked) <= limits.frame_buffer;
    return asked <= wire::kMaxPdu && in_buffer &&
           read.quantity <= wire::max_items(line_.framing, kBoth, limits);
}

bool Joiner::mergeable(const Request& read, const Request& write) const {
    const bool causes_agree =
        !read.read_trigger || trigger_admission(project_, read.read_trigger) == write.admission;
    return !read.write && causes_agree && read.start == write.start && read.quantity == write.quantity &&
           read.variables == write.variables;
}

void Joiner::merge() {
    std::multimap<std::size_t, Request*> by_first;
    for (Request& read : reads_) by_first.emplace(read.variables.front(), &read);
    std::vector<Request> rest;
    for (Request& write : writes_) {
        const auto [begin, end] = by_first.equal_range(write.variables.front());
        const auto found =
            std::find_if(begin, end, [&](const auto& e) { return mergeable(*e.second, write); });
        if (found == end) {
            rest.push_back(std::move(write));
            continue;
        }
        Request& read = *found->second;
        read.write = write.write;
        read.write_trigger = write.write_trigger;
        read.write_on_change = write.write_on_change;
        read.read_modify_write = write.read_modify_write;
        read.admission = write.admission;
    }
    writes_ = std::move(rest);
}

}  // namespace

std::vector<Request> joined(const model::Project& project, const model::Line& line,
                            const model::Device& device, std::vector<Request> reads,
                            std::vector<Request> writes) {
    return Joiner(project, line, device).join(std::move(reads), std::move(writes));
}

}  // namespace takt::plan
