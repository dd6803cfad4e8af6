#include "held_reads.hpp"

namespace takt::poll {
namespace {

void own_response(HeldRead& read) {
    read.outcome.response = read.outcome.response.moved_to(read.response.span());
}

}  // namespace

void HeldReads::move_to(std::size_t to, std::size_t from) {
    reads_[to] = reads_[from];
    own_response(reads_[to]);
}

const HeldRead* HeldReads::add(HeldRead read) {
    if (reads_.capacity() == 0) reads_.reserve(kMost);
    const bool full = reads_.size() == kMost;
    if (full) {
        given_up_ = reads_.front();
        own_response(given_up_);
        for (std::size_t i = 1; i < reads_.size(); ++i) move_to(i - 1, i);
        reads_.pop_back();
    }
    read.response.assign(read.outcome.response.pdu());
    reads_.push_back(read);
    own_response(reads_.back());
    return full ? &given_up_ : nullptr;
}

}  // namespace takt::poll
