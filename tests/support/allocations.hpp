// Counts what a test allocates. The test program has tests/support/allocations.cpp among its sources.
#pragma once

#include <cstddef>

namespace takt::test {

struct Allocations {
    std::size_t count = 0;
    std::size_t bytes = 0;
};

/// The allocations of the calling thread while it counted.
[[nodiscard]] Allocations allocations();

/// The calling thread counts while this lives.
class CountingAllocations {
public:
    CountingAllocations();
    ~CountingAllocations();
    CountingAllocations(const CountingAllocations&) = delete;
    CountingAllocations& operator=(const CountingAllocations&) = delete;

private:
    bool before_;
};

}  // namespace takt::test
