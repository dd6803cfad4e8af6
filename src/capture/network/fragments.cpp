// The holes of a datagram are kept as in RFC 815.
#include "network/fragments.hpp"

#include <algorithm>

namespace takt::capture {

FragmentTable::Datagram& FragmentTable::find(const Fragment& fragment, std::int64_t time_ns) {
    while (!datagrams_.empty() && time_ns - datagrams_.front().begun_ns > kTimeout.count()) give_up_oldest();
    const auto found = std::ranges::find_if(datagrams_, [&](const Datagram& known) {
        return known.identification == fragment.identification && known.protocol == fragment.protocol &&
               known.source == fragment.source && known.destination == fragment.destination;
    });
    if (found != datagrams_.end()) return *found;
    if (datagrams_.size() >= kMost) give_up_oldest();
    return datagrams_.emplace_back(Datagram{.source = fragment.source,
                                            .destination = fragment.destination,
                                            .identification = fragment.identification,
                                            .protocol = fragment.protocol,
                                            .begun_ns = time_ns});
}

void FragmentTable::give_up_oldest() {
    lost_ += datagrams_.front().fragments;
    datagrams_.pop_front();
}

// Copies the parts of the fragment that fall into holes, and shortens the holes.
void FragmentTable::fill(Datagram& datagram, const Fragment& fragment) {
    const auto begin = fragment.offset;
    const auto end = begin + static_cast<std::uint32_t>(fragment.payload.size());
    if (datagram.bytes.size() < end) datagram.bytes.resize(end);
    const auto holes = std::exchange(datagram.holes, {});
    for (const auto& [from, to] : holes) {
        const auto first = std::max(from, begin);
        const auto last = std::min(to, end);
        if (first >= last) {
            datagram.holes.emplace_back(from, to);
            continue;
        }
        std::copy(fragment.payload.begin() + (first - begin), fragment.payload.begin() + (last - begin),
                  datagram.bytes.begin() + first);
        if (from < first) datagram.holes.emplace_back(from, first);
        if (last < to) datagram.holes.emplace_back(last, to);
    }
    if (!fragment.more && !datagram.length) datagram.length = end;
    if (datagram.length)
        std::erase_if(datagram.holes, [&](const auto& hole) { return hole.first >= *datagram.length; });
}

std::optional<Bytes> FragmentTable::add(const Fragment& fragment, std::int64_t time_ns) {
    auto& datagram = find(fragment, time_ns);
    ++datagram.fragments;
    fill(datagram, fragment);
    if (!datagram.length || !datagram.holes.empty()) return std::nullopt;
    complete_ = std::move(datagram.bytes);
    complete_.resize(*datagram.length);
    datagrams_.remove_if([&](const Datagram& other) { return &other == &datagram; });
    return Bytes(complete_);
}

void FragmentTable::end() {
    while (!datagrams_.empty()) give_up_oldest();
}

}  // namespace takt::capture
