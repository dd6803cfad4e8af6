// Replaces operator new of the test program that has it; the aligned forms are not counted.
#include "allocations.hpp"

#include <cstdlib>
#include <new>
#include <utility>

namespace {

thread_local bool t_counting = false;
thread_local takt::test::Allocations t_allocations;

void* counted(std::size_t size) {
    if (t_counting) {
        ++t_allocations.count;
        t_allocations.bytes += size;
    }
    void* const memory = std::malloc(size == 0 ? 1 : size);
    if (!memory) std::abort();
    return memory;
}

}  // namespace

void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
    return counted(size);
}
void* operator new[](std::size_t size, const std::nothrow_t&) noexcept {
    return counted(size);
}
void operator delete(void* memory, const std::nothrow_t&) noexcept {
    std::free(memory);
}
void operator delete[](void* memory, const std::nothrow_t&) noexcept {
    std::free(memory);
}
void* operator new(std::size_t size) {
    return counted(size);
}
void* operator new[](std::size_t size) {
    return counted(size);
}
void operator delete(void* memory) noexcept {
    std::free(memory);
}
void operator delete[](void* memory) noexcept {
    std::free(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
    std::free(memory);
}
void operator delete[](void* memory, std::size_t) noexcept {
    std::free(memory);
}

namespace takt::test {

Allocations allocations() {
    return t_allocations;
}

CountingAllocations::CountingAllocations() : before_(std::exchange(t_counting, true)) {}

CountingAllocations::~CountingAllocations() {
    t_counting = before_;
}

}  // namespace takt::test
