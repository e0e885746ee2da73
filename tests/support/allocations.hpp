/// @file  Counts what this thread takes from the heap. Include in exactly one source file of a program: it
/// replaces operator new. The others include allocation_count.hpp.
#pragma once

#include <cstddef>
#include <cstdlib>
#include <new>

#include "tests/support/allocation_count.hpp"

namespace motionlab::test {

inline void* counted(std::size_t size) {
  ++allocations;
  void* memory = std::malloc(size == 0 ? 1 : size);
  if (memory == nullptr) throw std::bad_alloc{};
  return memory;
}

inline void* counted(std::size_t size, std::align_val_t alignment) {
  ++allocations;
  const auto a = static_cast<std::size_t>(alignment);
  void* memory = std::aligned_alloc(a, (size + a - 1) / a * a);
  if (memory == nullptr) throw std::bad_alloc{};
  return memory;
}

}  // namespace motionlab::test

void* operator new(std::size_t size) {
  return motionlab::test::counted(size);
}
void* operator new[](std::size_t size) {
  return motionlab::test::counted(size);
}
void* operator new(std::size_t size, std::align_val_t alignment) {
  return motionlab::test::counted(size, alignment);
}
void* operator new[](std::size_t size, std::align_val_t alignment) {
  return motionlab::test::counted(size, alignment);
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
void operator delete(void* memory, std::align_val_t) noexcept {
  std::free(memory);
}
void operator delete[](void* memory, std::align_val_t) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept {
  std::free(memory);
}
void operator delete[](void* memory, std::size_t, std::align_val_t) noexcept {
  std::free(memory);
}
