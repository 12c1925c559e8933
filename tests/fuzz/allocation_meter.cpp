// SPDX-License-Identifier: Apache-2.0
#include "fuzz/allocation_meter.hpp"

#include <atomic>
#include <cstdlib>
#include <new>

namespace {
std::atomic<std::size_t> allocated{0};
}

namespace cairn::testing {
std::size_t allocated_bytes() { return allocated.load(std::memory_order_relaxed); }
}  // namespace cairn::testing

void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  allocated.fetch_add(size, std::memory_order_relaxed);
  return std::malloc(size);
}
void* operator new(std::size_t size) {
  if (void* memory = operator new(size, std::nothrow)) return memory;
  throw std::bad_alloc();
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
