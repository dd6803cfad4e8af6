// Streams are the connected components of the graph whose nodes are polled requests with a period and whose
// edges join requests with a common variable.
#include "timing/streams.hpp"

#include <algorithm>
#include <limits>
#include <numeric>
#include <optional>

namespace takt::plan {
namespace {

constexpr std::size_t kNobody = std::numeric_limits<std::size_t>::max();

// Union-find over requests. The least index of a set represents it.
class Sets {
public:
    explicit Sets(std::size_t count) : parents_(count) {
        std::iota(parents_.begin(), parents_.end(), std::size_t{0});
    }
    std::size_t find(std::size_t i) {
        while (parents_[i] != i) i = parents_[i] = parents_[parents_[i]];
        return i;
    }
    void unite(std::size_t a, std::size_t b) {
        a = find(a);
        b = find(b);
        parents_[std::max(a, b)] = std::min(a, b);
    }

private:
    std::vector<std::size_t> parents_;
};

Sets sharing_variables(const model::Line& line, const std::vector<Request>& requests) {
    Sets sets(requests.size());
    std::vector<std::vector<std::size_t>> readers(line.devices.size());
    for (std::size_t i = 0; i < requests.size(); ++i) {
        if (!is_periodic(requests[i])) continue;
        auto& readers_of = readers[requests[i].device];
        readers_of.resize(line.devices[requests[i].device].variables.size(), kNobody);
        for (const std::size_t variable : requests[i].variables) {
            std::size_t& reader = readers_of[variable];
            if (reader == kNobody) reader = i;
            sets.unite(i, reader);
        }
    }
    return sets;
}

std::optional<Duration> least_deadline_or_period(const model::Device& device, const Request& request) {
    std::optional<Duration> least;
    for (const std::size_t index : request.variables) {
        const model::Variable& variable = device.variables[index];
        const Duration own = variable.deadline.value_or(variable.period);
        least = std::min(least.value_or(own), own);
    }
    return least;
}

}  // namespace

void number_streams(const model::Line& line, std::vector<Request>& requests) {
    Sets sets = sharing_variables(line, requests);
    std::vector<std::optional<Duration>> deadlines;  // of each stream
    for (std::size_t i = 0; i < requests.size(); ++i) {
        Request& request = requests[i];
        if (is_periodic(request))
            request.deadline = least_deadline_or_period(line.devices[request.device], request);
        const std::size_t first = sets.find(i);
        if (first == i) {
            request.stream = deadlines.size();
            deadlines.push_back(request.deadline);
            continue;
        }
        request.stream = requests[first].stream;
        auto& deadline = deadlines[request.stream];
        if (request.deadline) deadline = std::min(deadline.value_or(*request.deadline), *request.deadline);
    }
    for (Request& request : requests)
        if (is_periodic(request)) request.deadline = deadlines[request.stream];
}

}  // namespace takt::plan
